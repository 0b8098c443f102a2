// Every route with every method, on both ports.
import assert from 'node:assert/strict';
import {describe, test} from 'node:test';
import {allowedOf, schema} from '../lib/schema.mjs';
import {assertProblem, useFakeServer} from '../lib/server.mjs';

const kMethods = ['GET', 'HEAD', 'POST', 'PUT', 'PATCH', 'DELETE', 'OPTIONS', 'TRACE'];
const kNoJob = '01234567-89ab-7def-8123-456789abcdef';

const concrete = (route) => route.replace('{id}', kNoJob).replace('{name}', 'none');

describe('methods', () => {
  const server = useFakeServer();

  for (const [route, item] of Object.entries(schema.paths)) {
    const admin = Boolean(item.servers);
    const allowed = allowedOf(route);
    test(`${route} takes ${[...allowed].join(' ')} and refuses the others`, async () => {
      for (const method of kMethods) {
        if (admin && method === 'OPTIONS') continue;
        const answer = await server.ask(method, concrete(route), {
          admin,
          body: method === 'POST' ? 'ok' : undefined,
        });
        if (!allowed.has(method))
          assert.ok([400, 404, 405].includes(answer.status), `${method}: ${answer.status}`);
        else if (method === 'OPTIONS') assert.equal(answer.status, 204);
        else assert.notEqual(answer.status, 405, method);
        if (!allowed.has(method) && !admin) assert.equal(answer.status, 405, method);
      }
    });
  }

  for (const [route, item] of Object.entries(schema.paths)) {
    if (!item.get || item.servers || route.includes('{id}')) continue;
    const path = concrete(route).replace('/none', '/island');
    test(`HEAD ${route} has the head of GET and no body`, async () => {
      const [get, head] = [await server.get(path), await server.ask('HEAD', path)];
      assert.equal(head.status, get.status);
      for (const name of ['content-type', 'etag', 'content-disposition'])
        assert.equal(head.headers[name], get.headers[name], name);
      assert.equal(head.headers['content-length'], String(get.body.length));
    });
  }

  for (const path of [
    '/nothing',
    '/v1',
    '/v1/',
    '/v2/jobs',
    '/v1/jobs/',
    '/v1/jobs/a/b/c',
    '/metrics',
    '/livez',
    '/v1/regularize/x',
    '/V1/JOBS',
    '/v1/jobs.json',
    '/problems/not-found',
  ])
    test(`${path} is not there, whatever the method`, async () => {
      for (const method of kMethods) {
        const answer = await server.ask(method, path);
        assert.equal(answer.status, 404, method);
        if (method !== 'HEAD') assertProblem(answer, 404, 'not-found');
      }
    });

  test('a method that nobody knows is refused', async () => {
    const answer = await server.raw('BREW / HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n', {
      method: 'BREW',
      target: '/',
    });
    assert.ok([400, 405].includes(answer.status));
  });

  test('the admin port has none of the routes of /v1, and the other port none of the admin port', async () => {
    for (const path of ['/v1/jobs', '/', '/version', '/openapi.json', '/debug', '/metrics/x'])
      assertProblem(await server.get(path, {admin: true}), 404, 'not-found');
    for (const path of ['/livez', '/readyz', '/startupz', '/metrics'])
      assertProblem(await server.get(path), 404, 'not-found');
  });
});
