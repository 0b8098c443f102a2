// Idempotency-Key: the same request twice is one job, another request is none.
import assert from 'node:assert/strict';
import {describe, test} from 'node:test';
import {form, fresh} from '../lib/grids.mjs';
import {assertProblem, eventually, requestBytes, useFakeServer} from '../lib/server.mjs';

const withKey = (key) => ({headers: {'Idempotency-Key': key}});
const kField = '/headers/idempotency-key';

describe('idempotency', () => {
  const server = useFakeServer(['--workers', '4', '--queue-limit', '256']);

  for (const [state, grid] of [
    ['queued or running', () => fresh('slow')],
    ['ended', () => fresh()],
  ])
    test(`the same post again is the same job: ${state}`, async () => {
      const [body, key] = [grid(), fresh('key')];
      const first = await server.post('/v1/jobs', body, withKey(key));
      assert.equal(first.status, 202);
      assert.equal(first.headers['idempotent-replayed'], undefined);
      if (state === 'ended') await server.follow(first.headers.location);
      const second = await server.post('/v1/jobs', body, withKey(key));
      assert.equal(second.status, 202);
      assert.equal(second.headers['idempotent-replayed'], 'true');
      assert.equal(second.headers.location, first.headers.location);
      await server.ask('DELETE', first.headers.location);
    });

  test('a replayed conversion has the same job and the same bytes', async () => {
    const [body, key] = [fresh(), fresh('key')];
    const first = await server.post('/v1/regularize', body, withKey(key));
    const second = await server.post('/v1/regularize', body, withKey(key));
    assert.deepEqual([first.status, second.status], [200, 200]);
    assert.equal(second.headers['idempotent-replayed'], 'true');
    assert.equal(second.headers['rivage-job'], first.headers['rivage-job']);
    assert.deepEqual(second.body, first.body);
    assert.equal(second.headers.etag, first.headers.etag);
  });

  test('a failed conversion is replayed as its problem', async () => {
    const key = fresh('key');
    for (const replayed of [undefined, 'true']) {
      const answer = await server.post('/v1/regularize', 'empty', withKey(key));
      assertProblem(answer, 422, 'empty-grid');
      assert.equal(answer.headers['idempotent-replayed'], replayed);
    }
  });

  test('sync and async share a key: the conversion is found as a job', async () => {
    const [body, key] = [fresh(), fresh('key')];
    const first = await server.post('/v1/regularize', body, withKey(key));
    const second = await server.post('/v1/jobs', body, withKey(key));
    assert.equal(second.status, 202);
    assert.equal(second.json.id, first.headers['rivage-job']);
    assert.equal(second.json.state, 'succeeded');
  });

  test('a form and a raw body with the same content are the same request', async () => {
    const [body, key] = [fresh(), fresh('key')];
    const first = await server.post('/v1/jobs?alpha=0.5', body, withKey(key));
    const {headers, body: bytes} = form([
      ['grid', body],
      ['options', '{"alpha": 0.5}'],
    ]);
    const second = await server.post('/v1/jobs', bytes, {
      headers: {...headers, 'Idempotency-Key': key},
    });
    assert.equal(second.status, 202, second.text);
    assert.equal(second.headers.location, first.headers.location);
  });

  for (const route of ['/v1/jobs', '/v1/regularize'])
    for (const [what, other] of [
      ['content', (body) => [`${body}x`, '']],
      ['options', (body) => [body, '?alpha=0.25']],
    ])
      test(`the same key with other ${what} at ${route} is refused`, async () => {
        const [body, key] = [fresh(), fresh('key')];
        await server.submit(body, withKey(key));
        const [changed, query] = other(body);
        const answer = await server.post(route + query, changed, withKey(key));
        assertProblem(answer, 422, 'idempotency-mismatch');
      });

  for (const route of ['/v1/jobs', '/v1/regularize'])
    test(`while the first is being received, the second at ${route} is told to come back`, async () => {
      // The second may overtake the first between its 100 and its first byte: then with another key.
      const {key, body, connection, answer} = await eventually(async () => {
        const first = {key: fresh('key'), body: fresh(), connection: await server.connect()};
        const headers = {'Idempotency-Key': first.key, Expect: '100-continue'};
        const bytes = requestBytes('POST', route, {body: first.body, headers});
        first.connection.send(bytes.subarray(0, -first.body.length));
        assert.equal((await first.connection.anyHead()).status, 100);
        first.connection.send(first.body.slice(0, -3));
        first.answer = await server.post(route, first.body, withKey(first.key));
        return first.answer.status === 409 && first;
      }, 'the first is being received');
      assertProblem(answer, 409, 'idempotency-in-progress');
      assert.match(answer.headers['retry-after'], /^\d+$/);
      connection.send(body.slice(-3));
      const first = await connection.answer('POST');
      assert.ok([200, 202].includes(first.status));
      const later = await server.post(route, body, withKey(key));
      assert.equal(later.headers['idempotent-replayed'], 'true');
      assert.equal(later.headers['rivage-job'], first.headers['rivage-job']);
    });

  test('a first that breaks off leaves its key free', async () => {
    const [body, key] = [fresh(), fresh('key')];
    const connection = await server.connect();
    connection.send(requestBytes('POST', '/v1/jobs', {body, ...withKey(key)}).subarray(0, -3));
    connection.close();
    const answer = await eventually(async () => {
      const again = await server.post('/v1/jobs', body, withKey(key));
      return again.status !== 409 && again;
    }, 'the key is free');
    assert.equal(answer.status, 202);
    assert.equal(answer.headers['idempotent-replayed'], undefined);
  });

  test('a refused first leaves its key free', async () => {
    const [body, key] = [fresh(), fresh('key')];
    assert.equal((await server.post('/v1/jobs?colour=red', body, withKey(key))).status, 400);
    assert.equal((await server.post('/v1/jobs', body, withKey(key))).status, 202);
  });

  for (const key of [
    '',
    ' ',
    'a b',
    '"',
    '"open',
    '"a"b"',
    'x'.repeat(256),
    'k\xe4se',
    '"tab\there"',
    'a"b',
    '""',
  ])
    test(`the key ${JSON.stringify(key.slice(0, 20))} is malformed`, async () => {
      for (const route of ['/v1/jobs', '/v1/regularize'])
        assertProblem(await server.post(route, fresh(), withKey(key)), 400, 'malformed-request', {
          field: kField,
        });
    });

  test('two keys in one request are malformed', async () => {
    const headers = [
      ['Idempotency-Key', 'a'],
      ['Idempotency-Key', 'b'],
    ];
    assertProblem(await server.post('/v1/jobs', fresh(), {headers}), 400, 'malformed-request', {
      field: kField,
    });
  });

  test('the quoted and the bare form are the same key; 255 characters are allowed', async () => {
    for (const key of [fresh('key'), fresh('key').padEnd(255, 'k')]) {
      const body = fresh();
      const first = await server.submit(body, withKey(key));
      const second = await server.post('/v1/jobs', body, withKey(`"${key}"`));
      assert.equal(second.status, 202, second.text);
      assert.equal(second.headers.location, first);
      assert.equal(second.headers['idempotent-replayed'], 'true');
    }
  });

  test('a forgotten job takes its key with it', async () => {
    const [body, key] = [fresh(), fresh('key')];
    const first = await server.submit(body, withKey(key));
    await server.follow(first);
    await server.ask('DELETE', first);
    const second = await server.post('/v1/jobs', `${body}x`, withKey(key));
    assert.equal(second.status, 202, second.text);
    assert.equal(second.headers['idempotent-replayed'], undefined);
  });

  test('100 posts with one key at once are one job', async () => {
    const [body, key] = [fresh('hold:200'), fresh('key')];
    const answers = await Promise.all(
      Array.from({length: 100}, () =>
        eventually(async () => {
          const answer = await server.post('/v1/jobs', body, withKey(key));
          if (answer.status !== 409) return answer;
          return assertProblem(answer, 409, 'idempotency-in-progress');
        }, 'it is accepted')
      )
    );
    for (const answer of answers) assert.equal(answer.status, 202, answer.text);
    assert.equal(new Set(answers.map((answer) => answer.json.id)).size, 1);
    assert.equal(answers.filter((answer) => !answer.headers['idempotent-replayed']).length, 1);
  });
});
