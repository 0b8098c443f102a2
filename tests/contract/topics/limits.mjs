// Everything that waits or grows is bounded, and says which setting bounds it.
import assert from 'node:assert/strict';
import {describe, test} from 'node:test';
import {fresh} from '../lib/grids.mjs';
import {assertProblem, requestBytes, useFakeServer, withFakeServer} from '../lib/server.mjs';

const kPosts = ['/v1/regularize', '/v1/jobs', '/v1/inspect'];
const head = (lines, method = 'GET', target = '/version') =>
  `${method} ${target} HTTP/1.1\r\nHost: x\r\n${lines}\r\n`;

describe('limits', () => {
  const server = useFakeServer(['--max-upload', '4096']);

  test('/v1/limits says what is in force', async () => {
    const {json} = await server.get('/v1/limits');
    assert.equal(json.upload_bytes, 4096);
  });

  for (const length of [8193, 9000, 65536, 1 << 20])
    test(`a target of ${length} bytes is too long`, async () =>
      assertProblem(
        await server.raw(`GET /${'x'.repeat(length)} HTTP/1.1\r\nHost: x\r\n\r\n`),
        414,
        'uri-too-long'
      ));

  test('a target of 8000 bytes is not', async () =>
    assertProblem(await server.get(`/${'x'.repeat(8000)}`), 404, 'not-found'));

  for (const [what, lines] of [
    ['200 fields', Array.from({length: 200}, (_, i) => `X-${i}: y\r\n`).join('')],
    ['a field of 20 kB', `X-Long: ${'y'.repeat(20000)}\r\n`],
    ['a name of 20 kB', `${'n'.repeat(20000)}: y\r\n`],
    [
      '90 fields of 2 kB',
      Array.from({length: 90}, (_, i) => `X-${i}: ${'y'.repeat(2000)}\r\n`).join(''),
    ],
  ])
    test(`a head with ${what} is too large`, async () =>
      assertProblem(await server.raw(head(lines)), 431, 'headers-too-large'));

  test('a head of 60 fields is not', async () => {
    const headers = Object.fromEntries(Array.from({length: 60}, (_, i) => [`X-${i}`, 'y']));
    assert.equal((await server.get('/version', {headers})).status, 200);
  });

  for (const route of kPosts)
    test(`${route}: a full queue is refused at once, before the body, with the time to come back`, async () => {
      await withFakeServer(['--workers', '1', '--queue-limit', '1'], async (full) => {
        await full.inState(await full.submit(fresh('slow')), 'running');
        await full.submit(fresh('slow'));
        assertProblem(await full.post(route, fresh()), 503, 'queue-full', {
          setting: '--queue-limit',
        });
        const bytes = requestBytes('POST', route, {
          headers: {'Content-Length': '1000000'},
          close: false,
        });
        assertProblem(await full.raw(bytes, {method: 'POST', target: route}), 503, 'queue-full');
        assert.equal((await full.get('/v1/jobs')).json.jobs.length, 2, 'nothing was kept of it');
      });
    });

  test('an upload holds a place, and gives it back when it breaks off', async () => {
    await withFakeServer(['--workers', '1', '--queue-limit', '0'], async (small) => {
      const connection = await small.connect();
      connection.send(
        requestBytes('POST', '/v1/jobs', {
          headers: {'Content-Length': '1000', Expect: '100-continue'},
        })
      );
      assert.equal((await connection.anyHead()).status, 100);
      assertProblem(await small.post('/v1/jobs', fresh()), 503, 'queue-full');
      connection.close();
      for (
        let status = 503, limit = Date.now() + 15000;
        status !== 202;
        assert.ok(Date.now() < limit)
      )
        ({status} = await small.post('/v1/jobs', fresh()));
    });
  });

  test('refused requests hold nothing', async () => {
    await withFakeServer(['--workers', '1', '--queue-limit', '0'], async (small) => {
      for (let i = 0; i < 50; ++i)
        assertProblem(await small.post('/v1/regularize?x=1', 'ok'), 400, 'unknown-option');
      for (let i = 0; i < 50; ++i)
        assert.equal((await small.post('/v1/regularize', fresh())).status, 200);
    });
  });

  for (const route of ['/v1/regularize', '/v1/inspect'])
    test(`${route}: a deadline that passes while it runs: 504`, async () =>
      assertProblem(
        await server.post(`${route}?deadline_ms=60`, fresh('slow')),
        504,
        'deadline-exceeded'
      ));

  test('a deadline that passes in the queue: the job never runs, and its result is 504', async () => {
    await withFakeServer(['--workers', '1'], async (busy) => {
      await busy.inState(await busy.submit(fresh('slow')), 'running');
      const path = await busy.submit(fresh(), {query: '?deadline_ms=50'});
      const job = await busy.follow(path);
      assert.equal(job.state, 'failed');
      assert.equal(job.attempt, 0);
      assertProblem(await busy.get(`${path}/result`), 504, 'deadline-exceeded');
    });
  });

  test("the server's own deadline holds without one", async () => {
    await withFakeServer(['--deadline', '1s'], async (hasty) =>
      assertProblem(await hasty.post('/v1/regularize', fresh('slow')), 504, 'deadline-exceeded')
    );
  });

  test('kept jobs are bounded: the oldest expires', async () => {
    await withFakeServer(['--kept-jobs', '2'], async (small) => {
      const paths = [];
      for (let i = 0; i < 3; ++i) {
        paths.push(await small.submit(fresh()));
        await small.follow(paths.at(-1));
      }
      assertProblem(await small.get(paths[0]), 410, 'result-expired');
      assert.equal((await small.get(paths[1])).status, 200);
    });
  });

  test('a job expires after its time', async () => {
    await withFakeServer(['--result-ttl', '1s'], async (small) => {
      const path = await small.submit(fresh());
      const {expires_at: end, finished} = await small.follow(path);
      assert.equal(Date.parse(end) - Date.parse(finished) < 1100, true);
      for (
        let status = 200, limit = Date.now() + 15000;
        status !== 410;
        assert.ok(Date.now() < limit)
      ) {
        await new Promise((resolve) => setTimeout(resolve, 50));
        ({status} = await small.get(path));
      }
    });
  });
});

