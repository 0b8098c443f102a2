// The real client and server on real sockets.
import assert from 'node:assert/strict';
import {execFileSync, spawnSync} from 'node:child_process';
import {cpSync, existsSync, mkdirSync, readdirSync, readFileSync, renameSync, rmSync, statSync,
  writeFileSync} from 'node:fs';
import {join} from 'node:path';
import test from 'node:test';
import {setTimeout as sleep} from 'node:timers/promises';
import {assertGlb, makeFolder, rivage, slow, start, startServer, until} from './programs.mjs';

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
  const run = start('rivage', ['regularize', 'island.vox', ...slow], {folder});
  await sleep(1500);
  assert.equal(run.child.exitCode, null, 'the job is still under way');
  const since = Date.now();
  run.child.kill('SIGINT');
  const ended = await run.ended;
  assert.equal(ended.code, 7, ended.stderr);
  assert.ok(Date.now() - since < 8000, 'it ends soon');
  assert.deepEqual(readdirSync(folder), ['island.vox']);
});

test('Ctrl-C ends what waits for a grid, or for the reader of a result; compare ends by it', async (t) => {
  const folder = makeFolder(t);
  execFileSync('mkfifo', [join(folder, 'grid.vox')]);
  for (const words of [['inspect', 'grid.vox'],
    ['sample', 'voxel', '-o', 'grid.vox'], ['compare', 'grid.vox', 'grid.vox']]) {
    const run = start('rivage', words, {folder});
    await sleep(1500);
    assert.equal(run.child.exitCode, null, 'it waits');
    const since = Date.now();
    run.child.kill('SIGINT');
    const ended = await run.ended;
    if (words[0] === 'compare') assert.equal(ended.signal, 'SIGINT');
    else assert.equal(ended.code, 7, ended.stderr);
    assert.ok(Date.now() - since < 3000, 'it ends soon');
  }
});

