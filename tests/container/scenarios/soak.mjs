// Mixed load for a long time, in a container that may have little.
import assert from 'node:assert/strict';
import {chmodSync, mkdtempSync, rmSync, writeFileSync} from 'node:fs';
import {tmpdir} from 'node:os';
import {join} from 'node:path';
import {docker, inspect, sleep} from '../lib/docker.mjs';
import {image} from '../lib/images.mjs';
import {kHardened} from '../lib/world.mjs';

const kMostGrowth = 1.05;
const kParts = 6;  // of the load; the first one fills what is kept
const kQuiet = 10000;  // milliseconds after the load, for jobs that nobody waits for

// A bit of everything that clients do, also what they should not.
const kMix = {
  entries: [
    {name: 'at once', weight: 4, input: {sample: 'island'}, options: {preset: 'paper'}},
    {name: 'house', weight: 1, input: {sample: 'house'}},
    {name: 'regions', weight: 1, input: {sample: 'foam'}, options: {labels: 'palette', output: 'obj'}},
    {name: 'smallest', weight: 2, input: {sample: 'voxel'}, options: {compression: 'none'}},
    {name: 'events', weight: 2, mode: 'job', input: {sample: 'island'}, follow: 'events', abandoned: 0.1},
    {name: 'waiting', weight: 2, mode: 'job', input: {sample: 'island'}, follow: 'wait', cancelled: 0.1},
    {name: 'asking', weight: 1, mode: 'job', input: {sample: 'island'}, follow: 'poll'},
    {name: 'version', weight: 4, mode: 'get', path: '/version'},
    {name: 'jobs', weight: 1, mode: 'get', path: '/v1/jobs'},
  ],
  duplicates: 0.2, aborts: 0.02, slow_clients: 0.02, seed: 7,
};

// Sends the mix for so many seconds, from the network of the server itself: both ends are on its loopback.
async function load(world, server, folder, seconds, concurrency) {
  const {code, text, errors} = await docker(['run', '--rm', `--network=container:${server.name}`, ...world.all.flags,
    '--volume', `${folder}:/mix:ro`, '--entrypoint', '/usr/bin/rivage-load', image('client'), 'run',
    '--server', 'http://127.0.0.1:8080', '--mix', '/mix/mix.json', '--concurrency', String(concurrency),
    '--duration', String(seconds), '--timeout', '90', '--json', '--quiet'], {timeout: (seconds + 300) * 1000});
  assert.ok([0, 1].includes(code), `rivage-load: ${code} ${errors.slice(-500)}`);
  return JSON.parse(text);
}

// What it keeps when nothing runs. Under load memory goes up and down with the jobs, by far more than 5 %.
async function kept(server) {
  await sleep(kQuiet);
  const samples = [];
  for (let i = 0; i < 5; ++i) samples.push(await server.memory());
  return Math.min(...samples) / 1e6;
}

// @param minutes  of load, in parts; after none of them may more be kept than after the first
export const soak = (minutes) => ({
  name: `soak: ${minutes} minutes of mixed load in 512 MB: no restart, no accepted request fails, memory stays`,
  fault: 'a deadline of one second, and ten times the load',
  async run(world, broken) {
    const server = await world.server({flags: [...kHardened, '--memory-swap', '512m', '--restart', 'unless-stopped'],
      env: {RIVAGE_KEPT_JOBS: 200, ...(broken ? {RIVAGE_DEADLINE: '1s'} : {})}});
    const folder = mkdtempSync(join(tmpdir(), 'rivage-soak-'));
    try {
      writeFileSync(join(folder, 'mix.json'), JSON.stringify(kMix));
      chmodSync(folder, 0o755);
      const results = [];
      const memory = [];
      for (let part = 0; part < kParts; ++part) {
        results.push(await load(world, server, folder, Math.ceil(minutes * 60 / kParts), broken ? 64 : 6));
        memory.push(await kept(server));
      }
      const sum = (key) => results.reduce((total, {requests}) => total + requests[key], 0);
      const log = await server.log();
      const {OOMKilled: killed} = await server.state();
      const figures = `${sum('good')} good answers, ${sum('jobs')} jobs, ${sum('refused')} refused, ${sum('aborted')} left; ` +
        `memory kept ${memory.map((mb) => mb.toFixed(1)).join(' -> ')} MB, peak ${(await server.peakMemory() / 1e6).toFixed(0)} MB`;
      assert.deepEqual({killed, restarts: await inspect(server.name, '.RestartCount'),
        crashes: log.filter(({event}) => event === 'crashed').length, failed: sum('failed'),
        grown: Math.max(...memory) > kMostGrowth * memory[0]},
        {killed: false, restarts: 0, crashes: 0, failed: 0, grown: false},
        `${figures} ${JSON.stringify(results.map(({errors}) => errors))}`);
      return figures;
    } finally {
      rmSync(folder, {recursive: true});
    }
  },
});
