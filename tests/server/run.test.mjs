// The server program with the fake engine, from its start to its end. RIVAGE_BUILD names the folder
// of the build.
import assert from 'node:assert/strict';
import {spawnSync} from 'node:child_process';
import {existsSync} from 'node:fs';
import {join} from 'node:path';
import test from 'node:test';
import {
  Server, jsonOf, makeFolder, post, removeFolder, request, sleep, until,
} from '../soak/support.mjs';

const build = process.env.RIVAGE_BUILD;
assert.ok(build, 'RIVAGE_BUILD names the folder of the build');

// A server that is stopped, with its folder, when the test is over.
async function start(t, args = [], listen = undefined) {
  const folder = makeFolder();
  const server = new Server(build, join(folder, 'state'), args, listen);
  t.after(async () => {
    server.child.kill('SIGKILL');
    await server.ended;
    removeFolder(folder);
  });
  return server.started();
}

const ready = async (server) => (await request(`${server.adminUrl}/readyz`)).status;

test('SIGTERM: unready at once, serves on for the delay, then ends with 0', async (t) => {
  const server = await start(t, ['--drain-delay', '1s']);
  assert.equal(await ready(server), 200);
  const since = Date.now();
  server.child.kill('SIGTERM');
  await until(async () => await ready(server) === 503, 500);
  assert.equal((await post(server, '/v1/regularize', 'ok')).status, 200);
  assert.equal(await server.ended, 0);
  assert.ok(Date.now() - since >= 950, 'it waited');
  assert.equal(server.crashes, 0);
});

test('SIGINT skips the delay, and lets a running job end', async (t) => {
  const server = await start(t, ['--drain-delay', '20s']);
  const answer = post(server, '/v1/regularize', 'hold:400');
  await sleep(150);
  const since = Date.now();
  server.child.kill('SIGINT');
  assert.equal((await answer).status, 200);
  assert.equal(await server.ended, 0);
  assert.ok(Date.now() - since < 5000);
});

test('a second stop signal ends at once, which is no crash', async (t) => {
  const server = await start(t);
  const {headers} = await post(server, '/v1/jobs', 'slow');
  await until(async () => jsonOf(await request(server.url + headers.location)).state === 'running');
  server.child.kill('SIGTERM');
  await until(() => server.log.includes(' draining '));
  server.child.kill('SIGTERM');
  assert.equal(await server.ended, 130);
  const next = await new Server(build, server.folder).started();
  t.after(() => next.child.kill('SIGKILL'));
  assert.ok(!next.log.includes('crash recovered'), next.log);
  await until(async () => jsonOf(await request(next.url + headers.location)).state === 'running');
  assert.equal((await request(next.url + headers.location, {method: 'DELETE'})).status, 204);
  assert.equal(await next.stop(), 0);
});

test('a state folder has one server; the second names it and ends with 1', async (t) => {
  const server = await start(t);
  const second = new Server(build, server.folder);
  assert.equal(await second.ended, 1);
  assert.match(second.log, /another server uses --state-dir/);
  assert.equal((await post(server, '/v1/regularize', 'ok')).status, 200);
});

test('a Unix socket outlives crashes and goes with the program', async (t) => {
  const folder = makeFolder();
  t.after(() => removeFolder(folder));
  const path = join(folder, 'socket');
  const server = await start(t, [], `unix:${path}`);
  const before = server.servingPid;
  process.kill(before, 'SIGKILL');
  await until(() => server.servingPid !== before);
  assert.ok(existsSync(path));
  assert.equal(await server.stop(), 0);
  assert.ok(!existsSync(path));
});

test('without a supervisor a crash is the end, and signals work the same', async (t) => {
  const server = await start(t, ['--supervise', 'false']);
  assert.equal(server.servingPid, server.child.pid);
  assert.equal(await server.stop(), 0);
  const other = await start(t, ['--supervise', 'false']);
  await assert.rejects(post(other, '/v1/regularize', 'crash'));
  assert.equal(await other.ended, null);
});

test('a job that ignores its deadline costs the process, not the service', async (t) => {
  const server = await start(t, ['--deadline', '1s', '--watchdog', '1s']);
  const {headers} = await post(server, '/v1/jobs', 'loop');
  await until(() => server.crashes >= 1, 8000);
  assert.match(server.log, /stuck .*deadline/);
  assert.match(server.log, /crashed .*exit code 70/);
  const job = jsonOf(await request(server.url + headers.location));
  assert.equal(job.state, 'failed');
  assert.match(job.error.type, /deadline-exceeded|poison/);
});

test('X-Forwarded-For counts from a trusted proxy only, and is in the log', async (t) => {
  for (const [args, client] of [[[], '127.0.0.1'], [['--trusted-proxy', '127.0.0.1'], '203.0.113.7']]) {
    const server = await start(t, args);
    await request(`${server.url}/version`, {headers: {'X-Forwarded-For': '203.0.113.7'}});
    await until(() => server.log.includes(' request '));
    assert.match(server.log, new RegExp(` request .*client=${client} `));
    assert.equal(await server.stop(), 0);
  }
});

test('--probe asks the admin port that the settings name, and says what is wrong', async (t) => {
  const server = await start(t, ['--drain-delay', '20s']);
  const probe = (question, admin = new URL(server.adminUrl).host) => spawnSync(server.child.spawnfile,
    ['--probe', question], {env: {RIVAGE_ADMIN_LISTEN: admin}, encoding: 'utf8'});
  for (const question of ['live', 'ready', 'started']) assert.equal(probe(question).status, 0, question);
  server.child.kill('SIGTERM');
  await until(() => server.log.includes(' draining '));
  assert.equal(probe('live').status, 0);
  assert.equal(probe('ready').status, 1);
  assert.match(probe('ready').stderr, /problems\/draining/);
  assert.match(probe('live', 'off').stderr, /nothing to ask/);
  assert.equal(probe('well').status, 2);
});
