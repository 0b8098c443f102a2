// Mixed load for a long time, in a container that may have little.
import assert from 'node:assert/strict';
import {chmodSync, mkdtempSync, rmSync, writeFileSync} from 'node:fs';
import {tmpdir} from 'node:os';
import {join} from 'node:path';
import {docker, inspect, must} from '../lib/docker.mjs';
import {image} from '../lib/images.mjs';
import {kHardened} from '../lib/world.mjs';

const kMostGrowth = 1.05;
const kSample = 1;  // seconds between two looks at the memory

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

// What stays while jobs come and go, and what is usual, in MB.
const share = (values, part) => values.toSorted((a, b) => a - b)[Math.floor(part * values.length)] / 1000;
const floor = (values) => share(values, 0.1);
const usual = (values) => share(values, 0.5);

// Watches the memory of the server's processes, in kB, for so many seconds.
function watchMemory(world, server, seconds) {
  const name = world.name();
  const started = must(['run', '--detach', '--name', name, `--pid=container:${server.name}`, ...world.all.flags,
    image('test'), 'bash', '-c', `while sleep ${kSample}; do grep -h '^VmRSS:' $(grep -l '^Name:.*rivage-server' ` +
      `/proc/[0-9]*/status) 2>/dev/null | awk '{sum += $2} END {print sum}'; done`]);
  return async () => {
    await started;
    const samples = (await docker(['logs', name])).text.split('\n').map(Number).filter(Boolean);
    return samples.slice(0, seconds / kSample);  // what is left of slow clients is no load
  };
}

// @param minutes  of load; the memory that stays in the second sixth is compared with that of the last
export const soak = (minutes) => ({
  name: `soak: ${minutes} minutes of mixed load in 512 MB: no restart, no accepted request fails, memory stays`,
  fault: 'a deadline of one second, and ten times the load',
  async run(world, broken) {
    const server = await world.server({flags: [...kHardened, '--memory-swap', '512m', '--restart', 'unless-stopped'],
      env: {RIVAGE_KEPT_JOBS: 200, ...(broken ? {RIVAGE_DEADLINE: '1s'} : {})}});
    const memory = watchMemory(world, server, minutes * 60);
    const folder = mkdtempSync(join(tmpdir(), 'rivage-soak-'));
    try {
      writeFileSync(join(folder, 'mix.json'), JSON.stringify(kMix));
      chmodSync(folder, 0o755);
      // In the network of the server itself: both ends are on its loopback.
      const {code, text, errors} = await docker(['run', '--rm', `--network=container:${server.name}`, ...world.all.flags,
        '--volume', `${folder}:/mix:ro`, '--entrypoint', '/usr/bin/rivage-load', image('client'), 'run',
        '--server', 'http://127.0.0.1:8080', '--mix', '/mix/mix.json', '--concurrency', broken ? '64' : '6',
        '--duration', String(minutes * 60), '--timeout', '180', '--json', '--quiet'], {timeout: (minutes + 5) * 60000});
      assert.ok([0, 1].includes(code), `rivage-load: ${code} ${errors.slice(-500)}`);
      const {requests, errors: classes} = JSON.parse(text);
      const log = await server.log();
      const {OOMKilled: killed} = await server.state();
      const samples = await memory();
      const part = Math.floor(samples.length / 6);
      const early = samples.slice(part, 2 * part);
      const late = samples.slice(-part);
      const growth = floor(late) / floor(early);
      const figures = `${requests.good} good answers, ${requests.jobs} jobs, ${requests.refused} refused, ` +
        `${requests.aborted} left; memory that stays ${floor(early).toFixed(1)} -> ${floor(late).toFixed(1)} MB, ` +
        `usual ${usual(early).toFixed(1)} -> ${usual(late).toFixed(1)} MB, ` +
        `peak ${(await server.peakMemory() / 1e6).toFixed(0)} MB`;
      assert.deepEqual({killed, restarts: await inspect(server.name, '.RestartCount'),
        crashes: log.filter(({event}) => event === 'crashed').length, failed: requests.failed, growth: growth <= kMostGrowth},
        {killed: false, restarts: 0, crashes: 0, failed: 0, growth: true}, `${figures} ${JSON.stringify(classes)}`);
      return figures;
    } finally {
      rmSync(folder, {recursive: true});
    }
  },
});
