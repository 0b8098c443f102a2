// Server-sent events of jobs, and previews of running ones.
import assert from 'node:assert/strict';
import {describe, test} from 'node:test';
import {EventStream} from '../lib/events.mjs';
import {fresh} from '../lib/grids.mjs';
import {validate} from '../lib/schema.mjs';
import {
  assertProblem,
  eventually,
  useFakeServer,
  useServer,
  withFakeServer,
} from '../lib/server.mjs';

const schemaOf = {progress: 'EventProgress', preview: 'EventPreview', done: 'Job'};

function checkEvents(events) {
  let last = 0;
  for (const {id, event, data} of events) {
    assert.ok(id > last, `ids increase: ${id} after ${last}`);
    last = id;
    validate(`#/components/schemas/${schemaOf[event]}`, data, `the event ${event}`);
  }
  const progress = events.filter(({event}) => event === 'progress').map(({data}) => data.progress);
  assert.deepEqual(
    progress,
    [...progress].sort((a, b) => a - b),
    'progress never falls'
  );
}

async function eventsOf(server, path, options) {
  const stream = await EventStream.open(server, path, options);
  assert.equal(stream.head.status, 200);
  const events = await stream.all();
  checkEvents(events);
  return events;
}

async function finished(server, grid) {
  const path = await server.submit(grid);
  await server.follow(path);
  return path;
}

describe('events', {concurrency: 8}, () => {
  const server = useFakeServer(['--workers', '8', '--queue-limit', '64']);

  test('the head of a stream, and its first block', async () => {
    const path = await server.submit(fresh('slow'));
    const stream = await EventStream.open(server, path);
    assert.equal(stream.head.status, 200);
    assert.match(stream.head.headers['content-type'], /^text\/event-stream/);
    assert.match(stream.head.headers['cache-control'] ?? '', /no-(cache|store)/);
    const first = await stream.nextBlock();
    assert.equal(first.retry, '1000');
    const event = first.event ? first : await stream.next();
    assert.equal(event.event, 'progress');
    assert.ok(['queued', 'running'].includes(event.data.state));
    stream.close();
    await server.ask('DELETE', path);
  });

  test('done is the job as GET shows it, and ends the stream', async () => {
    const path = await server.submit(fresh('hold:100'));
    const events = await eventsOf(server, path);
    assert.equal(events.at(-1).event, 'done');
    assert.deepEqual(events.at(-1).data, (await server.get(path)).json);
    assert.equal(events.filter(({event}) => event === 'done').length, 1);
    assert.ok(
      events.some(({data}) => data.state === 'running'),
      'it was seen running'
    );
  });

  for (const [grid, state] of [
    ['ok', 'succeeded'],
    ['empty', 'failed'],
  ])
    test(`the stream of a job that has ${state} is replayed from its start`, async () => {
      const path = await finished(server, grid === 'ok' ? fresh() : grid);
      const events = await eventsOf(server, path);
      assert.equal(events.at(-1).data.state, state);
      assert.deepEqual(await eventsOf(server, path), events, 'each time the same');
    });

  test('a canceled job says done', async () => {
    const path = await server.submit(fresh('slow'));
    const stream = await EventStream.open(server, path);
    await stream.next('progress');
    await server.ask('DELETE', path);
    const done = await stream.next('done');
    assert.equal(done.data.state, 'canceled');
    assert.equal(await stream.next(), undefined);
  });

  for (const [name, options] of [
    ['Last-Event-ID', (id) => ({headers: {'Last-Event-ID': String(id)}})],
    ['?after=', (id) => ({query: `?after=${id}`})],
  ])
    test(`${name} replays what came after it`, async () => {
      const path = await finished(server, fresh());
      const events = await eventsOf(server, path);
      assert.ok(events.length >= 2);
      for (let i = 0; i < events.length - 1; ++i)
        assert.deepEqual(await eventsOf(server, path, options(events[i].id)), events.slice(i + 1));
    });

  test('who has seen the last event is told again that it is done', async () => {
    const path = await finished(server, fresh());
    const {id, data} = (await eventsOf(server, path)).at(-1);
    const again = await eventsOf(server, path, {headers: {'Last-Event-ID': String(id)}});
    assert.deepEqual(
      again.map(({event}) => event),
      ['done']
    );
    assert.deepEqual(again[0].data, data);
  });

  test('a Last-Event-ID that is no id of ours does no harm', async () => {
    const path = await finished(server, fresh());
    for (const id of ['x', '-1', '', '99999999999999999999999999', '1.5']) {
      const stream = await EventStream.open(server, path, {headers: {'Last-Event-ID': id}});
      assert.ok([200, 400].includes(stream.head.status), `${id}: ${stream.head.status}`);
      stream.close();
    }
  });

  for (const query of ['?after=x', '?after=-1', '?colour=1', '?after=1&after=2'])
    test(`${query} is refused`, async () => {
      const path = await finished(server, fresh());
      assertProblem(await server.get(`${path}/events${query}`), 400, 'malformed-request');
    });

  test('HEAD has the head of the stream and holds none', async () => {
    const path = await server.submit(fresh('slow'));
    const answer = await server.ask('HEAD', `${path}/events`);
    assert.equal(answer.status, 200);
    assert.match(answer.headers['content-type'], /^text\/event-stream/);
    await server.ask('DELETE', path);
  });

  test('a silent stream has a heartbeat within 15 s', async () => {
    await withFakeServer(['--workers', '1'], async (small) => {
      await small.inState(await small.submit(fresh('slow')), 'running');
      const stream = await EventStream.open(small, await small.submit(fresh('slow')));
      const since = Date.now();
      let block = {};
      while (block && block.comment === undefined && Date.now() - since < 15000)
        block = await stream.nextBlock();
      assert.notEqual(block?.comment, undefined, 'a comment');
      stream.close();
    });
  });

  test('places in the queue are told', async () => {
    await withFakeServer(['--workers', '1'], async (small) => {
      const first = await small.submit(fresh('slow'));
      await small.inState(first, 'running');
      const second = await small.submit(fresh('slow'));
      const third = await small.submit(fresh('slow'));
      const stream = await EventStream.open(small, third);
      let event = await stream.next('progress');
      assert.equal(event.data.state, 'queued');
      await small.ask('DELETE', second);
      await small.ask('DELETE', first);
      while (event.data.state === 'queued') event = await stream.next('progress');
      assert.equal(event.data.state, 'running');
      stream.close();
      await small.ask('DELETE', third);
    });
  });

  test('more streams than --streams are refused, and a place is free again when one leaves', async () => {
    await withFakeServer(['--streams', '2'], async (small) => {
      const path = await small.submit(fresh('slow'));
      const streams = [await EventStream.open(small, path), await EventStream.open(small, path)];
      for (const stream of streams) await stream.next();
      assertProblem(await small.get(`${path}/events`), 503, 'queue-full', {
        setting: '--streams',
        limit: 2,
      });
      assert.equal((await small.get(path)).status, 200);
      streams[0].close();
      await eventually(async () => {
        const stream = await EventStream.open(small, path);
        stream.close();
        return stream.head.status === 200;
      }, 'a free place');
      streams[1].close();
      await small.ask('DELETE', path);
    });
  });

  test('many readers of one job see the same', async () => {
    const path = await server.submit(fresh('hold:200'));
    const all = await Promise.all(Array.from({length: 10}, () => eventsOf(server, path)));
    for (const events of all) assert.deepEqual(events, all[0]);
  });
});

