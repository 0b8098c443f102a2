// Request ids and trace contexts: taken, refused or made, and found again in the log.
import assert from 'node:assert/strict';
import {describe, test} from 'node:test';
import {fresh} from '../lib/grids.mjs';
import {useFakeServer} from '../lib/server.mjs';

const kTrace = '4bf92f3577b34da6a3ce929d0e0e4736';
const traceparent = (trace = kTrace) => `00-${trace}-00f067aa0ba902b7-01`;

describe('tracing', () => {
  const server = useFakeServer();
  const line = (id, event = 'request') =>
    server.logged((one) => one.event === event && one.id === id, `a line of ${id}`);
  const ask = (headers, path = '/version') => server.get(path, {headers});

  for (const id of ['a', 'abc-DEF_123', 'x'.repeat(64)])
    test(`the id ${id.slice(0, 12)} is taken, echoed and logged`, async () => {
      assert.equal((await ask({'X-Request-ID': id})).headers['x-request-id'], id);
      const logged = await line(id);
      assert.equal(logged.route, '/version');
      assert.equal(logged.status, 200);
    });

  for (const id of [
    '',
    ' ',
    'a b',
    'x'.repeat(65),
    'a"b',
    '../x',
    'a;b',
    'caf\xe9',
    '${jndi}',
    '%0a',
  ])
    test(`the id ${JSON.stringify(id.slice(0, 12))} is replaced`, async () => {
      const made = (await ask({'X-Request-ID': id})).headers['x-request-id'];
      assert.notEqual(made, id);
      assert.match(made, /^[0-9a-f]{16,64}$/);
      await line(made);
    });

  test('two ids are none, or the first', async () => {
    const answer = await ask([
      ['X-Request-ID', 'one'],
      ['X-Request-ID', 'two'],
    ]);
    assert.notEqual(answer.headers['x-request-id'], 'two');
  });

  test('every request has an id of its own', async () => {
    const ids = [];
    for (let i = 0; i < 20; ++i) ids.push((await ask({})).headers['x-request-id']);
    assert.equal(new Set(ids).size, 20);
  });

  test('problems have one too, and those of the transport', async () => {
    assert.equal(
      (await ask({'X-Request-ID': 'missing'}, '/nothing')).headers['x-request-id'],
      'missing'
    );
    assert.match((await server.raw('nonsense\r\n\r\n')).headers['x-request-id'], /./);
  });

  test('a trace context is taken: in the line of the request and of its job', async () => {
    await server.post('/v1/regularize', fresh(), {
      headers: {'X-Request-ID': 'traced', traceparent: traceparent()},
    });
    assert.equal((await line('traced')).trace_id, kTrace);
    assert.equal((await line('traced', 'job')).trace_id, kTrace);
  });

  const bad = [
    '',
    'x',
    `00-${'0'.repeat(32)}-00f067aa0ba902b7-01`,
    `00-${kTrace}-${'0'.repeat(16)}-01`,
    `ff-${kTrace}-00f067aa0ba902b7-01`,
    `00-${kTrace.toUpperCase()}-00f067aa0ba902b7-01`,
    `00-${kTrace}-00f067aa0ba902b7`,
    `00-${kTrace}-00f067aa0ba902b7-01-more`,
    `00_${kTrace}_00f067aa0ba902b7_01`,
  ];
  for (const [i, value] of bad.entries())
    test(`the trace context ${value.slice(0, 24) || '(empty)'}... number ${i} is replaced`, async () => {
      const answer = await ask({'X-Request-ID': `bad-${i}`, traceparent: value});
      assert.equal(answer.headers.traceparent, undefined, 'only the id is echoed');
      const {trace_id: made} = await line(`bad-${i}`);
      assert.match(made, /^[0-9a-f]{32}$/);
      assert.notEqual(made.toLowerCase(), kTrace);
    });

  test('a later version of the trace context is understood as far as it is known', async () => {
    await ask({'X-Request-ID': 'later', traceparent: `01-${kTrace}-00f067aa0ba902b7-01-what-ever`});
    assert.equal((await line('later')).trace_id, kTrace);
  });

  test('the line of a request: id, method, route, status, time, bytes, job', async () => {
    const answer = await server.post('/v1/regularize?alpha=0.5', fresh(), {
      headers: {'X-Request-ID': 'full'},
    });
    const logged = await line('full');
    assert.equal(logged.method, 'POST');
    assert.equal(logged.route, '/v1/regularize');
    assert.equal(logged.status, 200);
    assert.equal(logged.job, answer.headers['rivage-job']);
    assert.equal(logged.bytes_out, answer.body.length);
    assert.equal(typeof logged.ms, 'number');
    assert.ok(Number.isFinite(Date.parse(logged.time)));
    const job = await line('full', 'job');
    assert.equal(job.state, 'succeeded');
    assert.equal(job.job, logged.job);
  });

  test('the route of a job is logged, not its path', async () => {
    await ask({'X-Request-ID': 'routed'}, '/v1/jobs/01234567-89ab-7def-8123-456789abcdef');
    assert.equal((await line('routed')).route, '/v1/jobs/{id}');
  });

  test('nothing that a client sends forges a line', async () => {
    await server.ask('GET', '/x%0a%7b%22event%22:%22forged%22%7d', {
      headers: {'User-Agent': '{"event":"forged"}\t', 'X-Request-ID': 'forger'},
    });
    await line('forger');
    assert.ok(!server.log.some((one) => one.event === 'forged'));
  });

  test('what fails inside is in the log and not in the answer', async () => {
    const answer = await server.post('/v1/regularize', 'throw', {
      headers: {'X-Request-ID': 'inside'},
    });
    assert.equal(answer.problem, 'internal');
    assert.ok(!answer.text.includes('secret'));
    assert.match(JSON.stringify(await line('inside', 'job')), /internal/);
  });
});
