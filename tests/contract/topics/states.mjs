// Every state of a job with every route of a job.
import assert from 'node:assert/strict';
import {describe, test} from 'node:test';
import {EventStream} from '../lib/events.mjs';
import {fresh} from '../lib/grids.mjs';
import {eventually, withFakeServer} from '../lib/server.mjs';

const kProgressive = {query: '?progressive=true'};
const kUnknown = '/v1/jobs/01234567-89ab-7def-8123-456789abcdef';

async function ended(server, grid, state, options = kProgressive) {
  const path = await server.submit(grid, options);
  assert.equal((await server.follow(path)).state, state);
  return path;
}

async function running(server, options) {
  const path = await server.submit(fresh('slow'), options);
  await server.inState(path, 'running');
  return path;
}

async function deleted(server, path) {
  assert.equal((await server.ask('DELETE', path)).status, 204);
  return path;
}

// How a job gets into each state, and the statuses of GET job, GET result, GET events, GET preview
// and DELETE.
const kStates = {
  queued: [
    async (server) => {
      await running(server);
      return server.submit(fresh('slow'));
    },
    200,
    202,
    200,
    404,
    204,
  ],
  'queued, progressive': [
    async (server) => {
      await running(server);
      return server.submit(fresh('slow'), kProgressive);
    },
    200,
    202,
    200,
    202,
    204,
  ],
  running: [running, 200, 202, 200, 404, 204],
  succeeded: [(server) => ended(server, fresh(), 'succeeded'), 200, 200, 200, 410, 204],
  failed: [(server) => ended(server, 'empty', 'failed'), 200, 422, 200, 410, 204],
  'failed inside': [(server) => ended(server, 'throw', 'failed'), 200, 500, 200, 410, 204],
  'canceled while it ran': [
    async (server) => deleted(server, await running(server, kProgressive)),
    200,
    409,
    200,
    410,
    204,
  ],
  'canceled while it waited': [
    async (server) => {
      await running(server);
      return deleted(server, await server.submit(fresh('slow'), kProgressive));
    },
    200,
    409,
    200,
    410,
    204,
  ],
  expired: [
    async (server) => {
      const path = await ended(server, fresh(), 'succeeded');
      await ended(server, fresh(), 'succeeded');
      return path;
    },
    410,
    410,
    410,
    410,
    410,
    ['--kept-jobs', '1'],
  ],
  'succeeded, its result dropped': [
    async (server) => {
      const path = await ended(server, 'big:3000', 'succeeded');
      await ended(server, 'big:3001', 'succeeded');
      return path;
    },
    200,
    410,
    200,
    410,
    204,
    ['--result-budget', '4096'],
  ],
  forgotten: [
    async (server) => deleted(server, await ended(server, fresh(), 'succeeded')),
    404,
    404,
    404,
    404,
    404,
  ],
  unknown: [async () => kUnknown, 404, 404, 404, 404, 404],
  malformed: [async () => '/v1/jobs/x', 404, 404, 404, 404, 404],
  'with a number as its id': [async () => '/v1/jobs/1', 404, 404, 404, 404, 404],
  'with dots as its id': [async () => '/v1/jobs/%2e%2e', 404, 404, 404, 404, 404],
};

// Reads the head of an event stream only: the stream of a job that runs does not end.
async function eventStatus(server, path) {
  const stream = await EventStream.open(server, path);
  stream.connection.close();
  return stream.head.status;
}

