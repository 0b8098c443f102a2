// The real client and server on real sockets. RIVAGE_BIN names the folder of the programs.
import assert from 'node:assert/strict';
import {spawn} from 'node:child_process';
import {mkdtempSync, readdirSync, readFileSync, rmSync, writeFileSync} from 'node:fs';
import {tmpdir} from 'node:os';
import {join} from 'node:path';
import test from 'node:test';
import {setTimeout as sleep} from 'node:timers/promises';

const bin = process.env.RIVAGE_BIN;
assert.ok(bin, 'RIVAGE_BIN names the folder of the programs');

// A folder for one test, which is also where the programs put their temporary files.
function makeFolder(t) {
  const folder = mkdtempSync(join(tmpdir(), 'rivage-end-'));
  t.after(() => rmSync(folder, {recursive: true, force: true}));
  return folder;
}

function start(program, args, {folder, input} = {}) {
  const env = {...process.env, TMPDIR: folder};
  delete env.RIVAGE_SERVER;
  const child = spawn(join(bin, program), args, {cwd: folder, env});
  const chunks = {stdout: [], stderr: []};
  for (const name of ['stdout', 'stderr']) child[name].on('data', (data) => chunks[name].push(data));
  const ended = new Promise((resolve) => child.on('close', (code, signal) => resolve({
    code, signal,
    stdout: Buffer.concat(chunks.stdout),
    stderr: Buffer.concat(chunks.stderr).toString(),
  })));
  child.stdin.on('error', () => {});
  child.stdin.end(input);
  return {child, ended, said: () => Buffer.concat(chunks.stdout).toString()};
}

const rivage = (args, options) => start('rivage', args, options).ended;

function assertGlb(bytes) {
  assert.equal(bytes.subarray(0, 4).toString(), 'glTF');
  assert.equal(bytes.readUInt32LE(4), 2);
  assert.equal(bytes.readUInt32LE(8), bytes.length);
}

// A server on a free loopback port.
async function startServer(t, folder, args = []) {
  const server = start('rivage-server', ['--listen', '127.0.0.1:0', '--admin-listen', 'off', ...args],
    {folder});
  t.after(async () => {
    server.child.kill('SIGTERM');
    await server.ended;
  });
  for (let i = 0; i < 200; ++i) {
    const found = /listening on (http:\/\/\S+)/.exec(server.said());
    if (found) return {...server, url: found[1]};
    await sleep(50);
  }
  throw new Error('the server did not start');
}

test('with no server named, one of its own converts a sample, and nothing is left behind', async (t) => {
  const folder = makeFolder(t);
  const made = await rivage(['sample', 'sphere'], {folder});
  assert.equal(made.code, 0, made.stderr);
  const converted = await rivage(['regularize', 'sphere.vox'], {folder});
  assert.equal(converted.code, 0, converted.stderr);
  assertGlb(readFileSync(join(folder, 'sphere.glb')));
  assert.match(converted.stderr, /displacement/);
  assert.deepEqual(readdirSync(folder).sort(), ['sphere.glb', 'sphere.vox']);
});

test('the island through a named server: file, pipe and JSON agree', async (t) => {
  const folder = makeFolder(t);
  const {url} = await startServer(t, folder);
  assert.equal((await rivage(['sample', 'island', '--server', url], {folder})).code, 0);
  const converted = await rivage(
    ['regularize', 'island.vox', '-o', 'a.glb', '--json', '--server', url], {folder});
  assert.equal(converted.code, 0, converted.stderr);
  const report = JSON.parse(converted.stdout);
  assert.deepEqual(report.input.dims, [64, 68, 40]);
  assert.equal(report.surface.interfaces.length, 3);
  assert.ok(report.energy.after.total < report.energy.before.total);
  const bytes = readFileSync(join(folder, 'a.glb'));
  assertGlb(bytes);
  assert.equal(report.output.bytes, bytes.length);

  const piped = await rivage(['regularize', '-', '--server', url],
    {folder, input: readFileSync(join(folder, 'island.vox'))});
  assert.equal(piped.code, 0, piped.stderr);
  assert.ok(piped.stdout.equals(bytes), 'the same request gives the same bytes');
});

test('inspect, options, health and sample --list speak with the real server', async (t) => {
  const folder = makeFolder(t);
  const {url} = await startServer(t, folder);
  const ask = async (...args) => {
    const ended = await rivage([...args, '--server', url], {folder});
    assert.equal(ended.code, 0, ended.stderr);
    return ended.stdout.toString();
  };
  assert.match(await ask('sample', '--list'), /^island$/m);
  assert.match(await ask('options'), /--displacement-limit/);
  assert.match(await ask('health'), /^rivage \d+\.\d+\.\d+ answers$/m);
  await ask('sample', 'house');
  assert.match(await ask('inspect', 'house.vox'), /voxels/);
  assert.equal(JSON.parse(await ask('inspect', 'house.vox', '--json')).input.models > 0, true);
});

test('a broken grid is refused with the problem of the server', async (t) => {
  const folder = makeFolder(t);
  writeFileSync(join(folder, 'broken.vox'), Buffer.from('VOX \x96\0\0\0MAIN', 'latin1'));
  const refused = await rivage(['regularize', 'broken.vox'], {folder});
  assert.equal(refused.code, 3, refused.stderr);
  assert.match(refused.stderr, /broken\.vox: The grid breaks its own format/);
  assert.deepEqual(readdirSync(folder), ['broken.vox']);
});

test('Ctrl-C cancels the job, removes the private server and leaves no file', async (t) => {
  const folder = makeFolder(t);
  assert.equal((await rivage(['sample', 'island'], {folder})).code, 0);
  // Slow on purpose: a tolerance that gradient descent reaches only after very many steps.
  const slow = ['regularize', 'island.vox', '--solver', 'gradient-descent', '--displacement-limit',
    'none', '--alpha', '1e-6', '--tolerance', '1e-14', '--max-iterations', '1000000'];
  const run = start('rivage', slow, {folder});
  await sleep(1500);
  assert.equal(run.child.exitCode, null, 'the job is still under way');
  const since = Date.now();
  run.child.kill('SIGINT');
  const ended = await run.ended;
  assert.equal(ended.code, 7, ended.stderr);
  assert.ok(Date.now() - since < 8000, 'it ends soon');
  assert.deepEqual(readdirSync(folder), ['island.vox']);
});

test('Ctrl-C cancels the job at a named server, which stays', async (t) => {
  const folder = makeFolder(t);
  const {url} = await startServer(t, folder);
  assert.equal((await rivage(['sample', 'island', '--server', url], {folder})).code, 0);
  const run = start('rivage', ['regularize', 'island.vox', '--server', url, '--solver',
    'gradient-descent', '--displacement-limit', 'none', '--alpha', '1e-6', '--tolerance', '1e-14',
    '--max-iterations', '1000000'], {folder});
  let jobs = [];
  for (let i = 0; i < 100 && jobs[0]?.state !== 'running'; ++i) {
    await sleep(50);
    jobs = (await (await fetch(`${url}/v1/jobs`)).json()).jobs;
  }
  assert.equal(jobs[0].state, 'running');
  run.child.kill('SIGINT');
  assert.equal((await run.ended).code, 7);
  // The stage that runs looks for the request every few milliseconds.
  let state = 'running';
  for (let i = 0; i < 25 && state === 'running'; ++i) {
    await sleep(10);
    state = (await (await fetch(`${url}/v1/jobs/${jobs[0].id}`)).json()).state;
  }
  assert.equal(state, 'canceled');
});
