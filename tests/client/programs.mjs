// What the tests of whole programs share. RIVAGE_BIN names the folder of the programs.
import assert from 'node:assert/strict';
import {spawn} from 'node:child_process';
import {mkdtempSync, rmSync} from 'node:fs';
import {tmpdir} from 'node:os';
import {join} from 'node:path';
import {setTimeout as sleep} from 'node:timers/promises';

const bin = process.env.RIVAGE_BIN;
assert.ok(bin, 'RIVAGE_BIN names the folder of the programs');

// A folder for one test, which is also where the programs put their temporary files.
export function makeFolder(t) {
  const folder = mkdtempSync(join(tmpdir(), 'rivage-end-'));
  t.after(() => rmSync(folder, {recursive: true, force: true}));
  return folder;
}

// Starts a program in a folder, with no variable of ours but those in `env`.
export function start(program, args, {folder, input, env = {}} = {}) {
  const clean = Object.fromEntries(Object.entries(process.env)
    .filter(([name]) => !name.startsWith('RIVAGE_')));
  const child = spawn(program.includes('/') ? program : join(bin, program), args, {cwd: folder,
    env: {...clean, TMPDIR: folder, RIVAGE_CONFIG: '/dev/null', ...env}});
  const chunks = {stdout: [], stderr: []};
  for (const name of ['stdout', 'stderr']) child[name].on('data', (data) => chunks[name].push(data));
  const ended = new Promise((resolve) => child.on('close', (code, signal) => resolve({
    code, signal,
    stdout: Buffer.concat(chunks.stdout),
    stderr: Buffer.concat(chunks.stderr).toString(),
  })));
  child.stdin.on('error', () => {});
  child.stdin.end(input);
  const said = (name = 'stdout') => Buffer.concat(chunks[name]).toString();
  return {child, ended, said};
}

export const rivage = (args, options) => start('rivage', args, options).ended;

export function assertGlb(bytes) {
  assert.equal(bytes.subarray(0, 4).toString(), 'glTF');
  assert.equal(bytes.readUInt32LE(4), 2);
  assert.equal(bytes.readUInt32LE(8), bytes.length);
}

// Waits until `what` gives something true; fails after `seconds`.
export async function until(what, message, seconds = 20) {
  for (let i = 0; i < 40 * seconds; ++i) {
    const value = await what();
    if (value) return value;
    await sleep(25);
  }
  return assert.fail(message);
}

// A server on a loopback port, a free one unless `args` say otherwise.
export async function startServer(t, folder, args = []) {
  const listen = args.includes('--listen') ? [] : ['--listen', '127.0.0.1:0'];
  const server = start('rivage-server', [...listen, '--admin-listen', 'off', ...args], {folder});
  t.after(async () => {
    server.child.kill('SIGTERM');
    await server.ended;
  });
  const found = await until(() => /listening on (https?:\/\/\S+)/.exec(server.said()),
    'the server did not start');
  return {...server, url: found[1]};
}

// Slow on purpose: a tolerance that gradient descent reaches only after very many steps.
export const slow = ['--solver', 'gradient-descent', '--displacement-limit', 'none', '--alpha',
  '1e-6', '--tolerance', '1e-14', '--max-iterations', '1000000'];
