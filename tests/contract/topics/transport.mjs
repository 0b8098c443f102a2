// Bytes that no proper client sends. Whatever comes, the answer is a problem or nothing, and the
// server goes on.
import assert from 'node:assert/strict';
import {describe, test} from 'node:test';
import {assertProblem, requestBytes, useFakeServer} from '../lib/server.mjs';

const post = (lines, body = '') => `POST /v1/regularize HTTP/1.1\r\nHost: x\r\n${lines}\r\n${body}`;
const get = (lines) => `GET /version HTTP/1.1\r\n${lines}\r\n`;

// 400, and the connection ends: what follows on it cannot be trusted.
const kMalformed = {
  nonsense: 'nonsense\r\n\r\n',
  'an empty method': ' / HTTP/1.1\r\nHost: x\r\n\r\n',
  'a method with a space': 'GE T / HTTP/1.1\r\nHost: x\r\n\r\n',
  'HTTP/0.9': 'GET /\r\n\r\n',
  'HTTP/9.9': 'GET / HTTP/9.9\r\nHost: x\r\n\r\n',
  'HTTP/1.1 in small letters': 'GET / http/1.1\r\nHost: x\r\n\r\n',
  'the preface of HTTP/2': 'PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n',
  'a TLS hello': '\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03\r\n\r\n',
  'no target': 'GET HTTP/1.1\r\nHost: x\r\n\r\n',
  'two spaces before the target': 'GET  / HTTP/1.1\r\nHost: x\r\n\r\n',
  'a space in the target': 'GET /a b HTTP/1.1\r\nHost: x\r\n\r\n',
  'a NUL in the target': 'GET /\0 HTTP/1.1\r\nHost: x\r\n\r\n',
  'a NUL in a field': get('Host: x\r\nX: a\0b\r\n'),
  'a CR in a field': get('Host: x\r\nX: a\rb\r\n'),
  'a line that ends with LF': 'GET /version HTTP/1.1\nHost: x\n\n',
  'a field that ends with LF': 'GET /version HTTP/1.1\r\nHost: x\nX: y\r\n\r\n',
  'a folded field': get('Host: x\r\nX: a\r\n b\r\n'),
  'a field without a colon': get('Host: x\r\nnonsense\r\n'),
  'a field without a name': get('Host: x\r\n: y\r\n'),
  'a space before the colon': get('Host: x\r\nX : y\r\n'),
  'a field first of all that is folded': get(' X: y\r\nHost: x\r\n'),
  'no Host': get(''),
  'two Hosts': get('Host: x\r\nHost: y\r\n'),
  'two different lengths': post('Content-Length: 2\r\nContent-Length: 3\r\n', 'ok'),
  'two lengths in one field': post('Content-Length: 2, 3\r\n', 'ok'),
  'a negative length': post('Content-Length: -2\r\n', 'ok'),
  'a length with a sign': post('Content-Length: +2\r\n', 'ok'),
  'a length in hex': post('Content-Length: 0x2\r\n', 'ok'),
  'a length with a letter': post('Content-Length: 2x\r\n', 'ok'),
  'an empty length': post('Content-Length: \r\n', 'ok'),
  'a length above 2^64': post('Content-Length: 99999999999999999999999\r\n', 'ok'),
  'a length and chunks': post(
    'Content-Length: 2\r\nTransfer-Encoding: chunked\r\n',
    '2\r\nok\r\n0\r\n\r\n'
  ),
  'chunks and a length': post(
    'Transfer-Encoding: chunked\r\nContent-Length: 2\r\n',
    '2\r\nok\r\n0\r\n\r\n'
  ),
  'a transfer encoding that nobody knows': post('Transfer-Encoding: magic\r\n', 'ok'),
  'chunked twice': post('Transfer-Encoding: chunked, chunked\r\n', '2\r\nok\r\n0\r\n\r\n'),
  'chunked, and not last': post('Transfer-Encoding: chunked, identity\r\n', '2\r\nok\r\n0\r\n\r\n'),
  'chunked behind a tab': post('Transfer-Encoding:\x0bchunked\r\n', '2\r\nok\r\n0\r\n\r\n'),
  'a chunk of -2 bytes': post('Transfer-Encoding: chunked\r\n', '-2\r\nok\r\n0\r\n\r\n'),
  'a chunk of 0x2 bytes': post('Transfer-Encoding: chunked\r\n', '0x2\r\nok\r\n0\r\n\r\n'),
  'a chunk with a size above 2^64': post(
    'Transfer-Encoding: chunked\r\n',
    `${'f'.repeat(17)}\r\nok\r\n0\r\n\r\n`
  ),
  'a chunk without a size': post('Transfer-Encoding: chunked\r\n', '\r\nok\r\n0\r\n\r\n'),
  'a chunk that is longer than it says': post(
    'Transfer-Encoding: chunked\r\n',
    '2\r\nokok\r\n0\r\n\r\n'
  ),
};

