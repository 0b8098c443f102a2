// What is known is not computed again, and what runs is not run twice.
import assert from 'node:assert/strict';
import {describe, test} from 'node:test';
import {cube, cubeQuery, form, fresh, gzip, pair, pairQuery} from '../lib/grids.mjs';
import {readMetrics, valueOf} from '../lib/metrics.mjs';
import {eventually, useFakeServer, useServer, withFakeServer, withServer} from '../lib/server.mjs';

const status = (answer) => answer.headers['cache-status'];

// How many conversions have run so far.
const runs = async (server) =>
  valueOf(readMetrics(await server.metrics()), 'rivage_job_stage_duration_seconds_count', {
    stage: 'parse',
  });

describe('cache', () => {
  const server = useFakeServer(['--workers', '2', '--queue-limit', '256']);

  for (const [first, second] of [
    ['/v1/regularize', '/v1/regularize'],
    ['/v1/jobs', '/v1/regularize'],
    ['/v1/regularize', '/v1/jobs'],
    ['/v1/jobs', '/v1/jobs'],
  ])
    test(`${second} knows what ${first} has computed`, async () => {
      const body = fresh();
      const miss = await server.post(first, body);
      assert.equal(status(miss), 'rivage; fwd=miss');
      if (first === '/v1/jobs') await server.follow(miss.headers.location);
      const before = await runs(server);
      const hit = await server.post(second, body);
      assert.equal(status(hit), 'rivage; hit');
      assert.equal(await runs(server), before);
      if (second === '/v1/jobs') {
        assert.equal(hit.status, 202);
        assert.equal((await server.follow(hit.headers.location)).state, 'succeeded');
        assert.equal((await server.get(`${hit.headers.location}/result`)).text, `asset of ${body}`);
      } else {
        assert.equal(hit.text, `asset of ${body}`);
        if (miss.headers.etag) assert.equal(hit.headers.etag, miss.headers.etag);
      }
    });

  for (const [what, query, headers, packed] of [
    ['an option that has its default value', '?preset=studio', {}, (body) => body],
    ['a deadline', '?deadline_ms=9000', {}, (body) => body],
    ['another name of the file', '', null, (body) => form([['grid', body, {filename: 'x.vox'}]])],
    ['an encoding', '', {'Content-Encoding': 'gzip'}, gzip],
  ])
    test(`${what} changes nothing about the content`, async () => {
      const body = fresh();
      await server.post('/v1/regularize', body);
      const other = packed(body);
      const hit =
        headers === null
          ? await server.post('/v1/regularize', other.body, {headers: other.headers})
          : await server.post(`/v1/regularize${query}`, other, {headers});
      assert.equal(status(hit), 'rivage; hit');
      assert.equal(hit.text, `asset of ${body}`);
    });

  for (const query of ['?alpha=0.5', '?output=obj', '?preset=paper', '?compression=none'])
    test(`${query} is another request`, async () => {
      const body = fresh();
      await server.post('/v1/regularize', body);
      assert.equal(status(await server.post(`/v1/regularize${query}`, body)), 'rivage; fwd=miss');
    });

  for (const control of ['no-cache', 'max-age=0, no-cache', 'No-Cache'])
    test(`Cache-Control: ${control} runs again`, async () => {
      const body = fresh();
      await server.post('/v1/regularize', body);
      const before = await runs(server);
      const again = await server.post('/v1/regularize', body, {
        headers: {'Cache-Control': control},
      });
      assert.equal(status(again), 'rivage; fwd=request');
      assert.equal(await runs(server), before + 1);
    });

  test('a failure is not kept', async () => {
    for (const grid of ['throw', 'memory']) {
      const before = await runs(server);
      for (let i = 0; i < 2; ++i) await server.post('/v1/regularize', grid);
      assert.equal(await runs(server), before + 2, grid);
    }
  });

  test('100 identical posts at once run one job', async () => {
    await withFakeServer(['--workers', '2', '--queue-limit', '256'], async (fresher) => {
      const body = fresh('hold:300');
      const answers = await Promise.all(
        Array.from({length: 100}, () => fresher.post('/v1/regularize', body))
      );
      for (const answer of answers) {
        assert.equal(answer.status, 200, answer.text);
        assert.equal(answer.text, `asset of ${body}`);
      }
      const seen = answers.map(status);
      assert.equal(seen.filter((text) => text === 'rivage; fwd=miss').length, 1);
      assert.ok(seen.filter((text) => text === 'rivage; fwd=miss; collapsed').length > 0);
      assert.equal(await runs(fresher), 1);
      const metrics = readMetrics(await fresher.metrics());
      const counted = (result) => valueOf(metrics, 'rivage_cache_requests_total', {result});
      assert.equal(counted('miss'), 1);
      assert.equal(counted('hit') + counted('coalesced'), 99);
    });
  });

  test('one of two clients that leaves does not take the conversion with it', async () => {
    const body = fresh('hold:1000');
    const leaver = await server.connect();
    leaver.send(
      `POST /v1/regularize HTTP/1.1\r\nHost: x\r\nContent-Length: ${body.length}\r\n\r\n${body}`
    );
    await eventually(async () => (await server.jobsIn('running')).length === 1, 'it runs');
    const stays = server.post('/v1/regularize', body);
    await eventually(async () => (await server.jobsIn('running')).length === 2, 'both run');
    leaver.close();
    const answer = await stays;
    assert.equal(answer.status, 200);
    assert.equal(status(answer), 'rivage; fwd=miss; collapsed');
    assert.equal(answer.text, `asset of ${body}`);
  });

  test('a job of two that is deleted does not take the other with it', async () => {
    const body = fresh('hold:1000');
    const [first, second] = [await server.submit(body), await server.submit(body)];
    assert.notEqual(first, second);
    await server.ask('DELETE', first);
    assert.equal((await server.follow(first)).state, 'canceled');
    assert.equal((await server.follow(second)).state, 'succeeded');
  });
});

describe('determinism', () => {
  const server = useServer();

  for (const [name, body, query] of [
    ['a cube', cube, cubeQuery],
    ['two labels', pair, pairQuery],
  ])
    test(`two servers give the same tag for ${name}`, async () => {
      const first = await server.post(`/v1/regularize${query}`, body);
      await withServer(['--workers', '1', '--threads-per-job', '2'], {}, async (other) => {
        const second = await other.post(`/v1/regularize${query}`, body);
        assert.equal(first.status, 200, first.text);
        assert.equal(first.headers.etag, second.headers.etag);
        assert.deepEqual(first.body, second.body);
      });
    });

  test('a sample gives the same bytes in one request, as a job, and without the cache', async () => {
    const {body} = await server.get('/v1/samples/sphere');
    const one = await server.post('/v1/regularize', body);
    const path = await server.submit(body);
    const job = await server.follow(path);
    const two = await server.get(`${path}/result`);
    const three = await server.post('/v1/regularize', body, {
      headers: {'Cache-Control': 'no-cache'},
    });
    assert.deepEqual([two.headers.etag, three.headers.etag], [one.headers.etag, one.headers.etag]);
    assert.deepEqual(two.body, one.body);
    assert.equal(job.report.output.bytes, one.body.length);
    assert.equal(one.body.subarray(0, 4).toString(), 'glTF');
  });
});
