// Expect: 100-continue: the answer comes before the body, of which not a byte is sent here.
import assert from 'node:assert/strict';
import {describe, test} from 'node:test';
import {fresh} from '../lib/grids.mjs';
import {useKeys} from '../lib/keys.mjs';
import {
  Answer,
  assertProblem,
  requestBytes,
  useFakeServer,
  withFakeServer,
} from '../lib/server.mjs';

const kPosts = ['/v1/regularize', '/v1/jobs', '/v1/inspect'];

// Sends a head that announces a body and waits for the first answer.
async function expect(server, target, headers = {}) {
  const connection = await server.connect();
  connection.send(
    requestBytes('POST', target, {
      headers: {Expect: '100-continue', 'Content-Length': '2', ...headers},
    })
  );
  const head = await connection.anyHead();
  if (head.status === 100) return {connection, status: 100};
  const pieces = [];
  for await (const piece of connection.pieces(head, 'POST')) pieces.push(piece);
  const answer = new Answer(head, Buffer.concat(pieces));
  server.check('POST', target, answer);
  connection.close();
  return answer;
}

describe('expect', () => {
  const server = useFakeServer(['--max-upload', '1000']);

  for (const route of kPosts)
    test(`${route}: 100, and then the answer to the body`, async () => {
      const {connection, status} = await expect(server, route);
      assert.equal(status, 100);
      connection.send('ok');
      const answer = await connection.answer('POST');
      server.check('POST', route, answer);
      assert.equal(answer.status, route === '/v1/jobs' ? 202 : 200);
      connection.close();
    });

  for (const route of kPosts) {
    test(`${route}: 413 for a length above the limit`, async () =>
      assertProblem(await expect(server, route, {'Content-Length': '1001'}), 413, 'too-large'));
    test(`${route}: 415 for an encoding that nobody knows`, async () =>
      assertProblem(
        await expect(server, route, {'Content-Encoding': 'br'}),
        415,
        'unsupported-encoding'
      ));
    test(`${route}: 400 for an option that does not exist`, async () =>
      assertProblem(await expect(server, `${route}?colour=red`), 400, 'unknown-option'));
    test(`${route}: 400 for a digest without sense`, async () =>
      assertProblem(
        await expect(server, route, {'Content-Digest': 'sha-256=x'}),
        400,
        'malformed-request'
      ));
  }

  for (const route of ['/v1/regularize', '/v1/jobs'])
    test(`${route}: 400 for a malformed key`, async () =>
      assertProblem(
        await expect(server, route, {'Idempotency-Key': 'a b'}),
        400,
        'malformed-request'
      ));

  test('404 and 405 come before the body too', async () => {
    assertProblem(await expect(server, '/v1/nothing'), 404, 'not-found');
    assertProblem(await expect(server, '/version'), 405, 'method-not-allowed');
  });

  test('503 while the server is full', async () => {
    await withFakeServer(['--workers', '1', '--queue-limit', '0'], async (full) => {
      await full.inState(await full.submit(fresh('slow')), 'running');
      for (const route of kPosts) assertProblem(await expect(full, route), 503, 'queue-full');
    });
  });

  test('another expectation cannot be met', async () =>
    assertProblem(
      await expect(server, '/v1/regularize', {Expect: 'the-unexpected'}),
      417,
      'expectation-failed'
    ));

  test('no 100 for a request without a body that waits', async () => {
    const answer = await server.post('/v1/regularize', 'ok', {headers: {}});
    assert.deepEqual(answer.informational, []);
  });
});

describe('expect with keys', () => {
  const {server, keys} = useKeys({alice: '', off: 'disabled'});

  test('401 without a key, 403 for a disabled one, 100 for a good one', async () => {
    for (const route of kPosts) {
      assertProblem(await expect(server, route), 401, 'unauthorized');
      assertProblem(await expect(server, route, {'X-API-Key': keys.off}), 403, 'forbidden');
      const {connection, status} = await expect(server, route, {'X-API-Key': keys.alice});
      assert.equal(status, 100);
      connection.close();
    }
  });
});
