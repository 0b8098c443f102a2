// What the images are.
import assert from 'node:assert/strict';
import {inspect, must} from '../lib/docker.mjs';
import {image} from '../lib/images.mjs';

const kMostBytes = 60e6;

async function fileOf(name, path) {
  const id = (await must(['create', image(name)])).text;
  try {
    const {out} = await must(['cp', `${id}:${path}`, '-']);
    return out.subarray(512, 512 + parseInt(out.toString('latin1', 124, 136), 8)).toString();
  } finally {
    await must(['rm', '-v', id]);
  }
}

// Paths in an image.
async function filesOf(name) {
  const id = (await must(['create', image(name), 'x'])).text;
  try {
    const {out} = await must(['export', id]);
    const paths = [];
    for (let at = 0; at + 512 <= out.length && out[at];) {
      const text = (from, to) => out.toString('latin1', at + from, at + to).replace(/\0.*$/s, '');
      const size = parseInt(text(124, 136), 8) || 0;
      paths.push((text(345, 500) ? `${text(345, 500)}/` : '') + text(0, 100));
      at += 512 + Math.ceil(size / 512) * 512;
    }
    return paths;
  } finally {
    await must(['rm', '-v', id]);
  }
}

export default [
  {
    name: 'image: no root, an entry point without a shell, SIGTERM, a health check by its own program, labels',
    fault: 'the image of the tests in its place',
    async run(world, broken) {
      for (const name of broken ? ['test'] : ['server', 'client']) {
        const config = await inspect(image(name), '.Config');
        assert.equal(config.User, '65532:65532');
        assert.equal(config.Entrypoint.length, 1);
        const labels = ['title', 'description', 'licenses', 'version', 'revision', 'source'];
        for (const label of labels) assert.ok(`org.opencontainers.image.${label}` in config.Labels, label);
      }
      const server = await inspect(image('server'), '.Config');
      assert.equal(server.StopSignal, 'SIGTERM');
      assert.deepEqual(server.Healthcheck.Test, ['CMD', '/usr/bin/rivage-server', '--probe', 'live']);
      assert.deepEqual(Object.keys(server.Volumes), ['/var/lib/rivage']);
    },
  },
  {
    name: 'image: at most 60 MB beyond the base',
    fault: 'the image of the tests in its place',
    async run(world, broken) {
      const base = await inspect(image('base'), '.Size');
      for (const name of broken ? ['test'] : ['server', 'client'])
        assert.ok(await inspect(image(name), '.Size') - base <= kMostBytes, name);
    },
  },
  {
    name: 'image: the list of materials names each library, with the version that its package record has',
    fault: 'a list without the first library',
    async run(world, broken) {
      for (const name of ['server', 'client']) {
        const {bomFormat, components, metadata} = JSON.parse(await fileOf(name, '/usr/share/doc/rivage/sbom.cdx.json'));
        assert.equal(bomFormat, 'CycloneDX');
        assert.match(metadata.component.version, /^\d+\.\d+\.\d+$/);
        if (broken) components.shift();
        const files = await filesOf(name);
        const records = files.filter((path) => /^var\/lib\/dpkg\/status\.d\/./.test(path));
        assert.ok(records.length >= 3, 'records of packages');
        for (const path of records) {
          const record = await fileOf(name, `/${path}`);
          const component = components.find((one) => one.name === path.split('/').pop());
          assert.ok(component, path);
          assert.equal(component.version, /^Version: (.*)$/m.exec(record)[1]);
        }
        const libraries = files.filter((path) => /^usr\/lib\/rivage\/./.test(path));
        const loaded = components.filter(({properties}) => properties.some(({value}) => value === 'loaded'));
        assert.ok(loaded.length <= libraries.length && libraries.length > 2);
      }
    },
  },
  {
    name: 'image: the main job on a base without a shell',
    fault: 'a base without the C++ library: the client\'s image cannot serve',
    async run(world, broken) {
      const grid = await world.server().then(() => world.sample());
      const files = await filesOf('bare-server');
      assert.ok(!files.some((path) => /(^|\/)(ba|da)?sh$/.test(path)), 'no shell');
      await world.server({from: image(broken ? 'client' : 'bare-server'), alias: 'bare'});
      const {code, errors} = await world.client(['regularize', '-', '-o', '-'], {input: grid, server: 'http://bare:8080'});
      assert.equal(code, 0, errors);
    },
  },
];
