// node docker/sbom.mjs PROGRAM PACKAGE...: what an image has besides its base, as CycloneDX 1.5 on
// stdout. Libraries that are loaded are the packages named; those that are compiled in come from the
// lists that the build itself reads.
import {execFileSync} from 'node:child_process';
import {readFileSync} from 'node:fs';

const [program, ...packages] = process.argv.slice(2);
const version = /project\(rivage VERSION (\S+)/.exec(readFileSync('CMakeLists.txt', 'utf8'))[1];
const architecture = execFileSync('dpkg', ['--print-architecture'], {encoding: 'utf8'}).trim();

// Packages whose headers are compiled in, by the program that has them.
const headers = ['nlohmann-json3-dev', 'libcli11-dev', 'libexpected-dev', 'libstdc++-12-dev'];
const engine = ['libeigen3-dev', 'libtinygltf-dev'];

const field = (name, what) =>
  execFileSync('dpkg-query', ['-W', `-f=\${${what}}`, name], {encoding: 'utf8'});

function fromDebian(name, how) {
  const number = field(name, 'Version');
  return {
    type: 'library',
    name,
    version: number,
    purl: `pkg:deb/debian/${encodeURIComponent(name)}@${encodeURIComponent(number)}?arch=${architecture}&distro=bookworm`,
    'bom-ref': name,
    properties: [{name: 'rivage:how', value: how},
      {name: 'rivage:source-package', value: field(name, 'source:Package')}],
  };
}

function fromNpm(name, number) {
  return {
    type: 'library', name, version: number, purl: `pkg:npm/${encodeURIComponent(name)}@${number}`,
    'bom-ref': name, properties: [{name: 'rivage:how', value: 'compiled in'}],
  };
}

function compiledIn() {
  const number = execFileSync('bash', ['-c', '. cmake/dependencies.sh; echo $httplib_version'],
    {encoding: 'utf8'}).trim();
  const httplib = {
    type: 'library', name: 'cpp-httplib', version: number,
    purl: `pkg:github/yhirose/cpp-httplib@v${number}`, 'bom-ref': 'cpp-httplib',
    properties: [{name: 'rivage:how', value: 'compiled in'}],
  };
  if (program !== 'rivage-server') return [httplib];
  const {packages: modules} = JSON.parse(readFileSync('server/web/package-lock.json', 'utf8'));
  return [httplib, fromNpm('three', modules['node_modules/three'].version)];
}

console.log(JSON.stringify({
  bomFormat: 'CycloneDX',
  specVersion: '1.5',
  version: 1,
  metadata: {component: {type: 'application', name: program, version, 'bom-ref': program,
    licenses: [{license: {id: 'Apache-2.0'}}]}},
  components: [
    ...packages.map((name) => fromDebian(name, 'loaded')),
    ...[...headers, ...(program === 'rivage-server' ? engine : [])]
      .map((name) => fromDebian(name, 'compiled in')),
    ...compiledIn(),
  ],
  dependencies: [{ref: program, dependsOn: [...packages]}],
}, null, 2));
