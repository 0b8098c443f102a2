// Start, stop, crash, and what outlives them.
import assert from 'node:assert/strict';
import {execFileSync} from 'node:child_process';
import {mkdirSync} from 'node:fs';
import {describe, test} from 'node:test';
import {fresh} from '../lib/grids.mjs';
import {
  assertProblem,
  eventually,
  refusedStart,
  requestBytes,
  Server,
  useFolder,
  withFakeServer,
  withServer,
} from '../lib/server.mjs';

const draining = (server) => server.logged((line) => line.event === 'draining', 'the drain');

describe('stop', () => {
  test('what was accepted is answered; new work and readiness are refused; the end is 0', async () => {
    await withFakeServer(['--drain-timeout', '20s', '--workers', '1'], async (server) => {
      const grid = fresh('hold:700');
      const answers = [
        server.post('/v1/regularize', grid),
        server.post('/v1/regularize', fresh('hold:300')),
      ];
      await eventually(async () => (await server.jobsIn('running')).length === 1, 'it runs');
      await eventually(async () => (await server.jobsIn('queued')).length === 1, 'the other waits');
      assert.equal((await server.get('/readyz', {admin: true})).status, 200);
      server.terminate();
      await draining(server);
      assertProblem(await server.get('/readyz', {admin: true}), 503, 'draining');
      assert.equal((await server.get('/livez', {admin: true})).status, 200);
      for (const route of ['/v1/jobs', '/v1/regularize', '/v1/inspect'])
        assertProblem(await server.post(route, fresh()), 503, 'draining');
      assert.equal((await server.get('/v1/jobs')).status, 200, 'reading goes on');
      const [first, second] = await Promise.all(answers);
      assert.equal(first.text, `asset of ${grid}`);
      assert.equal(second.status, 200);
    });
  });

  test('Expect: 100-continue is refused while it drains', async () => {
    await withFakeServer(['--drain-timeout', '20s'], async (server) => {
      const answer = server.post('/v1/regularize', fresh('hold:600'));
      await eventually(async () => (await server.jobsIn('running')).length === 1, 'it runs');
      server.terminate();
      await draining(server);
      const bytes = requestBytes('POST', '/v1/jobs', {
        headers: {Expect: '100-continue', 'Content-Length': '2'},
      });
      assertProblem(await server.raw(bytes, {method: 'POST', target: '/v1/jobs'}), 503, 'draining');
      assert.equal((await answer).status, 200);
    });
  });

  for (const route of ['/v1/regularize', '/v1/inspect'])
    test(`${route}: what does not end in time is given up, and says why`, async () => {
      await withFakeServer(['--drain-timeout', '0s'], async (server) => {
        const answer = server.post(route, fresh('slow'));
        await eventually(
          async () => /^rivage_workers_busy 1$/m.test(await server.metrics()),
          'it runs'
        );
        server.terminate();
        assertProblem(await answer, 503, 'draining');
      });
    });

  test('a second signal ends it at once', async () => {
    const server = await new Server(['--drain-timeout', '60s'], {fake: true}).start();
    await server.inState(await server.submit(fresh('slow')), 'running');
    server.terminate();
    await draining(server);
    server.terminate();
    assert.notEqual(await server.ended, 0);
  });

  test('a waiting GET does not hold the end up', async () => {
    await withFakeServer(['--drain-timeout', '0s'], async (server) => {
      const path = await server.submit(fresh('slow'));
      const waiting = server.get(path, {headers: {Prefer: 'wait=60'}}).catch(() => undefined);
      await server.inState(path, 'running');
      const since = Date.now();
      await server.stop();
      await waiting;
      assert.ok(Date.now() - since < 10000);
    });
  });
});

describe('start', () => {
  for (const args of [
    ['--colour', 'red'],
    ['--workers', '0'],
    ['--listen', 'nowhere'],
    ['--deadline', '-1s'],
    ['--max-upload', 'much'],
    ['--log-format', 'xml'],
    ['--tls-cert', '/nowhere'],
    ['--state-dir', '/dev/null/x'],
  ])
    test(`${args.join(' ')} is refused`, async () => {
      assert.ok([1, 2].includes(await refusedStart(args)));
    });

  test('a variable that is no setting is refused', async () => {
    assert.equal(await refusedStart([], {env: {RIVAGE_COLOUR: 'red'}}), 2);
  });

  test('a variable sets what no flag does', async () => {
    await withServer([], {env: {RIVAGE_MAX_UPLOAD: '12345'}}, async (server) =>
      assert.equal((await server.get('/v1/limits')).json.upload_bytes, 12345)
    );
  });
});

