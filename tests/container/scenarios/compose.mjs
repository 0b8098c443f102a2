// docker/compose.yaml, as it stands but for the port on this machine and the name of the image.
import assert from 'node:assert/strict';
import {mkdtempSync, rmSync, writeFileSync} from 'node:fs';
import {tmpdir} from 'node:os';
import {join} from 'node:path';
import {docker, inspect, must, run, until} from '../lib/docker.mjs';
import {image} from '../lib/images.mjs';
import {compose as document} from '../lib/manifests.mjs';

// The command that this machine has, or nothing.
async function command() {
  if ((await docker(['compose', 'version'])).code === 0) return ['docker', 'compose'];
  if ((await run('docker-compose', ['version']).catch(() => ({code: 1}))).code === 0) return ['docker-compose'];
  return undefined;
}

export default [
  {
    name: 'compose: up, healthy, within its limits, a job, down',
    fault: 'a health check that asks for something else',
    async run(world, broken) {
      const compose = await command();
      if (!compose) return {skipped: 'neither docker compose nor docker-compose is here'};
      const changed = document();
      const {rivage} = changed.services;
      Object.assign(rivage, {image: image('server'), ports: ['127.0.0.1::8080']});
      delete rivage.build;
      if (broken) rivage.healthcheck.test[3] = 'happy';
      Object.assign(rivage.healthcheck, {interval: '1s', start_period: '1s'});
      const folder = mkdtempSync(join(tmpdir(), 'rivage-compose-'));
      const file = join(folder, 'compose.yaml');
      writeFileSync(file, JSON.stringify({version: '2.4', ...changed}));
      const call = (...args) => run(compose[0], [...compose.slice(1), '-p', world.id, '-f', file, ...args]);
      try {
        const up = await call('up', '--detach');
        assert.equal(up.code, 0, up.errors);
        const id = (await call('ps', '--quiet')).text;
        await until(async () => await inspect(id, '.State.Health.Status') === 'healthy', 'healthy', 20000);
        const limits = await inspect(id, '.HostConfig');
        assert.deepEqual([limits.Memory, limits.PidsLimit, limits.NanoCpus, limits.ReadonlyRootfs],
          [2 ** 31, 256, 2e9, true]);
        const {text} = await must(['port', id, '8080']);
        const answer = await fetch(`http://${text.split('\n')[0]}/v1/regularize?format=raw&dims=2x2x2`,
          {method: 'POST', body: Buffer.alloc(8, 1)});
        assert.equal(answer.status, 200);
      } finally {
        await call('down', '--volumes', '--timeout', '40');
        rmSync(folder, {recursive: true});
      }
    },
  },
];
