// How a grid comes in: as the body, chunked, or as a part of a form.
import assert from 'node:assert/strict';
import {describe, test} from 'node:test';
import {form, fresh, kBytes} from '../lib/grids.mjs';
import {assertProblem, useFakeServer} from '../lib/server.mjs';

const kPosts = ['/v1/regularize', '/v1/jobs', '/v1/inspect'];

describe('uploads', () => {
  const server = useFakeServer(['--max-upload', '100000']);
  const send = (parts, options) => {
    const {body, headers} = form(parts, options);
    return server.post('/v1/regularize', body, {headers});
  };

  for (const route of kPosts)
    test(`${route} takes a body with a length, in chunks, and a form`, async () => {
      const expected = route === '/v1/jobs' ? 202 : 200;
      const grid = fresh();
      const {body, headers} = form([['grid', grid]]);
      assert.equal((await server.post(route, grid)).status, expected);
      assert.equal((await server.post(route, grid, {headers: kBytes})).status, expected);
      assert.equal((await server.post(route, grid, {chunked: true})).status, expected);
      assert.equal((await server.post(route, body, {headers})).status, expected);
      assert.equal((await server.post(route, body, {headers, chunked: true})).status, expected);
    });

  for (const route of kPosts)
    test(`${route} without a grid is malformed`, async () => {
      assertProblem(await server.post(route, ''), 400, 'malformed-request', {field: '/grid'});
      assertProblem(await server.post(route, '', {chunked: true}), 400, 'malformed-request');
      const {body, headers} = form([['options', '{}']]);
      assertProblem(await server.post(route, body, {headers}), 400, 'malformed-request', {
        field: '/grid',
      });
    });

  for (const type of [
    'application/octet-stream',
    'application/x-whatever',
    'text/plain',
    'image/png; x=y',
    'application/x-www-form-urlencoded',
  ])
    test(`a body of the type ${type} is a grid`, async () => {
      const grid = fresh();
      const answer = await server.post('/v1/regularize', grid, {headers: {'Content-Type': type}});
      assert.equal(answer.text, `asset of ${grid}`);
    });

  const options = ['options', '{"alpha": 0.5}'];
  for (const [order, parts] of [
    ['grid first', (grid) => [['grid', grid], options]],
    ['options first', (grid) => [options, ['grid', grid]]],
  ])
    test(`a form with the ${order}`, async () => {
      const grid = fresh();
      const {body, headers} = form(parts(grid));
      const path = await server.submit(body, {headers});
      const job = await server.follow(path);
      assert.equal(job.options.alpha, 0.5);
      assert.equal((await server.get(`${path}/result`)).text, `asset of ${grid}`);
    });

  test('the query counts beside a form', async () => {
    const {body, headers} = form([['grid', fresh()], options]);
    const path = await server.submit(body, {headers, query: '?beta=0.25'});
    const job = await server.follow(path);
    assert.deepEqual([job.options.alpha, job.options.beta], [0.5, 0.25]);
  });

  test('an option in the query and in the form is given twice', async () => {
    const {body, headers} = form([['grid', fresh()], options]);
    assertProblem(
      await server.post('/v1/regularize?alpha=0.5', body, {headers}),
      400,
      'invalid-option',
      {field: '/options/alpha'}
    );
  });

  const names = {
    'plain.vox': 'plain',
    '../../etc/passwd': 'passwd',
    '..\\\\..\\\\boot.ini': 'boot',
    'a b.vox': 'a_b',
    'x;y=z.vox': '',
    '\xe9\xe8.vox': '__',
    '.htaccess': '',
    CON: 'CON',
    [`${'n'.repeat(300)}.vox`]: 'n'.repeat(64),
  };
  for (const [name, stem] of Object.entries(names))
    test(`the file name ${JSON.stringify(name.slice(0, 24))} is harmless`, async () => {
      const answer = await send([['grid', fresh(), {filename: name}]]);
      assert.equal(answer.status, 200, answer.text);
      const match = /^attachment; filename="([A-Za-z0-9_-]*)\.glb"$/.exec(
        answer.headers['content-disposition']
      );
      assert.ok(match, answer.headers['content-disposition']);
      if (stem) assert.equal(match[1], stem);
    });

  const broken = {
    'an unknown part': [
      [
        ['grid', 'ok'],
        ['colour', 'red'],
      ],
    ],
    'the grid twice': [
      [
        ['grid', 'ok'],
        ['grid', 'ok'],
      ],
    ],
    'the options twice': [[options, ['grid', 'ok'], options]],
    'a part without a name': [
      [
        ['grid', 'ok'],
        ['', 'x', {raw: 'Content-Disposition: form-data\r\n'}],
      ],
    ],
    'no part': [[]],
    'no end': [[['grid', 'ok']], {end: false}],
    'an empty grid': [[['grid', '']]],
    '1000 parts': [Array.from({length: 1000}, (_, i) => [`part${i}`, 'x'])],
    'options that are too long': [
      [
        ['options', `{"x": "${'y'.repeat(70000)}"}`],
        ['grid', 'ok'],
      ],
    ],
    'a header field without an end': [
      [
        [
          'grid',
          'ok',
          {raw: `X: ${'y'.repeat(20000)}\r\nContent-Disposition: form-data; name="grid"\r\n`},
        ],
      ],
    ],
  };
  for (const [what, [parts, how]] of Object.entries(broken))
    test(`a form with ${what} is malformed`, async () =>
      assertProblem(await send(parts, how), 400, 'malformed-request'));

  for (const type of [
    'multipart/form-data',
    'multipart/form-data; boundary=',
    'multipart/form-data; boundary=other',
    `multipart/form-data; boundary=${'b'.repeat(300)}`,
    'multipart/form-data; boundary="fron tier"',
  ])
    test(`the type ${type.slice(0, 50)} fits no form`, async () => {
      const {body} = form([['grid', 'ok']]);
      const answer = await server.post('/v1/regularize', body, {headers: {'Content-Type': type}});
      assertProblem(answer, 400, 'malformed-request');
    });

  for (const method of ['raw', 'chunked', 'form'])
    test(`a grid of as many bytes as allowed, and one more: ${method}`, async () => {
      for (const [size, status] of [
        [100000, 200],
        [100001, 413],
      ]) {
        const grid = fresh().padEnd(size, 'x');
        const {body, headers} =
          method === 'form' ? form([['grid', grid]]) : {body: grid, headers: {}};
        const answer = await server.post('/v1/regularize', body, {
          headers,
          chunked: method === 'chunked',
        });
        assert.equal(answer.status, status);
        if (status === 413)
          assertProblem(answer, 413, 'too-large', {
            limit: 100000,
            setting: '--max-upload',
            field: '/grid',
          });
      }
    });

  for (const route of kPosts)
    test(`${route} refuses a length above the limit before the body`, async () => {
      const head = `POST ${route} HTTP/1.1\r\nHost: x\r\nContent-Length: 100001\r\n\r\n`;
      assertProblem(await server.raw(head, {method: 'POST', target: route}), 413, 'too-large', {
        limit: 100000,
        actual: 100001,
        setting: '--max-upload',
      });
    });

  test('a body that ends too early is no grid', async () => {
    for (const bytes of [
      'Content-Length: 10\r\n\r\nok',
      'Transfer-Encoding: chunked\r\n\r\n5\r\nok',
    ]) {
      const connection = await server.connect();
      connection.send(`POST /v1/jobs HTTP/1.1\r\nHost: x\r\n${bytes}`);
      connection.socket.end();
      const head = await connection.head().catch(() => undefined);
      assert.ok(head === undefined || head.status === 400, 'refused, if answered');
      connection.close();
    }
    assert.equal((await server.get('/v1/jobs?state=queued')).json.jobs.length, 0);
  });
});