describe('state', () => {
  const root = useFolder();
  const stateArgs = (name) => ['--state-dir', `${root}/${name}`, '--workers', '1'];

  test('a restart keeps jobs, results, tags and idempotency keys', async () => {
    const args = stateArgs('keeps');
    const headers = {'Idempotency-Key': fresh('key')};
    const body = fresh();
    const before = await withFakeServer(args, async (server) => {
      const path = await server.submit(body, {headers});
      const failed = await server.submit('empty');
      await server.follow(failed);
      return {
        path,
        failed,
        job: await server.follow(path),
        result: await server.get(`${path}/result`),
      };
    });
    await withFakeServer(args, async (server) => {
      assert.deepEqual((await server.get(before.path)).json, before.job);
      const result = await server.get(`${before.path}/result`);
      assert.deepEqual(result.body, before.result.body);
      assert.equal(result.headers.etag, before.result.headers.etag);
      assertProblem(await server.get(`${before.failed}/result`), 422, 'empty-grid');
      const again = await server.post('/v1/jobs', body, {headers});
      assert.equal(again.headers.location, before.path);
      assert.equal(again.headers['idempotent-replayed'], 'true');
      assert.equal(
        (await server.post('/v1/regularize', body)).headers['cache-status'],
        'rivage; hit'
      );
    });
  });

  test('jobs that a kill interrupted run again', async () => {
    const args = [...stateArgs('again'), '--supervise', 'false'];
    const server = await new Server(args, {fake: true}).start();
    const grids = [fresh('hold:500'), fresh(), fresh()];
    const paths = [];
    for (const grid of grids) paths.push(await server.submit(grid));
    server.child.kill('SIGKILL');
    await server.ended;
    await withFakeServer(args, async (next) => {
      for (const [i, path] of paths.entries()) {
        assert.equal((await next.follow(path)).state, 'succeeded');
        assert.equal((await next.get(`${path}/result`)).text, `asset of ${grids[i]}`);
      }
    });
  });

  test('a crash is survived: the address stays, other jobs end, and the input is in quarantine after two', async () => {
    await withFakeServer(stateArgs('crash'), async (server) => {
      const other = fresh();
      // It waits behind another, so that it is accepted before it crashes.
      await server.submit(fresh('hold:300'));
      const path = await server.submit('crash-one');
      const second = await server.submit(other).catch(() => undefined);
      const job = await eventually(async () => {
        const answer = await server.get(path).catch(() => undefined);
        return answer?.status === 200 && answer.json.state === 'failed' && answer.json;
      }, 'it has failed');
      assert.equal(job.error.type, '/problems/poison');
      assert.equal(job.attempt, 2);
      assertProblem(await server.get(`${path}/result`), 422, 'poison');
      if (second) assert.equal((await server.follow(second)).state, 'succeeded');
      for (const route of ['/v1/regularize', '/v1/jobs'])
        assertProblem(await server.post(route, 'crash-one'), 422, 'poison');
      assert.equal((await server.get('/livez', {admin: true})).status, 200);
    });
  });

  test('without a state folder, too, the server is there again after a crash', async () => {
    await withFakeServer(['--workers', '1'], async (server) => {
      await server.post('/v1/jobs', 'crash').catch(() => undefined);
      const since = Date.now();
      const answer = await eventually(
        () => server.get('/version').catch(() => undefined),
        'it answers'
      );
      assert.equal(answer.status, 200);
      assert.ok(Date.now() - since < 10000);
    });
  });

  test('a job that is deaf to its deadline costs a restart, not the server', async () => {
    await withFakeServer([...stateArgs('deaf'), '--watchdog', '1s'], async (server) => {
      const path = await server.submit('loop', {query: '?deadline_ms=200'});
      const job = await eventually(async () => {
        const answer = await server.get(path).catch(() => undefined);
        return answer?.status === 200 && answer.json.finished && answer.json;
      }, 'it has ended');
      assert.equal(job.state, 'failed');
      await eventually(async () => {
        const answer = await server.post('/v1/regularize', fresh()).catch(() => undefined);
        return answer?.status === 200;
      }, 'it works again');
    });
  });
});

describe('a full disk', {skip: process.getuid() !== 0 && 'only root can mount'}, () => {
  const folder = useFolder();

  test('507 while there is no room, with when to come back; nothing that was kept is lost', async (t) => {
    const disk = `${folder}/disk`;
    mkdirSync(disk);
    try {
      execFileSync('mount', ['-t', 'tmpfs', '-o', 'size=4m', 'none', disk], {stdio: 'ignore'});
    } catch {
      return t.skip('no mount here');
    }
    try {
      await withFakeServer(['--state-dir', disk, '--workers', '1'], async (server) => {
        const kept = await server.submit(fresh());
        await server.follow(kept);
        const body = Buffer.alloc(1 << 20, 'o');
        let answer = {status: 202};
        for (let i = 0; i < 8 && answer.status === 202; ++i) {
          body.write(`slow-${i}`);
          answer = await server.post('/v1/jobs', body);
        }
        assertProblem(answer, 507, 'storage-full');
        assertProblem(
          await server.post('/v1/regularize', body, {headers: {Prefer: 'respond-async'}}),
          507,
          'storage-full'
        );
        assert.equal((await server.get(`${kept}/result`)).status, 200);
        assert.equal((await server.get('/v1/jobs')).status, 200);
      });
      await withFakeServer(['--workers', '1', '--state-dir', `${disk}`], async (server) => {
        for (const path of [
          ...(await server.jobsIn('queued')),
          ...(await server.jobsIn('running')),
        ])
          await server.ask('DELETE', path);
        // The job runs, but its result of 6 MiB has no room.
        const job = await server.follow(await server.submit(`big:${6 << 20}`));
        assert.equal(job.error?.type, '/problems/storage-full');
        assertProblem(await server.get(`${job.links.self}/result`), 507, 'storage-full');
      });
    } finally {
      execFileSync('umount', ['-l', disk]);
    }
    return undefined;
  });
});
