// The admin port: health and metrics.
import assert from 'node:assert/strict';
import {describe, test} from 'node:test';
import {fresh} from '../lib/grids.mjs';
import {readMetrics, valueOf} from '../lib/metrics.mjs';
import {useFakeServer, withFakeServer} from '../lib/server.mjs';

// SERVICE.md section 10; the prefix is the program's.
const kMetrics = {
  http_server_request_duration_seconds: 'histogram',
  http_server_active_requests: 'gauge',
  http_server_open_connections: 'gauge',
  http_server_request_body_size_bytes: 'histogram',
  http_server_response_body_size_bytes: 'histogram',
  rivage_jobs_total: 'counter',
  rivage_job_queue_wait_seconds: 'histogram',
  rivage_job_stage_duration_seconds: 'histogram',
  rivage_queue_depth: 'gauge',
  rivage_queue_capacity: 'gauge',
  rivage_workers: 'gauge',
  rivage_workers_busy: 'gauge',
  rivage_worker_heartbeat_timestamp_seconds: 'gauge',
  rivage_admission_rejected_total: 'counter',
  rivage_memory_reserved_bytes: 'gauge',
  rivage_memory_budget_bytes: 'gauge',
  rivage_cache_requests_total: 'counter',
  rivage_solver_iterations: 'histogram',
  rivage_input_voxels: 'histogram',
  rivage_output_triangles: 'histogram',
  rivage_output_bytes: 'histogram',
  rivage_build_info: 'gauge',
  process_resident_memory_bytes: 'gauge',
};

describe('admin', () => {
  const server = useFakeServer(['--workers', '2', '--queue-limit', '7']);
  const read = async () => readMetrics(await server.metrics());

  for (const [path, word] of [
    ['/livez', 'alive'],
    ['/readyz', 'ready'],
    ['/startupz', 'started'],
  ])
    test(`${path} says ${word}`, async () => {
      const answer = await server.get(path, {admin: true});
      assert.equal(answer.status, 200);
      assert.deepEqual(answer.json, {status: word});
      assert.match(answer.headers['content-type'], /^application\/json/);
    });

  test('/metrics is Prometheus text', async () => {
    const answer = await server.get('/metrics', {admin: true});
    assert.match(answer.headers['content-type'], /^text\/plain; version=0\.0\.4/);
    for (const [name, {type, help}] of readMetrics(answer.text)) {
      assert.ok(type && help, `${name} has a type and a help`);
      assert.match(name, /^(rivage|http_server|process)_/);
      if (type === 'counter') assert.match(name, /_total$/);
    }
  });

  for (const [name, type] of Object.entries(kMetrics))
    test(`/metrics has the ${type} ${name}`, async () => {
      await server.post('/v1/regularize', fresh());
      assert.equal((await read()).get(name)?.type, type);
    });

  test('histograms: buckets grow, the last is the count', async () => {
    const families = await read();
    for (const [name, {type, samples}] of families) {
      if (type !== 'histogram') continue;
      const series = new Map();
      for (const {
        labels: {le, ...labels},
        value,
      } of samples.filter((one) => one.name === `${name}_bucket`)) {
        const key = JSON.stringify(labels);
        series.set(key, [...(series.get(key) ?? []), [le, value]]);
      }
      for (const [key, buckets] of series) {
        const values = buckets.map(([, value]) => value);
        assert.deepEqual(
          values,
          [...values].sort((a, b) => a - b),
          `${name}${key}`
        );
        assert.equal(buckets.at(-1)[0], '+Inf');
        assert.equal(values.at(-1), valueOf(families, `${name}_count`, JSON.parse(key)));
      }
    }
  });

  test('jobs are counted by outcome', async () => {
    const before = await read();
    await server.post('/v1/regularize', fresh());
    await server.post('/v1/regularize', 'empty');
    await server.post('/v1/regularize?deadline_ms=50', fresh('slow'));
    const path = await server.submit(fresh('slow'));
    await server.ask('DELETE', path);
    await server.follow(path);
    const after = await read();
    for (const outcome of ['succeeded', 'failed', 'canceled', 'expired'])
      assert.equal(
        valueOf(after, 'rivage_jobs_total', {outcome}) -
          valueOf(before, 'rivage_jobs_total', {outcome}),
        1,
        outcome
      );
  });

  test('requests are counted by route and status, never by path', async () => {
    const labels = {
      http_request_method: 'GET',
      http_route: '/v1/jobs/{id}',
      http_response_status_code: '404',
    };
    const count = async () =>
      valueOf(await read(), 'http_server_request_duration_seconds_count', labels);
    const before = await count();
    for (let i = 0; i < 3; ++i) await server.get('/v1/jobs/01234567-89ab-7def-8123-456789abcdef');
    assert.equal(await count(), before + 3);
    await server.get('/v1/very-secret-path');
    assert.ok(!(await server.metrics()).includes('very-secret'));
    assert.ok(!(await server.metrics()).includes('01234567-89ab'));
  });

  test('gauges follow what runs and waits', async () => {
    await withFakeServer(['--workers', '1', '--queue-limit', '7'], async (small) => {
      const gauge = async (name) => valueOf(readMetrics(await small.metrics()), name);
      assert.equal(await gauge('rivage_workers'), 1);
      assert.equal(await gauge('rivage_queue_capacity'), 7);
      await small.inState(await small.submit(fresh('slow')), 'running');
      await small.submit(fresh('slow'));
      assert.equal(await gauge('rivage_workers_busy'), 1);
      assert.equal(await gauge('rivage_queue_depth'), 1);
    });
  });

  test('refusals are counted by reason', async () => {
    await withFakeServer(['--workers', '1', '--queue-limit', '0'], async (full) => {
      await full.inState(await full.submit(fresh('slow')), 'running');
      await full.post('/v1/jobs', fresh());
      assert.equal(
        valueOf(readMetrics(await full.metrics()), 'rivage_admission_rejected_total', {
          reason: 'queue_full',
        }),
        1
      );
    });
  });

  test('health stays good while all workers are busy and the queue is full', async () => {
    await withFakeServer(['--workers', '1', '--queue-limit', '0'], async (full) => {
      await full.inState(await full.submit(fresh('slow')), 'running');
      for (const path of ['/livez', '/readyz'])
        assert.equal((await full.get(path, {admin: true})).status, 200);
    });
  });

  test('health and metrics are not in the log', async () => {
    for (const path of ['/livez', '/readyz', '/metrics']) await server.get(path, {admin: true});
    await server.get('/version');
    await server.logged((line) => line.route === '/version', 'another request');
    assert.ok(!server.log.some((line) => /livez|readyz|metrics/.test(line.route ?? '')));
  });
});
