// Results: tags, conditions, ranges, digests, HEAD.
import assert from 'node:assert/strict';
import {before, describe, test} from 'node:test';
import {cube, cubeQuery, fresh} from '../lib/grids.mjs';
import {sha256} from '../lib/schema.mjs';
import {assertProblem, useFakeServer, useServer} from '../lib/server.mjs';

// The parts of a multipart/byteranges body: lists of [first, last, bytes].
function readParts(answer) {
  const boundary = /^multipart\/byteranges; ?boundary="?([^"]+)"?$/.exec(
    answer.headers['content-type']
  );
  assert.ok(boundary, answer.headers['content-type']);
  const text = answer.body.toString('latin1');
  assert.ok(text.trimEnd().endsWith(`--${boundary[1]}--`), 'the end of the parts');
  return text
    .split(`--${boundary[1]}`)
    .slice(1, -1)
    .map((part) => {
      const [head, ...rest] = part.split('\r\n\r\n');
      const match = /content-range: bytes (\d+)-(\d+)\/(\d+)/i.exec(head);
      assert.ok(match, head);
      return [Number(match[1]), Number(match[2]), rest.join('\r\n\r\n').slice(0, -2)];
    });
}

describe('results', () => {
  const server = useFakeServer();
  let path;
  let whole;
  let etag;
  before(async () => {
    path = await server.submit('big:1000');
    await server.follow(path);
    path += '/result';
    whole = await server.get(path);
    etag = whole.headers.etag;
  });
  const ask = (headers, method = 'GET') => server.ask(method, path, {headers});

  test('the whole: its tag, its digests, its name, for how long it may be kept', () => {
    assert.equal(whole.status, 200);
    assert.equal(whole.body.length, 1000);
    assert.match(etag, /^"[0-9a-f]{64}"$/);
    assert.equal(whole.headers['repr-digest'], sha256(whole.body));
    assert.equal(whole.headers['content-digest'], sha256(whole.body));
    assert.equal(whole.headers['accept-ranges'], 'bytes');
    assert.match(whole.headers['cache-control'], /\bprivate\b.*\bimmutable\b/);
    assert.match(whole.headers['content-disposition'], /\.glb"$/);
  });

  test('HEAD has the length, the tag and the digest of the whole', async () => {
    const head = await ask({}, 'HEAD');
    assert.equal(head.status, 200);
    assert.equal(head.headers['content-length'], '1000');
    for (const name of ['etag', 'repr-digest', 'content-type'])
      assert.equal(head.headers[name], whole.headers[name]);
  });

  const matching = {
    'the tag': (tag) => tag,
    'a list': (tag) => `"x", ${tag}`,
    'a weak tag': (tag) => `W/${tag}`,
    anything: () => '*',
    'a list without spaces': (tag) => `"a","b",${tag}`,
  };
  for (const [what, make] of Object.entries(matching))
    test(`If-None-Match with ${what}: 304`, async () => {
      for (const method of ['GET', 'HEAD']) {
        const answer = await ask({'If-None-Match': make(etag)}, method);
        assert.equal(answer.status, 304);
        assert.equal(answer.headers.etag, etag);
      }
      assert.equal((await ask({'If-None-Match': make(etag), Range: 'bytes=0-1'})).status, 304);
    });

  for (const tag of ['"x"', 'x', '""', ',', '"*"'])
    test(`If-None-Match: ${tag} does not match`, async () =>
      assert.equal((await ask({'If-None-Match': tag})).status, 200));

  const ranges = {
    'bytes=0-0': [0, 0],
    'bytes=10-19': [10, 19],
    'bytes=990-': [990, 999],
    'bytes=-5': [995, 999],
    'bytes=-5000': [0, 999],
    'bytes=500-5000': [500, 999],
    'bytes=0-999': [0, 999],
  };
  for (const [range, [first, last]] of Object.entries(ranges))
    test(`Range: ${range} gives ${first} to ${last}`, async () => {
      const answer = await ask({Range: range});
      assert.equal(answer.status, 206);
      assert.equal(answer.headers['content-range'], `bytes ${first}-${last}/1000`);
      assert.deepEqual(answer.body, whole.body.subarray(first, last + 1));
      assert.equal(answer.headers['repr-digest'], whole.headers['repr-digest']);
      assert.equal(answer.headers.etag, etag);
      if (answer.headers['content-digest'])
        assert.equal(answer.headers['content-digest'], sha256(answer.body));
    });

  for (const range of ['bytes=1000-', 'bytes=5000-6000', 'bytes=-0'])
    test(`Range: ${range} lies outside: 416`, async () => {
      const answer = await ask({Range: range});
      assertProblem(answer, 416, 'range-not-satisfiable');
      if (answer.headers['content-range'])
        assert.equal(answer.headers['content-range'], 'bytes */1000');
    });

  for (const range of [
    'lines=0-1',
    'bytes',
    'bytes=',
    'bytes=a-b',
    'bytes=5-1',
    'bytes=--5',
    'bytes=0-1,x',
    'bytes=99999999999999999999999-',
  ])
    test(`Range: ${range} makes no sense: refused, or as if it were not there`, async () => {
      const answer = await ask({Range: range});
      assert.ok([200, 400, 416].includes(answer.status), String(answer.status));
      if (answer.status === 200) assert.deepEqual(answer.body, whole.body);
    });

  const many = (count) =>
    `bytes=${Array.from({length: count}, (_, i) => `${i * 3}-${i * 3}`).join(',')}`;
  for (const count of [2, 16])
    test(`${count} ranges are ${count} parts`, async () => {
      const answer = await ask({Range: many(count)});
      assert.equal(answer.status, 206);
      const parts = readParts(answer);
      assert.equal(parts.length, count);
      for (const [first, last, bytes] of parts)
        assert.equal(bytes, whole.body.subarray(first, last + 1).toString('latin1'));
    });

  for (const count of [17, 300])
    test(`${count} ranges are too many: 416`, async () =>
      assertProblem(await ask({Range: many(count)}), 416, 'range-not-satisfiable'));

  for (const count of [1000, 2000])
    test(`${count} ranges are refused: too many, or too long a head`, async () => {
      const answer = await ask({Range: many(count)});
      assert.ok([416, 431].includes(answer.status), String(answer.status));
    });

  test('ranges that overlap a thousand times do not multiply the result', async () => {
    const answer = await ask({Range: `bytes=${Array.from({length: 16}, () => '0-999').join(',')}`});
    assert.ok([200, 206, 416].includes(answer.status));
    assert.ok(answer.body.length < 20000);
  });

  for (const [tag, status] of [
    ['the tag', 206],
    ['"x"', 200],
    ['W/', 200],
    ['Mon, 01 Jan 2024 00:00:00 GMT', 200],
  ])
    test(`If-Range with ${tag}: ${status}`, async () => {
      const value = tag === 'the tag' ? etag : tag === 'W/' ? `W/${etag}` : tag;
      const answer = await ask({Range: 'bytes=0-9', 'If-Range': value});
      assert.equal(answer.status, status);
      assert.equal(answer.body.length, status === 206 ? 10 : 1000);
    });

  test('a range of a conversion in one request is not looked at', async () => {
    const answer = await server.post('/v1/regularize', fresh(), {headers: {Range: 'bytes=0-1'}});
    assert.equal(answer.status, 200);
  });

  test('a result of 8 MiB comes whole, and its end by a range', async () => {
    const big = await server.submit(`big:${8 << 20}`);
    await server.follow(big);
    const answer = await server.get(`${big}/result`);
    assert.equal(answer.body.length, 8 << 20);
    const end = await server.get(`${big}/result`, {headers: {Range: 'bytes=-100'}});
    assert.deepEqual(end.body, answer.body.subarray(-100));
  });

  test('a result of one byte and one of none', async () => {
    for (const size of [1, 0]) {
      const small = await server.submit(`big:${size}`);
      await server.follow(small);
      const answer = await server.get(`${small}/result`);
      assert.equal(answer.status, 200);
      assert.equal(answer.body.length, size);
      assert.equal(
        (await server.get(`${small}/result`, {headers: {Range: 'bytes=1-'}})).status,
        416
      );
    }
  });
});

describe('results of the real engine', () => {
  const server = useServer();

  for (const [output, type, extension] of [
    ['glb', 'model/gltf-binary', 'glb'],
    ['obj', 'model/obj', 'obj'],
    ['vox', 'application/x-magicavoxel', 'vox'],
    ['nrrd', 'application/x-nrrd', 'nrrd'],
  ])
    test(`output=${output} is ${type}`, async () => {
      const query = output === 'glb' ? cubeQuery : `?format=raw&dims=2x2x2&output=${output}`;
      const answer = await server.post(`/v1/regularize${query}`, cube);
      assert.equal(answer.status, 200, answer.text);
      assert.equal(answer.headers['content-type'].split(';')[0], type);
      assert.ok(answer.headers['content-disposition'].endsWith(`.${extension}"`));
    });

  test('voxels again: finer, coarser, and what the report says', async () => {
    for (const [scale, dims] of [['3', [6, 6, 6]], ['3/2', [3, 3, 3]], ['1/2', [1, 1, 1]]]) {
      const query = `?format=raw&dims=2x2x2&output=nrrd&scale=${scale}`;
      const job = await server.post(`/v1/jobs${query}`, cube);
      assert.equal(job.status, 202, job.text);
      await server.follow(job.headers.location);
      const {report, options} = (await server.get(job.headers.location)).json;
      assert.deepEqual(report.voxels.dims, dims);
      assert.equal(report.voxels.scale, scale);
      assert.equal(options.scale, scale === '3' ? 3 : scale);
      assert.equal('topology' in report.voxels, scale === '1/2');
    }
  });

  test('a scale that is none, too large a result, and a scale of a mesh are refused', async () => {
    for (const [query, status, field] of [
      ['output=vox&scale=0', 400, '/options/scale'],
      ['output=vox&scale=1/0', 400, '/options/scale'],
      ['output=vox&scale=7/1000000007', 400, '/options/scale'],
      ['scale=2', 400, '/options/scale'],
      ['output=vox&shading=flat', 400, '/options/shading'],
      ['output=vox&spacing=1x1x2', 400, '/options/spacing'],
    ]) {
      const answer = await server.post(`/v1/regularize?format=raw&dims=2x2x2&${query}`, cube);
      assert.equal(answer.status, status, `${query}: ${answer.text}`);
      assert.equal(answer.json.field, field);
    }
    const long = await server.post(
      '/v1/regularize?format=raw&dims=1000x1x1&output=nrrd&scale=16', Buffer.alloc(1000, 1));
    assert.equal(long.status, 413, long.text);
    assert.equal(long.json.field, '/options/scale');
    assert.equal(long.json.setting, '--max-extent');
  });

  test('inspect says what is in a grid', async () => {
    const jobs = async () => (await server.get('/v1/jobs')).json.jobs.length;
    const before = await jobs();
    const answer = await server.post('/v1/inspect?format=raw&dims=2x2x2', cube);
    assert.equal(answer.status, 200);
    assert.deepEqual(answer.json.input.dims, [2, 2, 2]);
    assert.equal(answer.json.input.voxels, 8);
    assert.equal(answer.json.surface.surfels, 24);
    assert.ok(before >= 2);
    assert.equal(await jobs(), before, 'an inspection is no job');
  });

  test('every sample can be inspected', async () => {
    for (const {href} of (await server.get('/v1/samples')).json.samples) {
      const {body} = await server.get(href);
      assert.equal((await server.post('/v1/inspect', body)).status, 200, href);
    }
  });
});