describe('slow clients', {concurrency: 8}, () => {
  const server = useFakeServer([
    '--header-timeout',
    '1s',
    '--body-timeout',
    '2s',
    '--idle-timeout',
    '1s',
    '--connections',
    '64',
  ]);

  for (const route of kPosts)
    for (const [what, body] of [
      ['stops', 'x'],
      ['never comes', ''],
    ])
      test(`${route}: a body that ${what}: 408`, async () => {
        const bytes = `POST ${route} HTTP/1.1\r\nHost: x\r\nContent-Length: 100\r\n\r\n${body}`;
        assertProblem(
          await server.raw(bytes, {method: 'POST', target: route}),
          408,
          'request-timeout'
        );
      });

  for (const [what, bytes] of [
    ['stops in a field', 'GET / HTTP/1.1\r\nHost: x\r\nX-'],
    ['stops in its first line', 'GET / HT'],
  ])
    test(`a head that ${what} is given up: 408`, async () =>
      assertProblem(await server.raw(bytes), 408, 'request-timeout'));

  test('a head that comes a byte every 100 ms is given up as a whole', async () => {
    const connection = await server.connect();
    const since = Date.now();
    connection.send('GET / HTTP/1.1\r\n');
    const timer = setInterval(() => connection.send('X'), 100);
    await connection.rest().catch(() => {});
    clearInterval(timer);
    connection.close();
    assert.ok(Date.now() - since < 10000);
  });

  test('an idle connection is closed without a word', async () => {
    const connection = await server.connect();
    await connection.closed();
    connection.close();
  });

  test('while 60 connections say nothing, others are served', async () => {
    const idle = await Promise.all(Array.from({length: 50}, () => server.connect()));
    for (const connection of idle) connection.send('GET / HTTP/1.1\r\n');
    const since = Date.now();
    assert.equal((await server.get('/version')).status, 200);
    assert.equal((await server.get('/livez', {admin: true})).status, 200);
    assert.ok(Date.now() - since < 2000, 'at once');
    for (const connection of idle) connection.close();
  });
});