describe('transport', () => {
  const server = useFakeServer();
  const alive = async () => assert.equal((await server.get('/version')).status, 200);

  for (const [what, bytes] of Object.entries(kMalformed))
    test(`${what}: 400, and the end of the connection`, async () => {
      const connection = await server.connect();
      connection.send(bytes);
      const answer = await connection.answer('POST');
      assert.ok([400, 431].includes(answer.status), String(answer.status));
      server.check('POST', '/v1/regularize', answer);
      assert.equal(answer.headers.connection, 'close');
      await connection.closed();
      await alive();
    });

  test('an empty Host is allowed, and the absolute form of a target', async () => {
    const empty = await server.raw('GET /version HTTP/1.1\r\nHost:\r\nConnection: close\r\n\r\n', {
      target: '/version',
    });
    assert.equal(empty.status, 200);
    const absolute = await server.raw(
      'GET http://x/version HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n',
      {target: '/version'}
    );
    assert.ok([200, 400, 404].includes(absolute.status), String(absolute.status));
  });

  for (const [method, target] of [
    ['OPTIONS', '*'],
    ['GET', '*'],
    ['CONNECT', 'x:443'],
    ['GET', 'version'],
    ['GET', '?x'],
    ['GET', '#x'],
  ])
    test(`${method} ${target} leads nowhere`, async () => {
      const answer = await server.raw(
        `${method} ${target} HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n`,
        {method, target: '*'}
      );
      assert.ok([204, 400, 404, 405].includes(answer.status), String(answer.status));
    });

  for (const path of [
    '/../etc/passwd',
    '/%2e%2e/%2e%2e/etc/passwd',
    '/..%2fetc%2fpasswd',
    '/.%00/',
    '/%00',
    '//',
    '//etc/passwd',
    '/\\..\\x',
    '/v1//jobs',
    '/v1/jobs/',
    '/v1/./jobs',
    '/v1/jobs/../limits',
    '/v1/samples/..%2f..%2fx',
    '/v1/samples/%00',
    '/%',
    '/%zz',
    '/%c0%ae%c0%ae/',
    '/v1/jobs/%2e',
    '/;/version',
    '/version;x',
    '/version/',
    '/Version',
    '/index.html%00.js',
  ])
    test(`the path ${path} is nowhere`, async () => {
      const answer = await server.raw(
        `GET ${path} HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n`,
        {target: '*'}
      );
      assert.ok([400, 404].includes(answer.status), String(answer.status));
      assert.ok(!answer.text.includes('root:'));
    });

  test('CRLF in what is echoed cannot add a field', async () => {
    for (const target of [
      '/v1/samples/x%0d%0aSet-Cookie:%20a=b',
      '/v1/jobs?state=%0d%0aX:%20y',
      '/%0d%0aX:y',
    ]) {
      const answer = await server.get(target);
      assert.equal(answer.headers['set-cookie'], undefined);
      assert.equal(answer.headers.x, undefined);
    }
  });

  test('an endless line is cut off', async () => {
    const connection = await server.connect();
    for (let i = 0; i < 16; ++i) connection.send('x'.repeat(65536));
    const answer = await connection.answer();
    server.check('GET', '*', answer);
    assert.ok([400, 414, 431].includes(answer.status), String(answer.status));
    connection.close();
    await alive();
  });

  test('an endless head is cut off', async () => {
    const connection = await server.connect();
    connection.send('GET / HTTP/1.1\r\nHost: x\r\n');
    for (let i = 0; i < 64; ++i) connection.send(`X-${i}: ${'y'.repeat(16000)}\r\n`);
    const answer = await connection.answer();
    server.check('GET', '*', answer);
    assertProblem(answer, 431, 'headers-too-large');
    connection.close();
    await alive();
  });

  test('chunks with extensions and trailers, sizes with zeros, in small pieces', async () => {
    const connection = await server.connect();
    const bytes = post(
      'Transfer-Encoding: chunked\r\nConnection: close\r\n',
      '00002;name="value"\r\nok\r\n1\r\n!\r\n0\r\nX-Trailer: y\r\n\r\n'
    );
    for (const byte of bytes) connection.send(byte);
    const answer = await connection.answer('POST');
    assert.ok(answer.text === 'asset of ok!' || answer.status === 400, answer.text);
    connection.close();
  });

  test('an empty line before a request is allowed or refused, and no more', async () => {
    const answer = await server.raw(
      '\r\nGET /version HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n',
      {target: '/version'}
    );
    assert.ok([200, 400].includes(answer.status));
  });

  test('a request that is hidden in the body of another is not answered', async () => {
    const hidden = 'GET /hidden HTTP/1.1\r\nHost: x\r\n\r\n';
    const answer = await server.post('/v1/regularize?x=1', hidden);
    assertProblem(answer, 400, 'unknown-option');
    const connection = await server.connect();
    connection.send(
      requestBytes('GET', '/version', {
        headers: {'Content-Length': hidden.length},
        body: undefined,
        close: false,
      })
    );
    connection.send(hidden);
    connection.send(requestBytes('GET', '/v1/limits'));
    const first = await connection.answer();
    assert.ok([200, 400].includes(first.status));
    const rest = (await connection.rest()).toString();
    assert.ok(!rest.includes(' 404 '), 'the hidden request has no answer');
    connection.close();
  });
});

