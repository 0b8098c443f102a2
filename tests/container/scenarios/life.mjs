// From the start to the end, and back from the dead.
import assert from 'node:assert/strict';
import {docker, inspect, must, sleep, until} from '../lib/docker.mjs';
import {image} from '../lib/images.mjs';
import {mainJob} from './jobs.mjs';

const kFastHealth = ['--health-interval', '500ms', '--health-timeout', '3s', '--health-retries', '2',
  '--health-start-period', '1s'];
const health = (server) => inspect(server.name, '.State.Health.Status');

// Every job that was accepted has succeeded, and its result is whole.
async function allThere(world, server, {accepted}) {
  assert.ok(accepted.length > 10, `${accepted.length} jobs were accepted`);
  assert.deepEqual(await world.ask('jobs', {url: server.url, check: accepted}), {succeeded: accepted.length});
}

// Posts jobs meanwhile. If the scenario ends before it is asked for, its failure is nobody's.
function load(world, server, milliseconds) {
  const found = world.ask('jobs', {url: server.url, post: {milliseconds}});
  found.catch(() => {});
  return found;
}

export default [
  {
    name: 'logs: each line of stdout and stderr is a JSON object with time, level and event',
    fault: 'RIVAGE_LOG_FORMAT=text',
    async run(world, broken) {
      const server = await world.server({env: broken ? {RIVAGE_LOG_FORMAT: 'text'} : {}});
      await mainJob(world);
      await must(['stop', '--time', '40', server.name]);
      const log = await server.log();
      for (const line of log)
        assert.ok(line.level && line.event && !Number.isNaN(Date.parse(line.time)), JSON.stringify(line));
      for (const event of ['started', 'request', 'job', 'draining', 'stopped'])
        assert.ok(log.some((line) => line.event === event), event);
      assert.ok(log.some(({client}) => /^\d+\.\d+\.\d+\.\d+$/.test(client)), 'the address of a client');
    },
  },
  {
    name: 'health: healthy once it serves, unhealthy when it hangs, healthy again',
    fault: 'RIVAGE_ADMIN_LISTEN=off',
    async run(world, broken) {
      const server = await world.server({flags: kFastHealth, ready: false,
        env: broken ? {RIVAGE_ADMIN_LISTEN: 'off'} : {}});
      await until(async () => await health(server) === 'healthy', 'healthy', 15000);
      const pid = await server.servingPid();
      await server.signal('STOP', pid);
      await until(async () => await health(server) === 'unhealthy', 'unhealthy', 20000);
      await server.signal('CONT', pid);
      await until(async () => await health(server) === 'healthy', 'healthy again', 20000);
    },
  },
  {
    name: 'SIGTERM under load: exit code 0, no answer breaks off, no accepted job is lost',
    fault: 'one second to stop in, and no state',
    async run(world, broken) {
      const server = await world.server({env: {RIVAGE_QUEUE_LIMIT: 64, RIVAGE_KEPT_JOBS: 10000,
        ...(broken ? {RIVAGE_STATE_DIR: '', RIVAGE_DRAIN_DELAY: '5s'} : {})}});
      const loaded = load(world, server, 4000);
      await sleep(2500);
      await must(['stop', '--time', broken ? '1' : '40', server.name]);
      const {ExitCode: code, OOMKilled: killed} = await server.state();
      const found = await loaded;
      assert.deepEqual({code, killed, torn: found.torn}, {code: 0, killed: false, torn: 0});
      await must(['start', server.name]);
      await server.ready();
      await allThere(world, server, found);
      return `${found.accepted.length} jobs, refused ${JSON.stringify(found.refused)}`;
    },
  },
  {
    name: 'the serving process is killed: it serves again within two seconds, no accepted job is lost',
    fault: 'RIVAGE_STATE_DIR is empty',
    async run(world, broken) {
      const server = await world.server({env: {RIVAGE_QUEUE_LIMIT: 64, RIVAGE_KEPT_JOBS: 10000,
        ...(broken ? {RIVAGE_STATE_DIR: ''} : {})}});
      const loaded = load(world, server, 5000);
      await sleep(1500);
      await server.signal('KILL', await server.servingPid());
      const since = Date.now();
      await until(async () => (await server.probe('ready')).code === 0, 'it serves again');
      const took = Date.now() - since;
      const found = await loaded;
      await allThere(world, server, found);
      assert.equal(await inspect(server.name, '.RestartCount'), 0, 'the container went on');
      assert.ok((await server.log()).some(({event, reason}) => event === 'crashed' && reason === 'SIGKILL'));
      assert.ok(took < 2000, `${took} ms`);
      return `${found.accepted.length} jobs, again after ${took} ms`;
    },
  },
  {
    name: 'the whole container is killed: the restart policy brings it back, no accepted job is lost',
    fault: 'the state in a tmpfs',
    async run(world, broken) {
      const state = broken ? ['--tmpfs', '/var/lib/rivage:mode=1777']
        : ['--volume', `${await world.volume()}:/var/lib/rivage`];
      const server = await world.server({flags: ['--restart', 'unless-stopped', ...state],
        env: {RIVAGE_QUEUE_LIMIT: 64, RIVAGE_KEPT_JOBS: 10000}});
      const loaded = load(world, server, 5000);
      await sleep(1500);
      // Not by the engine, which would take that for the wish of its user.
      const pid = await inspect(server.name, '.State.Pid');
      await must(['run', '--rm', '--pid', 'host', '--user', '0', ...world.all.flags, image('test'),
        'bash', '-c', `kill -9 ${pid}`]);
      await until(async () => await inspect(server.name, '.RestartCount') === 1, 'it was started again');
      await server.ready();
      await allThere(world, server, await loaded);
    },
  },
  {
    name: 'a stop that takes too long ends by a second SIGTERM, at once',
    fault: 'the second signal is SIGHUP',
    async run(world, broken) {
      const server = await world.server({env: {RIVAGE_DRAIN_DELAY: '30s'}});
      await must(['kill', '--signal', 'TERM', server.name]);
      await until(async () => (await server.log()).some(({event}) => event === 'draining'), 'it drains');
      assert.equal((await server.probe('ready')).code, 1);
      assert.equal((await server.probe('live')).code, 0);
      await docker(['kill', '--signal', broken ? 'HUP' : 'TERM', server.name]);
      await until(async () => (await server.state()).Status === 'exited', 'it has ended', 5000);
      assert.equal((await server.state()).ExitCode, 130);
    },
  },
];
