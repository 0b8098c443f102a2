// Conversions from the client's image at the server's image.
import assert from 'node:assert/strict';
import {createHash} from 'node:crypto';
import {chmodSync, mkdtempSync, rmSync, writeFileSync} from 'node:fs';
import {tmpdir} from 'node:os';
import {join} from 'node:path';
import {docker, must, until} from '../lib/docker.mjs';
import {readGlb} from '../lib/glb.mjs';
import {image} from '../lib/images.mjs';
import {kHardened} from '../lib/world.mjs';

// The sample island, as a surface.
export async function mainJob(world, options) {
  const grid = await world.sample();
  const {code, out, errors} = await world.client(['regularize', '-', '-o', '-'], {input: grid, ...options});
  assert.equal(code, 0, errors);
  assert.ok(readGlb(out).triangles > 1000);
  return out;
}

// What no client can bring about with the real engine, and why.
const kUnseen = {
  'not-converged': 'no solver gives up on what a client can send in the time of a test',
  'output-too-large': 'needs more than 2^32 vertices or a file of 4 GiB',
  internal: 'would be a fault of the server',
};

function makeKeys() {
  const folder = mkdtempSync(join(tmpdir(), 'rivage-keys-'));
  const keys = {off: 'off-0123456789abcdef', few: 'few-0123456789abcdef'};
  const hash = (key) => createHash('sha256').update(key).digest('hex');
  writeFileSync(join(folder, 'keys'),
    `off sha256:${hash(keys.off)} disabled\nfew sha256:${hash(keys.few)} rate=1/m\n`);
  chmodSync(folder, 0o755);
  return {folder, keys, remove: () => rmSync(folder, {recursive: true})};
}

async function allProblems(world, broken) {
  const server = await world.server({env: {RIVAGE_WORKERS: 1, RIVAGE_QUEUE_LIMIT: 1, RIVAGE_MAX_UPLOAD: '1MiB',
    RIVAGE_HEADER_TIMEOUT: '1s', RIVAGE_RESULT_TTL: '2s', RIVAGE_MAX_LABELS: 4}});
  await world.server({alias: 'tiny', env: {RIVAGE_WORKERS: 1, RIVAGE_MEMORY_BUDGET: '64MiB'},
    flags: ['--tmpfs', '/var/lib/rivage:size=2m,mode=1777']});
  const {folder, keys, remove} = makeKeys();
  try {
    await world.server({alias: 'keyed', flags: ['--volume', `${folder}:/keys:ro`],
      env: broken ? {} : {RIVAGE_API_KEYS: '/keys/keys'}});
    const ask = (...part) => world.ask('problems', {host: 'server', tiny: 'tiny', keyed: 'keyed', keys, part});
    const seen = await ask('grids', 'requests', 'results', 'idempotency', 'load', 'keys', 'storage', 'catalogue');
    await ask('long');
    for (let i = 1; i <= 2; ++i) {
      const pid = await until(() => server.servingPid(), 'a serving process');
      await server.signal('KILL', pid);
      await until(async () => await server.servingPid() !== pid && (await server.probe('ready')).code === 0, 'it serves again');
    }
    Object.assign(seen, await ask('poison'));
    const other = await world.server({alias: 'stopping', env: {RIVAGE_WORKERS: 1}});
    await world.ask('problems', {host: 'stopping', part: ['long']});
    const stopped = docker(['stop', '--time', '60', other.name]);
    Object.assign(seen, await world.ask('problems', {host: 'stopping', part: ['draining']}));
    await docker(['kill', other.name]);
    await stopped;
    return seen;
  } finally {
    remove();
  }
}

export default [
  {
    name: 'main job: the client\'s image asks the server\'s over a private network, twice the same bytes',
    fault: 'a server with --max-voxels 10',
    async run(world, broken) {
      await world.server(broken ? {args: ['--max-voxels', '10']} : {});
      assert.deepEqual(await mainJob(world), await mainJob(world));
    },
  },
  {
    name: 'main job: read-only, no capabilities, no new privileges, another user, 512 MB, 256 processes',
    fault: 'without these flags',
    async run(world, broken) {
      const server = await world.server({flags: broken ? [] : kHardened});
      await mainJob(world);
      const status = await world.beside(server.name, 'pid', 'cat /proc/1/status');
      assert.match(status, /^Uid:\s+12345\s+12345/m);
      assert.match(status, /^Cap(Eff|Prm|Bnd):\s+0+$/m);
      assert.match(status, /^NoNewPrivs:\s+1$/m);
      assert.equal((await must(['diff', server.name])).text.replace(/^[AC] .*\/var\/lib\/rivage.*$/gm, ''), '');
      const {OOMKilled: killed, Restarting: restarting} = await server.state();
      assert.ok(!killed && !restarting);
    },
  },
  {
    name: 'main job: a user and a group that nobody knows, with a volume for its state',
    fault: 'a volume that may only be read',
    async run(world, broken) {
      const volume = await world.volume();
      await world.server({flags: ['--user', '54321:54321', '--read-only',
        '--volume', `${volume}:/var/lib/rivage${broken ? ':ro' : ''}`]});
      await mainJob(world);
    },
  },
  {
    name: 'main job: nothing that it may write: the state folder is switched off',
    fault: 'it is not switched off',
    async run(world, broken) {
      const volume = await world.volume();
      await world.server({flags: ['--read-only', '--volume', `${volume}:/var/lib/rivage:ro`],
        env: broken ? {} : {RIVAGE_STATE_DIR: ''}});
      await mainJob(world);
    },
  },
  {
    name: 'all types of problems are reached over the network',
    fault: 'a server without keys',
    async run(world, broken) {
      const {types, ...seen} = await allProblems(world, broken);
      assert.deepEqual(types.filter((type) => !seen[type] && !kUnseen[type]), []);
      assert.deepEqual(Object.keys(kUnseen).filter((type) => seen[type]), []);
      for (const type of ['too-large', 'memory-budget', 'queue-full', 'too-many-labels'])
        assert.ok(seen[type].limit !== undefined && seen[type].setting.startsWith('--'), type);
    },
  },
  {
    name: 'the contract: every route and status, with the files of the image',
    fault: 'another program in place of the server',
    async run(world, broken) {
      const programs = {RIVAGE_SERVER_PROGRAM: broken ? '/bin/true' : '/usr/bin/rivage-server',
        RIVAGE_FAKE_SERVER_PROGRAM: '/src/build/release/tests/rivage-fake-server'};
      const {code, text} = await docker(['run', '--rm', '--network', 'none', '--cap-add', 'SYS_ADMIN',
        '--security-opt', 'apparmor=unconfined', ...world.all.flags,
        ...Object.entries(programs).flatMap(([name, value]) => ['--env', `${name}=${value}`]),
        image('test'), 'node', '--test', 'tests/contract/contract.test.mjs'], {timeout: broken ? 30000 : 600000});
      assert.equal(code, 0, text.split('\n').filter((line) => /^\s*not ok|error:/.test(line)).slice(0, 20).join('\n'));
      assert.match(text, /^# fail 0$/m);
    },
  },
];
