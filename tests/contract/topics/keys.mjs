// API keys: who may call, how often, and what of others they see.
import assert from 'node:assert/strict';
import {describe, test} from 'node:test';
import {fresh} from '../lib/grids.mjs';
import {useKeys} from '../lib/keys.mjs';
import {methodsOf, schema} from '../lib/schema.mjs';
import {assertProblem, refusedStart, useFolder, writeFile} from '../lib/server.mjs';

const kNoJob = '01234567-89ab-7def-8123-456789abcdef';
const concrete = (route) => route.replace('{id}', kNoJob).replace('{name}', 'island');

describe('keys', () => {
  const {server, keys} = useKeys(
    {
      alice: '',
      bob: '',
      off: 'disabled',
      old: 'expires=2020-01-31',
      new: 'expires=2099-12-31',
      few: 'rate=3/m',
      one: 'jobs=1',
    },
    ['--workers', '2', '--queue-limit', '64']
  );

  for (const [route, item] of Object.entries(schema.paths)) {
    if (item.servers) continue;
    for (const method of methodsOf(route)) {
      const isOpen = item[method.toLowerCase()].security !== undefined;
      test(`${method} ${route} is ${isOpen ? 'open' : 'closed'} without a key`, async () => {
        const body = method === 'POST' ? 'ok' : undefined;
        const answer = await server.ask(method, concrete(route), {body});
        if (isOpen) return assert.equal(answer.status, 200);
        assertProblem(answer, 401, 'unauthorized');
        for (const [key, status, slug] of [
          [keys.off, 403, 'forbidden'],
          [keys.old, 403, 'forbidden'],
          ['wrong', 401, 'unauthorized'],
        ])
          assertProblem(await server.ask(method, concrete(route), {body, key}), status, slug);
        const good = await server.ask(method, concrete(route), {body, key: keys.alice});
        assert.ok(![401, 403, 429].includes(good.status), String(good.status));
      });
    }
  }

  test("the viewer's files, HEAD and OPTIONS of open paths need no key; the admin port none at all", async () => {
    assert.equal((await server.ask('HEAD', '/')).status, 200);
    assert.equal((await server.get('/index.html', {asset: true})).status, 200);
    for (const path of ['/livez', '/readyz', '/metrics'])
      assert.equal((await server.get(path, {admin: true})).status, 200);
  });

  const forms = {
    Bearer: (key) => ({Authorization: `Bearer ${key}`}),
    bearer: (key) => ({Authorization: `bearer ${key}`}),
    'X-API-Key': (key) => ({'X-API-Key': key}),
  };
  for (const [what, make] of Object.entries(forms))
    test(`a key as ${what}`, async () => {
      assert.equal((await server.get('/v1/jobs', {headers: make(keys.alice)})).status, 200);
      assertProblem(await server.get('/v1/jobs', {headers: make('x')}), 401, 'unauthorized');
      assertProblem(await server.get('/v1/jobs', {headers: make(keys.off)}), 403, 'forbidden');
    });

  const wrong = [
    ['Authorization', ''],
    ['Authorization', 'Bearer'],
    ['Authorization', 'Bearer '],
    ['Authorization', 'Basic YTpi'],
    ['Authorization', 'Bearer x y'],
    ['Authorization', 'Digest x'],
    ['X-API-Key', ''],
    ['X-API-Key', 'alice'],
    ['X-API-Key', '\xff\xfe'],
    ['X-API-Key', 'k'.repeat(4000)],
  ];
  for (const [name, value] of wrong)
    test(`${name}: ${JSON.stringify(value.slice(0, 20))} is no key`, async () =>
      assertProblem(await server.get('/v1/jobs', {headers: {[name]: value}}), 401, 'unauthorized'));

  test('a part of a key, a key and more, and its hash are no key', async () => {
    for (const key of [keys.alice.slice(0, -1), `${keys.alice}x`, keys.alice.toUpperCase()])
      if (key !== keys.alice)
        assertProblem(await server.get('/v1/jobs', {key}), 401, 'unauthorized');
  });

  test('a key that expires later is good', async () =>
    assert.equal((await server.get('/v1/jobs', {key: keys.new})).status, 200));

  test('an unknown path under /v1 tells nothing without a key', async () =>
    assertProblem(await server.get('/v1/nothing'), 401, 'unauthorized'));

  test('401 comes before the body', async () => {
    const head = 'POST /v1/jobs HTTP/1.1\r\nHost: x\r\nContent-Length: 1000\r\n\r\n';
    assertProblem(
      await server.raw(head, {method: 'POST', target: '/v1/jobs'}),
      401,
      'unauthorized'
    );
  });

  test('the job of another is not there: show, result, events, preview, delete, list', async () => {
    const path = await server.submit(fresh(), {key: keys.alice});
    await server.follow(path, {key: keys.alice});
    for (const suffix of ['', '/result', '/events', '/preview'])
      assertProblem(await server.get(path + suffix, {key: keys.bob}), 404, 'not-found');
    assertProblem(await server.ask('DELETE', path, {key: keys.bob}), 404, 'not-found');
    const ids = async (key) =>
      (await server.get('/v1/jobs?limit=500', {key})).json.jobs.map((job) => job.links.self);
    assert.ok(!(await ids(keys.bob)).includes(path));
    assert.ok((await ids(keys.alice)).includes(path));
    assert.equal((await server.get(path, {key: keys.alice})).status, 200);
  });

  test('the same content of two owners: two jobs, one result', async () => {
    const body = fresh();
    const [first, second] = [
      await server.post('/v1/regularize', body, {key: keys.alice}),
      await server.post('/v1/regularize', body, {key: keys.bob}),
    ];
    assert.deepEqual(second.body, first.body);
    assert.notEqual(second.headers['rivage-job'], first.headers['rivage-job']);
    assertProblem(
      await server.get(`/v1/jobs/${first.headers['rivage-job']}`, {key: keys.bob}),
      404,
      'not-found'
    );
  });

  test('the same idempotency key of two owners is two keys', async () => {
    const headers = {'Idempotency-Key': fresh('key')};
    const first = await server.submit(fresh(), {key: keys.alice, headers});
    const answer = await server.post('/v1/jobs', fresh(), {key: keys.bob, headers});
    assert.equal(answer.status, 202, answer.text);
    assert.equal(answer.headers['idempotent-replayed'], undefined);
    assert.notEqual(answer.headers.location, first);
  });

  test('more requests a minute than the rate: 429 with when to come back', async () => {
    for (let i = 0; i < 3; ++i)
      assert.equal((await server.get('/v1/limits', {key: keys.few})).status, 200);
    const answer = await server.get('/v1/limits', {key: keys.few});
    assertProblem(answer, 429, 'quota-exceeded');
    assert.equal(answer.headers['ratelimit-policy'], '"requests";q=3;w=60');
    assert.match(answer.headers.ratelimit, /^"requests";r=0;t=[1-9]\d*$/);
    assert.equal((await server.get('/v1/limits', {key: keys.alice})).status, 200, 'others go on');
  });

  test('every route under /v1 counts, and is refused', async () => {
    for (const [route, item] of Object.entries(schema.paths)) {
      if (item.servers || !route.startsWith('/v1/')) continue;
      for (const method of methodsOf(route))
        assertProblem(
          await server.ask(method, concrete(route), {
            key: keys.few,
            body: method === 'POST' ? 'ok' : undefined,
          }),
          429,
          'quota-exceeded'
        );
    }
    assert.equal((await server.get('/version')).status, 200);
  });

  test('more jobs at a time than the quota: 429, and free again after', async () => {
    const path = await server.submit(fresh('slow'), {key: keys.one});
    for (const route of ['/v1/jobs', '/v1/regularize']) {
      const answer = await server.post(route, fresh(), {key: keys.one});
      assertProblem(answer, 429, 'quota-exceeded');
      assert.equal(answer.headers['ratelimit-policy'], '"jobs";q=1');
    }
    assert.equal((await server.get(path, {key: keys.one})).status, 200, 'reading goes on');
    await server.ask('DELETE', path, {key: keys.one});
    await server.follow(path, {key: keys.one});
    assert.equal((await server.post('/v1/regularize', fresh(), {key: keys.one})).status, 200);
  });

  test('no key is in the log', async () => {
    const text = JSON.stringify(server.log);
    for (const key of Object.values(keys)) assert.ok(!text.includes(key));
  });
});

describe('key files', () => {
  const folder = useFolder();
  const hash = 'a'.repeat(64);
  const lines = {
    'no hash': 'alice',
    'a short hash': 'alice sha256:abc',
    'another algorithm': `alice md5:${hash}`,
    'an unknown setting': `alice sha256:${hash} colour=red`,
    'a rate without sense': `alice sha256:${hash} rate=x`,
    'no jobs': `alice sha256:${hash} jobs=-1`,
    'a date that is none': `alice sha256:${hash} expires=2027-13-99`,
    'a name twice': `alice sha256:${hash}\nalice sha256:${'b'.repeat(64)}`,
    'a key in clear': 'alice secret-key',
  };
  for (const [what, line] of Object.entries(lines))
    test(`a key file with ${what} stops the start`, async () => {
      const file = writeFile(folder, `keys-${Object.keys(lines).indexOf(what)}`, `${line}\n`);
      assert.notEqual(await refusedStart(['--api-keys', file], {fake: true}), 0);
    });

  test('a key file that is not there stops the start', async () =>
    assert.notEqual(await refusedStart(['--api-keys', `${folder}/none`], {fake: true}), 0));
});