describe('states', () => {
  for (const [state, [make, job, result, events, preview, removal, args = []]] of Object.entries(
    kStates
  )) {
    test(`a job that is ${state}: ${job} ${result} ${events} ${preview} ${removal}`, async (t) => {
      await withFakeServer(['--workers', '1', '--queue-limit', '8', ...args], async (server) => {
        const path = await make(server);
        for (const method of ['GET', 'HEAD'])
          for (const [suffix, status] of [
            ['', job],
            ['/result', result],
            ['/preview', preview],
          ])
            await t.test(`${method} ${suffix}`, async () =>
              assert.equal((await server.ask(method, path + suffix)).status, status)
            );
        await t.test('HEAD /events', async () =>
          assert.equal((await server.ask('HEAD', `${path}/events`)).status, events)
        );
        await t.test('GET /events', async () =>
          assert.equal(
            events === 200
              ? await eventStatus(server, path)
              : (await server.get(`${path}/events`)).status,
            events
          )
        );
        await t.test('DELETE', async () =>
          assert.equal((await server.ask('DELETE', path)).status, removal)
        );
      });
    });
  }

  test('a deleted job is gone for good, and one that was canceled is forgotten by a second DELETE', async () => {
    await withFakeServer(['--workers', '1'], async (server) => {
      const path = await deleted(server, await running(server));
      assert.equal((await server.follow(path)).state, 'canceled');
      await deleted(server, path);
      assert.equal((await server.get(path)).status, 404);
      assert.equal((await server.ask('DELETE', path)).status, 404);
    });
  });

  test('a conversion whose job is deleted by another request says so', async () => {
    await withFakeServer(['--workers', '1'], async (server) => {
      const answer = server.post('/v1/regularize', fresh('slow'));
      const path = await eventually(async () => (await server.jobsIn('running'))[0], 'it runs');
      await deleted(server, path);
      const {status, problem} = await answer;
      assert.deepEqual([status, problem], [409, 'canceled']);
    });
  });

  test('places in the queue move up when the one before is canceled', async () => {
    await withFakeServer(['--workers', '1'], async (server) => {
      await running(server);
      const [first, second] = [
        await server.submit(fresh('slow')),
        await server.submit(fresh('slow')),
      ];
      assert.equal((await server.get(first)).json.queue_position, 0);
      assert.equal((await server.get(second)).json.queue_position, 1);
      await deleted(server, first);
      assert.equal((await server.get(second)).json.queue_position, 0);
    });
  });

  const failures = {
    empty: [422, 'empty-grid'],
    bad: [400, 'malformed-input'],
    odd: [415, 'unsupported-format'],
    big: [413, 'too-large'],
    throw: [500, 'internal'],
    memory: [422, 'memory-budget'],
  };
  for (const [grid, [status, slug]] of Object.entries(failures))
    test(`a job that fails with ${slug}: ${status} at once, as a result, and in the job`, async () => {
      await withFakeServer([], async (server) => {
        const direct = await server.post('/v1/regularize', grid);
        assert.equal(direct.status, status);
        assert.equal(direct.problem, slug);
        const path = await server.submit(grid);
        const job = await server.follow(path);
        assert.equal(job.error.type, `/problems/${slug}`);
        const result = await server.get(`${path}/result`);
        assert.equal(result.status, status);
        assert.deepEqual(result.json, job.error);
        assert.equal(result.json.instance, path);
      });
    });

  test('the list: newest first, by state, in pages', async () => {
    await withFakeServer([], async (server) => {
      const paths = [];
      for (const grid of [fresh(), 'empty', fresh()]) {
        paths.push(await server.submit(grid));
        await server.follow(paths.at(-1));
      }
      const list = async (query = '') => (await server.get(`/v1/jobs${query}`)).json;
      assert.deepEqual(
        (await list()).jobs.map((job) => job.links.self),
        [...paths].reverse()
      );
      assert.equal((await list('?state=failed')).jobs.length, 1);
      assert.equal((await list('?state=queued')).jobs.length, 0);
      const page = await list('?limit=2');
      assert.equal(page.jobs.length, 2);
      const rest = (await server.get(page.next)).json;
      assert.deepEqual(
        rest.jobs.map((job) => job.links.self),
        [paths[0]]
      );
      assert.equal(rest.next, null);
    });
  });

  for (const query of [
    '?limit=0',
    '?limit=501',
    '?limit=x',
    '?limit=-1',
    '?limit=',
    '?state=done',
    '?state=',
    '?colour=1',
    '?limit=1&limit=2',
    '?limit=1%00',
  ])
    test(`the list refuses ${query}`, async () => {
      await withFakeServer([], async (server) => {
        const answer = await server.get(`/v1/jobs${query}`);
        assert.equal(answer.status, 400);
        assert.equal(answer.problem, 'malformed-request');
      });
    });
});
