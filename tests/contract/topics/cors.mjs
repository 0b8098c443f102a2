// Cross-origin requests: off, unless the origin is named exactly.
import assert from 'node:assert/strict';
import {describe, test} from 'node:test';
import {fresh} from '../lib/grids.mjs';
import {useKeys} from '../lib/keys.mjs';
import {useFakeServer} from '../lib/server.mjs';

const kOrigin = 'https://app.example';
const kPreflight = {
  'Access-Control-Request-Method': 'POST',
  'Access-Control-Request-Headers': 'content-type, idempotency-key',
};
const kPaths = ['/v1/regularize', '/v1/jobs', '/v1/limits'];

const allowed = (answer) => answer.headers['access-control-allow-origin'];
const preflight = (server, path, origin, more = {}) =>
  server.ask('OPTIONS', path, {headers: {Origin: origin, ...kPreflight, ...more}});

describe('cors off', () => {
  const server = useFakeServer();
  test('nothing is said to any origin', async () => {
    for (const path of kPaths) {
      const answer = await preflight(server, path, kOrigin);
      assert.equal(allowed(answer), undefined);
      assert.equal(answer.headers['access-control-allow-methods'], undefined);
    }
    assert.equal(allowed(await server.get('/v1/limits', {headers: {Origin: kOrigin}})), undefined);
  });
});

describe('cors on', () => {
  const {server, keys} = useKeys({alice: ''}, ['--cors-origin', kOrigin]);

  for (const path of kPaths)
    test(`a preflight of ${path} from the origin, without a key`, async () => {
      const answer = await preflight(server, path, kOrigin);
      assert.equal(answer.status, 204);
      assert.equal(allowed(answer), kOrigin);
      assert.match(answer.headers['access-control-allow-methods'], /\b(POST|GET)\b/);
      assert.match(answer.headers['access-control-max-age'], /^[1-9]\d*$/);
      assert.match(answer.headers.vary, /\bOrigin\b/i);
      const names = answer.headers['access-control-allow-headers'].toLowerCase().split(/, */);
      for (const name of [
        'authorization',
        'content-type',
        'idempotency-key',
        'prefer',
        'content-digest',
        'content-disposition',
        'x-api-key',
      ])
        assert.ok(names.includes(name), name);
      assert.equal(answer.headers['access-control-allow-credentials'], undefined);
    });

  for (const origin of [
    'https://evil.example',
    'http://app.example',
    'https://app.example:444',
    'https://app.example.evil.example',
    'https://APP.example.',
    'null',
    '*',
    'https://app.example/',
    '',
  ])
    test(`nothing is said to the origin ${JSON.stringify(origin)}`, async () => {
      for (const path of kPaths)
        assert.equal(allowed(await preflight(server, path, origin)), undefined);
      assert.equal(
        allowed(await server.get('/v1/limits', {headers: {Origin: origin}, key: keys.alice})),
        undefined
      );
    });

  test('an answer to the origin may be read, with its fields', async () => {
    const answer = await server.post('/v1/regularize', fresh(), {
      headers: {Origin: kOrigin},
      key: keys.alice,
    });
    assert.equal(allowed(answer), kOrigin);
    assert.match(answer.headers.vary, /\bOrigin\b/i);
    const names = answer.headers['access-control-expose-headers'].toLowerCase().split(/, */);
    for (const name of [
      'location',
      'rivage-job',
      'retry-after',
      'etag',
      'repr-digest',
      'server-timing',
      'x-request-id',
    ])
      assert.ok(names.includes(name), name);
  });

  test('problems may be read too: 401, 404, 405, 400', async () => {
    const headers = {Origin: kOrigin};
    for (const [method, path, key, status] of [
      ['GET', '/v1/jobs', undefined, 401],
      ['GET', '/nothing', undefined, 404],
      ['PUT', '/v1/jobs', keys.alice, 405],
      ['GET', '/v1/jobs?limit=x', keys.alice, 400],
    ]) {
      const answer = await server.ask(method, path, {headers, key});
      assert.equal(answer.status, status);
      assert.equal(allowed(answer), kOrigin, path);
    }
  });

  test('OPTIONS without a method to ask for is no preflight', async () => {
    const answer = await server.ask('OPTIONS', '/version', {headers: {Origin: kOrigin}});
    assert.equal(answer.status, 204);
    assert.equal(answer.headers.allow, 'GET, HEAD, OPTIONS');
  });

  test('answers to no origin still vary by it', async () =>
    assert.match(
      (await server.get('/v1/limits', {key: keys.alice})).headers.vary ?? '',
      /\bOrigin\b/i
    ));
});
