// Content-Encoding and Content-Digest of uploads.
import assert from 'node:assert/strict';
import {createHash} from 'node:crypto';
import {describe, test} from 'node:test';
import {deflateRawSync} from 'node:zlib';
import {deflate, form, fresh, gzip, gzipBomb, zstd, zstdBomb} from '../lib/grids.mjs';
import {readMetrics, valueOf} from '../lib/metrics.mjs';
import {sha256} from '../lib/schema.mjs';
import {assertProblem, useFakeServer} from '../lib/server.mjs';

const kPack = {gzip, deflate, zstd, identity: (text) => Buffer.from(text)};
const kLimit = 1 << 20;

describe('encodings', () => {
  const server = useFakeServer(['--max-upload', String(kLimit)]);
  const post = (body, encoding, more = {}) =>
    server.post('/v1/regularize', body, {headers: {'Content-Encoding': encoding, ...more}});

  for (const [name, pack] of Object.entries(kPack)) {
    test(`${name}: a body, in chunks, and a form`, async () => {
      const grid = fresh();
      assert.equal((await post(pack(grid), name)).text, `asset of ${grid}`);
      const chunked = await server.post('/v1/regularize', pack(grid), {
        headers: {'Content-Encoding': name},
        chunked: true,
      });
      assert.equal(chunked.text, `asset of ${grid}`);
      const {body, headers} = form([['grid', grid]]);
      assert.equal((await post(pack(body), name, headers)).text, `asset of ${grid}`);
    });
    if (name === 'identity') continue;

    test(`${name}: what is no ${name} is malformed`, async () => {
      for (const bytes of ['this is not packed', '\0'])
        assertProblem(await post(bytes, name), 400, 'malformed-request');
    });

    test(`${name}: every part of a packed body is refused`, async () => {
      const packed = pack(fresh());
      for (let length = 1; length < packed.length; ++length)
        assertProblem(await post(packed.subarray(0, length), name), 400, 'malformed-request');
    });

    test(`${name}: bytes after the end are refused`, async () =>
      assertProblem(
        await post(Buffer.concat([pack(fresh()), Buffer.from('more')]), name),
        400,
        'malformed-request'
      ));

    test(`${name}: as many bytes as allowed inside, and one more`, async () => {
      const exact = await post(pack(fresh().padEnd(kLimit, 'x')), name);
      if (pack(fresh().padEnd(kLimit, 'x')).length <= kLimit)
        assert.equal(exact.status, 200, exact.text);
      const packed = name === 'zstd' ? zstdBomb(kLimit + 1) : pack(fresh().padEnd(kLimit + 1, 'x'));
      assertProblem(await post(packed, name), 413, 'too-large', {
        limit: kLimit,
        setting: '--max-upload',
      });
    });
  }

  test('names are not case-sensitive', async () => {
    const grid = fresh();
    assert.equal((await post(gzip(grid), 'GZIP')).text, `asset of ${grid}`);
  });

  for (const encoding of [
    'br',
    'compress',
    'rot13',
    'gzip, gzip',
    'gzip, zstd',
    'identity, gzip, deflate',
    '"gzip"',
    'gzip;q=1',
    ',',
  ])
    test(`the encoding ${encoding} is not supported`, async () =>
      assertProblem(await post(gzip(gzip(fresh())), encoding), 415, 'unsupported-encoding'));

  test('deflate without a zlib head is refused or understood', async () => {
    const grid = fresh();
    const answer = await post(deflateRawSync(Buffer.from(grid)), 'deflate');
    assert.ok(answer.status === 400 || answer.text === `asset of ${grid}`, answer.text);
  });

  for (const [name, bomb] of [
    ['gzip', () => gzipBomb(256 << 20)],
    ['zstd', () => zstdBomb(2048 * (1 << 20))],
  ])
    test(`a bomb of ${name} goes off nowhere`, async () => {
      const memory = async () =>
        valueOf(readMetrics(await server.metrics()), 'process_resident_memory_bytes');
      const before = await memory();
      const packed = bomb();
      assert.ok(packed.length < kLimit, 'it is small');
      assertProblem(await post(packed, name), 413, 'too-large', {setting: '--max-upload'});
      assert.ok((await memory()) - before < 64 << 20, 'memory');
    });

  test('two zstd frames one after the other are one body', async () => {
    const [first, second] = [fresh(), 'second'];
    const answer = await post(Buffer.concat([zstd(first), zstd(second)]), 'zstd');
    assert.ok(
      answer.text === `asset of ${first}${second}` || answer.problem === 'malformed-request',
      answer.text
    );
  });

  test('a zstd window of 2 GiB is refused before it is allocated', async () => {
    const frame = Buffer.concat([
      Buffer.from([0x28, 0xb5, 0x2f, 0xfd, 0x00, 0xa8]),
      zstd('ok').subarray(6),
    ]);
    const answer = await post(frame, 'zstd');
    assert.ok([400, 413].includes(answer.status), String(answer.status));
  });
});

describe('digests', () => {
  const server = useFakeServer();
  const post = (body, digest, more = {}) =>
    server.post('/v1/regularize', body, {headers: {'Content-Digest': digest, ...more}});
  const other = sha256('something else');

  test('the right digest: of a body, of a packed body as it was sent, of a form', async () => {
    const grid = fresh();
    const packed = gzip(grid);
    const {body, headers} = form([['grid', grid]]);
    assert.equal((await post(grid, sha256(grid))).status, 200);
    assert.equal((await post(packed, sha256(packed), {'Content-Encoding': 'gzip'})).status, 200);
    assert.equal((await post(body, sha256(body), headers)).status, 200);
    assert.equal(
      (
        await server.post('/v1/regularize', grid, {
          headers: {'Content-Digest': sha256(grid)},
          chunked: true,
        })
      ).status,
      200
    );
  });

  for (const route of ['/v1/regularize', '/v1/jobs', '/v1/inspect'])
    test(`${route} refuses another digest`, async () => {
      const answer = await server.post(route, fresh(), {headers: {'Content-Digest': other}});
      assertProblem(answer, 400, 'digest-mismatch');
    });

  test('one flipped bit is found', async () => {
    const grid = Buffer.from(fresh());
    const digest = sha256(grid);
    grid[3] ^= 1;
    assertProblem(await post(grid, digest), 400, 'digest-mismatch');
  });

  test('a digest of what comes out of a packed body is another one', async () => {
    const grid = fresh();
    assertProblem(
      await post(gzip(grid), sha256(grid), {'Content-Encoding': 'gzip'}),
      400,
      'digest-mismatch'
    );
  });

  test('other algorithms are not looked at; beside sha-256 it still counts', async () => {
    const md5 = `md5=:${createHash('md5').update('x').digest('base64')}:`;
    const grid = fresh();
    assert.equal((await post(grid, md5)).status, 200);
    assert.equal((await post(grid, `${md5}, ${sha256(grid)}`)).status, 200);
    assertProblem(await post(grid, `${md5}, ${other}`), 400, 'digest-mismatch');
  });

  for (const digest of [
    'sha-256',
    'sha-256=',
    'sha-256=abc',
    'sha-256=:abc:',
    'sha-256=:!!!!:',
    `${other.slice(0, -1)}`,
    '=:x:',
    ';;;',
  ])
    test(`the digest ${digest.slice(0, 30)} is malformed`, async () =>
      assertProblem(await post(fresh(), digest), 400, 'malformed-request'));
});
