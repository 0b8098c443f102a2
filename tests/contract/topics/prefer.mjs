// All forms of Prefer (RFC 7240), and waiting for the end of a job.
import assert from 'node:assert/strict';
import {describe, test} from 'node:test';
import {fresh} from '../lib/grids.mjs';
import {eventually, useFakeServer, withFakeServer} from '../lib/server.mjs';

const kShort = () => fresh('hold:20');
const kLong = () => fresh('slow');

// Prefer, the grid, the status of POST /v1/regularize, and Preference-Applied.
const kForms = [
  [undefined, kShort, 200, undefined],
  ['respond-async', kLong, 202, 'respond-async'],
  ['respond-async', kShort, 202, 'respond-async'],
  ['wait=0', kLong, 202, 'wait=0'],
  ['wait=1', kLong, 202, 'wait=1'],
  ['wait=30', kShort, 200, 'wait=30'],
  ['respond-async, wait=30', kShort, 200, 'respond-async, wait=30'],
  ['wait=30, respond-async', kShort, 200, 'respond-async, wait=30'],
  ['respond-async, wait=0', kLong, 202, 'respond-async, wait=0'],
  ['respond-async; foo=bar', kLong, 202, 'respond-async'],
  ['return=minimal, respond-async', kLong, 202, 'respond-async'],
  ['wait="1"', kLong, 202, 'wait=1'],
  ['wait = 0', kLong, 202, 'wait=0'],
  ['  wait=0  ', kLong, 202, 'wait=0'],
  ['wait=0, wait=30', kLong, 202, 'wait=0'],
  ['wait=', kShort, 200, undefined],
  ['wait=-1', kShort, 200, undefined],
  ['wait=x', kShort, 200, undefined],
  ['wait=1.5', kShort, 200, undefined],
  ['wait=99999999999999999999999', kShort, 200, undefined],
  ['wait=1e1', kShort, 200, undefined],
  ['wait', kShort, 200, undefined],
  [',,;;,=', kShort, 200, undefined],
  ['handling=lenient', kShort, 200, undefined],
  ['', kShort, 200, undefined],
  [`${'x'.repeat(3000)}, respond-async`, kLong, 202, 'respond-async'],
];

describe('prefer', () => {
  const server = useFakeServer(['--workers', '4', '--queue-limit', '64']);

  for (const [prefer, grid, status, applied] of kForms)
    test(`Prefer: ${prefer?.slice(0, 40) ?? '(none)'} gives ${status}`, async () => {
      const headers = prefer === undefined ? {} : {Prefer: prefer};
      const answer = await server.post('/v1/regularize', grid(), {headers});
      assert.equal(answer.status, status, answer.text);
      assert.equal(answer.headers['preference-applied'], applied);
      if (status === 200) return;
      assert.equal(answer.headers.location, `/v1/jobs/${answer.headers['rivage-job']}`);
      assert.equal(answer.json.id, answer.headers['rivage-job']);
      assert.equal((await server.ask('DELETE', answer.headers.location)).status, 204);
    });

  test('two Prefer fields count as one', async () => {
    const headers = [
      ['Prefer', 'return=minimal'],
      ['Prefer', 'respond-async'],
    ];
    const answer = await server.post('/v1/regularize', fresh('slow'), {headers});
    assert.equal(answer.status, 202);
    await server.ask('DELETE', answer.headers.location);
  });

  test('POST /v1/jobs is accepted whatever it prefers', async () => {
    for (const prefer of ['wait=30', 'respond-async']) {
      const path = await server.submit(fresh(), {headers: {Prefer: prefer}});
      assert.equal((await server.follow(path)).state, 'succeeded');
    }
  });

  test('the job of a 202 can be followed to the same result', async () => {
    const grid = fresh('hold:50');
    const accepted = await server.post('/v1/regularize', grid, {
      headers: {Prefer: 'respond-async'},
    });
    assert.equal((await server.follow(accepted.headers.location)).state, 'succeeded');
    assert.equal(
      (await server.get(`${accepted.headers.location}/result`)).text,
      `asset of ${grid}`
    );
  });

  test('a long poll ends with the job, not with its time', async () => {
    const path = await server.submit(fresh('slow'));
    await server.inState(path, 'running');
    const since = Date.now();
    const waiting = server.get(path, {headers: {Prefer: 'wait=30'}});
    const first = await Promise.race([waiting, server.get('/version')]);
    assert.equal(first.json.name, 'rivage', 'the long poll waits');
    await server.ask('DELETE', path);
    const answer = await waiting;
    assert.equal(answer.json.state, 'canceled');
    assert.equal(answer.headers['preference-applied'], 'wait=30');
    assert.equal(answer.headers['retry-after'], undefined);
    assert.ok(Date.now() - since < 15000);
  });

  test('a long poll of a job that goes on ends after its time', async () => {
    const path = await server.submit(fresh('slow'));
    const answer = await server.get(path, {headers: {Prefer: 'wait=1'}});
    assert.ok(['queued', 'running'].includes(answer.json.state));
    assert.match(answer.headers['retry-after'], /^\d+$/);
    await server.ask('DELETE', path);
  });

  test('a long poll of a job that has ended is answered at once', async () => {
    const path = await server.submit(fresh());
    await server.follow(path);
    const since = Date.now();
    assert.equal((await server.get(path, {headers: {Prefer: 'wait=30'}})).json.state, 'succeeded');
    assert.ok(Date.now() - since < 15000);
  });

  test('more long polls than --long-polls are answered at once', async () => {
    await withFakeServer(['--long-polls', '1'], async (small) => {
      const path = await small.submit(fresh('slow'));
      await small.inState(path, 'running');
      const polls = [0, 1, 2].map(() => small.get(path, {headers: {Prefer: 'wait=30'}}));
      const early = await Promise.race(polls);
      assert.equal(early.json.state, 'running');
      await small.ask('DELETE', path);
      const states = (await Promise.all(polls)).map((answer) => answer.json.state);
      assert.deepEqual(states.sort(), ['canceled', 'running', 'running']);
    });
  });

  test('a client that leaves cancels its conversion', async () => {
    const connection = await server.connect();
    connection.send(
      'POST /v1/regularize HTTP/1.1\r\nHost: x\r\nContent-Length: 9\r\n\r\nslow-left'
    );
    const path = await eventually(async () => (await server.jobsIn('running'))[0], 'it runs');
    connection.close();
    assert.equal((await server.inState(path, 'canceled')).error.type, '/problems/canceled');
    await server.logged(
      (line) => line.event === 'request' && line.status === 499,
      'a line with 499'
    );
  });
});
