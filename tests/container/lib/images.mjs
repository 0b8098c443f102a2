// The images: the base, those of docker/Dockerfile, and nginx with the configuration of docker/.
import {createWriteStream, existsSync, mkdirSync, mkdtempSync, readdirSync, readFileSync} from 'node:fs';
import {tmpdir} from 'node:os';
import {join} from 'node:path';
import {fileURLToPath} from 'node:url';
import {docker, inspect, must} from './docker.mjs';
import {runAsRoot} from './engine.mjs';

export const root = fileURLToPath(new URL('../../../', import.meta.url));
export const image = (name) => `rivage-test/${name}`;
const kPublicBase = 'debian:bookworm-slim';

export class Images {
  constructor(engine) {
    this.engine = engine;
    mkdirSync(join(root, 'build'), {recursive: true});
    this.log = createWriteStream(join(root, 'build/container-test.log'));
  }

  async makeAll() {
    await this.#makeBase();
    for (const target of ['server', 'client', 'test']) await this.#build(image(target), ['--target', target]);
    await this.#makeBare();
    await this.#build(image('bare-server'), ['--target', 'server', '--build-arg', `BASE=${image('bare')}`]);
    await this.#build(image('nginx'), ['--build-arg', `BASE=${image('base')}`], 'tests/container/images/nginx.Dockerfile');
  }

  // Debian from a registry; where none can be reached, from Debian's mirror by debootstrap.
  async #makeBase() {
    if ((await docker(['image', 'inspect', image('base')])).code === 0) return;
    if ((await docker(['pull', kPublicBase], {log: this.log})).code === 0) {
      await must(['tag', kPublicBase, image('base')]);
      return;
    }
    console.log(`no registry gives ${kPublicBase}: making it with debootstrap`);
    const folder = mkdtempSync(join(tmpdir(), 'rivage-base-'));
    const script = `
      debootstrap --variant=minbase bookworm '${folder}'
      mirror="$(awk '$1 == "deb" {print $2; exit}' '${folder}/etc/apt/sources.list')"
      for part in "$mirror bookworm" "$mirror bookworm-updates" "$mirror-security bookworm-security"; do
          echo "deb $part main"
      done >'${folder}/etc/apt/sources.list'
      rm -rf '${folder}'/var/cache/apt/archives/*.deb '${folder}'/var/lib/apt/lists/*
      tar -C '${folder}' -cf '${folder}.tar' .`;
    const made = await runAsRoot(['bash', '-euc', script], {log: this.log});
    if (made.code === 0) await must(['import', `${folder}.tar`, image('base')]);
    await runAsRoot(['rm', '-rf', folder, `${folder}.tar`]);
    if (made.code !== 0) throw new Error(`debootstrap failed: ${made.errors.slice(-500)}`);
  }

  // A base with the C and C++ libraries and nothing else: no shell, no other program.
  async #makeBare() {
    if ((await docker(['image', 'inspect', image('bare')])).code === 0) return;
    // Files by the folders that they really lie in: /lib and /lib64 are links.
    const script = `cd /; { find lib lib64 -maxdepth 0 -type l
      dpkg -L libc6 libgcc-s1 libstdc++6 | grep -E '^/(usr/)?lib.*(\\.so(\\.|$)|/ld-)' | sed 's|^/usr/||; s|^/||; s|^|usr/|'; } >/tmp/list
      tar --no-recursion -cf - -T /tmp/list`;
    const tar = await must(['run', '--rm', '--network', 'none', image('base'), 'bash', '-euc', script]);
    await must(['import', '-', image('bare')], {input: tar.out});
  }

  async #build(name, args, file = 'docker/Dockerfile') {
    const classic = (await docker(['buildx', 'version'])).code !== 0;
    const ended = await docker(['build', '--file', join(root, file), '--tag', name,
      ...(this.engine.own ? ['--network', 'host'] : []), ...this.#arguments(file), ...args, root],
      {log: this.log, timeout: 3600000, env: classic ? {DOCKER_BUILDKIT: '0'} : {}});
    if (ended.code !== 0)
      throw new Error(`${name} could not be built; the end of build/container-test.log:\n${(ended.text + ended.errors).slice(-3000)}`);
  }

  // What this machine needs to reach its mirrors, if anything.
  #arguments(file) {
    if (file !== 'docker/Dockerfile') return [];
    const values = {BASE: image('base'), BUILD_BASE: image('base'), EXTRA_CA: localAuthorities(),
      APT_MIRROR: process.env.RIVAGE_APT_MIRROR, NPM_REGISTRY: process.env.npm_config_registry};
    for (const name of ['http_proxy', 'https_proxy', 'no_proxy']) values[name] = process.env[name];
    return Object.entries(values).filter(([, value]) => value)
      .flatMap(([name, value]) => ['--build-arg', `${name}=${value}`]);
  }

  // Bytes of an image beyond its base.
  async sizes() {
    const base = await inspect(image('base'), '.Size');
    const own = async (name) => await inspect(image(name), '.Size') - base;
    return {base, server: await own('server'), client: await own('client')};
  }

  // In an engine of our own, also what earlier builds left behind.
  async removeAll() {
    if (this.engine.own) {
      await must(['system', 'prune', '--all', '--force', '--volumes']);
      return;
    }
    const names = (await docker(['images', '--format', '{{.Repository}}:{{.Tag}}', 'rivage-test/*'])).text;
    if (names) await docker(['rmi', '--force', ...names.split('\n')]);
  }
}

// Certificates that the administrator of this machine added, as a proxy may need.
function localAuthorities() {
  const folder = '/usr/local/share/ca-certificates';
  if (!existsSync(folder)) return '';
  return readdirSync(folder).filter((name) => name.endsWith('.crt'))
    .map((name) => readFileSync(join(folder, name), 'utf8').trim()).join('\n');
}