test('Ctrl-C cancels the job at a named server, which stays', async (t) => {
  const folder = makeFolder(t);
  const {url} = await startServer(t, folder);
  assert.equal((await rivage(['sample', 'island', '--server', url], {folder})).code, 0);
  const run = start('rivage', ['regularize', 'island.vox', '--server', url, ...slow],
    {folder});
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

// A tree of samples: models/one.vox, models/deep/two.vox ...
async function makeModels(folder, names = ['sphere', 'torus', 'voxel']) {
  mkdirSync(join(folder, 'models/deep'), {recursive: true});
  for (const [i, name] of names.entries()) {
    const made = await rivage(['sample', name, '-q', '-o',
      `models/${i % 2 ? 'deep/' : ''}${name}.vox`], {folder});
    assert.equal(made.code, 0, made.stderr);
  }
}

test('a folder is converted with one command, and again only what is newer', async (t) => {
  const folder = makeFolder(t);
  await makeModels(folder);
  const done = await rivage(['regularize', 'models', '-o', 'out'], {folder});
  assert.equal(done.code, 0, done.stderr);
  assert.match(done.stderr, /^3 converted; [\d.]+ kB in [\d.]+ s$/m);
  for (const name of ['sphere', 'deep/torus', 'voxel'])
    assertGlb(readFileSync(join(folder, 'out', `${name}.glb`)));
  writeFileSync(join(folder, 'models/broken.vox'), 'no grid');
  const again = await rivage(['regularize', 'models/**/*.vox', '-o', 'out', '--if-newer', '--json'],
    {folder});
  assert.equal(again.code, 3, again.stderr);
  assert.match(again.stderr, /^0 converted, 1 failed, 3 up to date/m);
  const lines = again.stdout.toString().trim().split('\n').map((line) => JSON.parse(line));
  assert.equal(lines.length, 4);
  assert.equal(lines.filter(({run}) => run.skipped).length, 3);
  assert.equal(lines.find(({run}) => run.exit === 3).run.input, 'models/broken.vox');
  assert.ok(!existsSync(join(folder, 'out/broken.glb')));
  const other = await rivage(['regularize', 'models/**/*.vox', '-o', 'out', '--if-newer', '--preset', 'paper'],
    {folder});
  assert.match(other.stderr, /^3 converted, 1 failed/m, 'other options make another result');
  assert.deepEqual(readdirSync(folder).sort(), ['models', 'out'], 'nothing else is left behind');
});

test('--watch converts what an editor writes, and lives through a restart of the server', async (t) => {
  const folder = makeFolder(t);
  await makeModels(folder, ['sphere', 'voxel']);
  const first = await startServer(t, folder);
  const port = new URL(first.url).port;
  const watch = start('rivage', ['regularize', 'models', '-o', 'out', '--watch', '--server',
    first.url], {folder});
  const lines = () => watch.said('stderr').split('\n').filter((line) => line.includes('->'));
  await until(() => lines().length === 2, 'both are converted');
  cpSync(join(folder, 'models/sphere.vox'), join(folder, 'models/.new'));
  renameSync(join(folder, 'models/.new'), join(folder, 'models/deep/voxel.vox'));
  await until(() => lines().length === 3, 'the renamed one is converted');
  assert.equal(statSync(join(folder, 'out/deep/voxel.glb')).size,
    statSync(join(folder, 'out/sphere.glb')).size);

  first.child.kill('SIGTERM');
  await first.ended;
  cpSync(join(folder, 'models/sphere.vox'), join(folder, 'models/late.vox'));
  await sleep(1000);
  await startServer(t, folder, ['--listen', `127.0.0.1:${port}`]);
  await until(() => existsSync(join(folder, 'out/late.glb')), 'it asks again', 30);
  rmSync(join(folder, 'models/late.vox'));
  await sleep(300);
  watch.child.kill('SIGINT');
  assert.equal((await watch.ended).code, 0);
});

test('settings: the file, the environment, and a private server that hears of neither', async (t) => {
  const folder = makeFolder(t);
  await makeModels(folder, ['voxel']);
  mkdirSync(join(folder, 'rivage'));
  writeFileSync(join(folder, 'rivage/config'), '# mine\npreset = architectural\njson = true\n');
  const env = {RIVAGE_CONFIG: '', XDG_CONFIG_HOME: folder, RIVAGE_WORKERS: 'many',
    RIVAGE_API_KEYS: '/nowhere', RIVAGE_CLIENT_TIMEOUT: '60'};
  const run = await rivage(['regularize', 'models', '-o', 'out'], {folder, env});
  assert.equal(run.code, 0, run.stderr);
  assert.equal(JSON.parse(run.stdout).options.preset, 'architectural');
  const over = await rivage(['regularize', 'models', '-o', 'out'],
    {folder, env: {...env, RIVAGE_CLIENT_PRESET: 'paper'}});
  assert.equal(JSON.parse(over.stdout).options.preset, 'paper');
  writeFileSync(join(folder, 'rivage/config'), 'presett = architectural\n');
  const wrong = await rivage(['health'], {folder, env});
  assert.equal(wrong.code, 2);
  assert.match(wrong.stderr, /rivage\/config:1: there is no setting "presett"; did you mean preset/);
});

test('compare, completions and man need no server', async (t) => {
  const folder = makeFolder(t);
  await makeModels(folder, ['sphere', 'torus']);
  assert.equal((await rivage(['regularize', 'models', '-o', 'out'], {folder})).code, 0);
  const compare = (...args) => rivage(['compare', 'out/sphere.glb', ...args],
    {folder, env: {RIVAGE_SERVER: 'http://127.0.0.1:1'}});
  const same = await compare('out/sphere.glb', '--max-distance', '0');
  assert.equal(same.code, 0, same.stderr);
  assert.match(same.stdout.toString(), /same bytes/);
  const different = await compare('out/deep/torus.glb', '--max-distance', '1');
  assert.equal(different.code, 6, different.stderr);
  assert.equal((await compare('models/sphere.vox')).code, 3);
  assert.equal((await compare('nowhere.glb')).code, 2);
  for (const shell of ['bash', 'zsh', 'fish']) {
    const script = await rivage(['completions', shell], {folder});
    assert.equal(script.code, 0);
    assert.match(script.stdout.toString(), /regularize/);
  }
  assert.equal((await rivage(['completions', 'tcsh'], {folder})).code, 2);
  const page = await rivage(['man'], {folder, env: {RIVAGE_CLIENT_NONSENSE: '1'}});
  assert.equal(page.code, 0);
  assert.match(page.stdout.toString(), /RIVAGE_CLIENT_PRESET/);
});

test('https: a certificate has to be trusted and has to fit; a key is sent', async (t) => {
  const folder = makeFolder(t);
  const made = spawnSync('openssl', ['req', '-x509', '-newkey', 'rsa:2048', '-nodes', '-days', '2',
    '-keyout', 'key.pem', '-out', 'cert.pem', '-subj', '/CN=localhost', '-addext',
    'subjectAltName=DNS:localhost'], {cwd: folder});
  assert.equal(made.status, 0, String(made.stderr));
  const hashed = await start('rivage-server', ['--hash-key=tester'], {folder, input: 'a-long-secret-key-of-mine\n'}).ended;
  assert.equal(hashed.code, 0, hashed.stderr);
  writeFileSync(join(folder, 'keys'), hashed.stdout);
  writeFileSync(join(folder, 'key'), 'a-long-secret-key-of-mine\n');
  const {url} = await startServer(t, folder,
    ['--tls-cert', 'cert.pem', '--tls-key', 'key.pem', '--api-keys', 'keys']);
  const named = url.replace('127.0.0.1', 'localhost');
  const list = (server, ...args) => rivage(['jobs', 'list', '--server', server, ...args], {folder});
  const trusted = ['--ca-file', 'cert.pem'];
  assert.equal((await list(named, ...trusted, '--api-key-file', 'key')).code, 0);
  assert.equal((await list(named, ...trusted)).code, 3, 'no key');
  const stranger = await list(named);
  assert.equal(stranger.code, 4);
  assert.match(stranger.stderr, /is not trusted/);
  assert.equal((await list(url, ...trusted)).code, 4, 'the name does not fit');
  assert.equal((await list(named, '--ca-file', 'nowhere.pem')).code, 2);
});