describe('connections', () => {
  const server = useFakeServer();

  test('three requests in one packet are answered in order', async () => {
    const connection = await server.connect();
    const targets = ['/version', '/v1/limits', '/nothing'];
    connection.send(
      Buffer.concat(targets.map((target) => requestBytes('GET', target, {close: false})))
    );
    for (const target of targets) {
      const answer = await connection.answer();
      server.check('GET', target, answer);
      assert.equal(answer.status, target === '/nothing' ? 404 : 200);
    }
    connection.close();
  });

  test('posts with bodies, one after the other on one connection', async () => {
    const connection = await server.connect();
    const bodies = ['ok-a', 'ok-b', 'ok-c'];
    connection.send(
      Buffer.concat(
        bodies.map((body) => requestBytes('POST', '/v1/regularize', {body, close: false}))
      )
    );
    for (const body of bodies)
      assert.equal((await connection.answer('POST')).text, `asset of ${body}`);
    connection.close();
  });

  test('200 requests on one connection; HEAD, 204 and 304 keep it in step', async () => {
    const connection = await server.connect();
    const ask = async (method, target, headers) => {
      connection.send(requestBytes(method, target, {headers, close: false}));
      const answer = await connection.answer(method);
      server.check(method, target, answer);
      return answer;
    };
    const {etag} = (await ask('GET', '/openapi.json')).headers;
    for (let i = 0; i < 50; ++i) {
      assert.equal((await ask('HEAD', '/version')).status, 200);
      assert.equal((await ask('OPTIONS', '/version')).status, 204);
      assert.equal((await ask('GET', '/openapi.json', {'If-None-Match': etag})).status, 304);
      assert.equal((await ask('GET', '/version')).status, 200);
    }
    connection.close();
  });

  for (const [version, header, stays] of [
    ['1.1', '', true],
    ['1.1', 'Connection: close\r\n', false],
    ['1.0', '', false],
  ])
    test(`HTTP/${version} ${header.trim()}: the connection ${stays ? 'stays' : 'ends'}`, async () => {
      const connection = await server.connect();
      const bytes = `GET /version HTTP/${version}\r\nHost: x\r\n${header}\r\n`;
      connection.send(bytes);
      assert.equal((await connection.answer()).status, 200);
      if (stays) assert.equal((await connection.send(bytes).answer()).status, 200);
      else await connection.closed();
      connection.close();
    });

  test('a refused upload does not leave its body as the next request', async () => {
    const connection = await server.connect();
    const body = 'GET /v1/limits HTTP/1.1\r\nHost: x\r\n\r\n';
    connection.send(requestBytes('POST', '/v1/regularize?colour=red', {body, close: false}));
    assert.equal((await connection.answer('POST')).status, 400);
    connection.send(requestBytes('GET', '/version'));
    const rest = (await connection.rest().catch(() => Buffer.alloc(0))).toString();
    assert.ok(!rest.includes('upload_bytes'), 'the body was not taken for a request');
    connection.close();
  });
});
