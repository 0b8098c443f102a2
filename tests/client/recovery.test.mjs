// A server that dies while it works for a client, and what becomes of the job.
import assert from 'node:assert/strict';
import {existsSync, readdirSync, readFileSync} from 'node:fs';
import {join} from 'node:path';
import test from 'node:test';
import {assertGlb, makeFolder, rivage, slow, start, startServer, until} from './programs.mjs';

// Slow, but not for ever: some seconds of steps on the island.
const steps = slow.with(-1, '1500');

// A server with a state folder that is killed while it converts the island for a client.
async function killDuringJob(t, args = []) {
  const folder = makeFolder(t);
  const settings = ['--state-dir', 'state', '--supervise', 'false'];
  const server = await startServer(t, folder, settings);
  assert.equal((await rivage(['sample', 'island', '--server', server.url], {folder})).code, 0);
  const client = start('rivage',
    ['regularize', 'island.vox', '-o', 'out.glb', '--server', server.url, ...steps, ...args], {folder});
  await until(async () => (await (await fetch(`${server.url}/v1/jobs`)).json()).jobs[0]?.state ===
    'running', 'the job runs');
  server.child.kill('SIGKILL');
  await server.ended;
  const restart = () => startServer(t, folder, [...settings, '--listen', new URL(server.url).host]);
  return {folder, client, restart, url: server.url};
}

test('a client that still waits gets its result from the restarted server', async (t) => {
  const {folder, client, restart} = await killDuringJob(t);
  await restart();
  const ended = await client.ended;
  assert.equal(ended.code, 0, ended.stderr);
  assertGlb(readFileSync(join(folder, 'out.glb')));
});

test('a client that gave up says how the result is fetched, and that works', async (t) => {
  const {folder, client, restart, url} = await killDuringJob(t, ['--timeout', '4']);
  const ended = await client.ended;
  assert.ok(ended.code === 4 || ended.code === 5, `${ended.code}: ${ended.stderr}`);
  assert.deepEqual(readdirSync(folder).sort(), ['island.vox', 'state'], 'no half file');
  const command = /^ +rivage (jobs fetch \S+ -o out\.glb --server \S+)$/m.exec(ended.stderr);
  assert.ok(command, ended.stderr);
  assert.ok(command[1].endsWith(url));
  await restart();
  const fetched = await rivage(command[1].split(' '), {folder});
  assert.equal(fetched.code, 0, fetched.stderr);
  assertGlb(readFileSync(join(folder, 'out.glb')));
});

test('a server that stays away: 4, and no file', async (t) => {
  const {folder, client} = await killDuringJob(t);
  const ended = await client.ended;
  assert.equal(ended.code, 4, ended.stderr);
  assert.ok(!existsSync(join(folder, 'out.glb')));
});