describe('previews', () => {
  const server = useServer(['--workers', '2']);
  const kSlow =
    '?progressive=true&solver=gradient-descent&displacement_limit=none&alpha=1e-6' +
    '&tolerance=1e-14&max_iterations=1000000&compression=none';

  // A job whose solver runs for a long time.
  async function slowJob(query = kSlow) {
    const {body} = await server.get('/v1/samples/sphere');
    return server.submit(body, {query});
  }

  test('a running progressive job gives a GLB, its tag and its step; a new one after it', async () => {
    const path = await slowJob();
    const stream = await EventStream.open(server, path);
    const event = await stream.next('preview');
    assert.equal(event.data.href, `${path}/preview`);
    const preview = await server.get(event.data.href);
    assert.equal(preview.status, 200);
    assert.equal(preview.body.subarray(0, 4).toString(), 'glTF');
    assert.equal(preview.body.readUInt32LE(8), preview.body.length);
    assert.ok(Number(preview.headers['rivage-preview-step']) >= event.data.step);
    const later = await stream.next('preview');
    assert.ok(later.data.step > event.data.step);
    assert.ok(later.data.energy <= event.data.energy, 'the energy falls');
    stream.close();
    await server.ask('DELETE', path);
    await server.follow(path);
    assertProblem(await server.get(`${path}/preview`), 410, 'result-expired');
  });

  test('a preview that the client has is not sent again', async () => {
    const path = await slowJob();
    const stream = await EventStream.open(server, path);
    await stream.next('preview');
    await eventually(async () => {
      // a newer one may come between the two requests
      const {etag} = (await server.ask('HEAD', `${path}/preview`)).headers;
      const answer = await server.get(`${path}/preview`, {headers: {'If-None-Match': etag}});
      return answer.status === 304;
    }, '304');
    stream.close();
    await server.ask('DELETE', path);
  });

  test('a job without progressive=true has none, but tells its energy', async () => {
    const path = await slowJob(kSlow.replace('progressive=true', 'progressive=false'));
    const stream = await EventStream.open(server, path);
    const energies = [];
    while (energies.length < 3) {
      const {data} = await stream.next('progress');
      const {step, energy} = data;
      if (step !== null && step !== energies.at(-1)?.step) energies.push({step, energy});
    }
    stream.close();
    assert.deepEqual(energies.map(({step}) => step), [0, 1, 4]);
    assert.ok(energies[1].energy < energies[0].energy, 'the energy falls');
    const running = (await server.get(path)).json;
    assert.ok(running.step >= 4 && running.energy <= energies[2].energy);
    assertProblem(await server.get(`${path}/preview`), 404, 'not-found');
    await server.ask('DELETE', path);
  });

  test('previews do not change the result', async () => {
    const {body} = await server.get('/v1/samples/voxel');
    const [with_, without] = [
      await server.post('/v1/regularize?progressive=true&compression=none', body),
      await server.post('/v1/regularize?compression=none', body),
    ];
    assert.equal(with_.status, 200);
    // The options that are echoed inside differ, the geometry does not.
    assert.equal(Math.abs(with_.body.length - without.body.length) < 64, true);
  });
});
