// Limits of the container that the server keeps by itself.
import assert from 'node:assert/strict';
import {mainJob} from './jobs.mjs';

const kMemory = 512 << 20;

export default [
  {
    name: 'memory: 512 MB, all workers at the limit of a job and the largest uploads beside them: nothing is killed',
    fault: 'RIVAGE_MEMORY_BUDGET=8GiB',
    async run(world, broken) {
      const server = await world.server({flags: ['--memory', '512m', '--memory-swap', '512m', '--pids-limit', '256'],
        env: broken ? {RIVAGE_MEMORY_BUDGET: '8GiB'} : {}});
      const found = await world.ask('flood', {url: server.url, seconds: 40});
      const log = await server.log();
      const {OOMKilled: killed} = await server.state();
      const crashes = log.filter(({event}) => event === 'crashed').length;
      assert.ok(!killed && crashes === 0, `killed: ${killed}, crashes: ${crashes}, ${JSON.stringify(found)}`);
      assert.equal(found.refusal.type, '/problems/memory-budget');
      assert.equal(found.refusal.setting, '--memory-budget');
      assert.ok(found.refusal.actual > found.refusal.limit && found.refusal.limit < kMemory);
      const ran = log.find(({event, problem}) => event === 'job' && problem === 'memory-budget');
      assert.equal(ran.surfels, 0, 'it had not begun');
      assert.ok(found.states.succeeded > 4, JSON.stringify(found));
      assert.deepEqual(found.problems, []);
      const peak = await server.peakMemory();
      assert.ok(peak < kMemory, `${peak} bytes at the peak`);
      return `peak ${(peak / 1e6).toFixed(0)} MB, ${found.states.succeeded} jobs, uploads ${JSON.stringify(found.statuses)}`;
    },
  },
  {
    name: 'processors: with one, one worker',
    fault: 'with all',
    async run(world, broken) {
      const server = await world.server({flags: broken ? [] : ['--cpus', '1']});
      const started = (await server.log()).find(({event}) => event === 'started');
      assert.equal(started.workers, 1);
      await mainJob(world);
    },
  },
];
