// Options: what is unknown, out of range, given twice or without effect is refused by its name.
import assert from 'node:assert/strict';
import {describe, test} from 'node:test';
import {cube, cubeQuery, form, fresh} from '../lib/grids.mjs';
import {assertProblem, useFakeServer, useServer} from '../lib/server.mjs';

const kRaw = 'format=raw&dims=2x2x2';

// Query, type of the problem, field, and what the detail says.
const kRefused = [
  ['alhpa=1', 'unknown-option', '/options/alhpa', /did you mean alpha\?/],
  ['colour=voxel', 'unknown-option', '/options/colour', /colors/],
  ['ALPHA=1', 'unknown-option', '/options', /ALPHA/],
  ['%00=1', 'unknown-option', '/options', /./],
  [`${'x'.repeat(300)}=1`, 'unknown-option', '/options', /./],
  ['alpha=0', 'invalid-option', '/options/alpha', /alpha/],
  ['alpha=-1', 'invalid-option', '/options/alpha', /alpha/],
  ['alpha=nan', 'invalid-option', '/options/alpha', /alpha/],
  ['alpha=inf', 'invalid-option', '/options/alpha', /alpha/],
  ['alpha=1e999', 'invalid-option', '/options/alpha', /alpha/],
  ['alpha=', 'invalid-option', '/options/alpha', /alpha/],
  ['alpha=1,5', 'invalid-option', '/options/alpha', /alpha/],
  ['alpha=0x10', 'invalid-option', '/options/alpha', /alpha/],
  ['alpha=1%20', 'invalid-option', '/options/alpha', /alpha/],
  ['max_iterations=0', 'invalid-option', '/options/max_iterations', /max_iterations/],
  ['max_iterations=1.5', 'invalid-option', '/options/max_iterations', /max_iterations/],
  [
    'max_iterations=99999999999999999999',
    'invalid-option',
    '/options/max_iterations',
    /max_iterations/,
  ],
  ['untangle=maybe', 'invalid-option', '/options/untangle', /untangle/],
  ['solver=magic', 'invalid-option', '/options/solver', /solver/],
  ['output=stl', 'invalid-option', '/options/output', /output/],
  ['alpha=1&alpha=2', 'invalid-option', '/options/alpha', /twice/],
  ['output=obj&compression=draco', 'invalid-option', '/options/compression', /output=glb/],
  ['compression=none&draco_speed=1', 'invalid-option', '/options/draco_speed', /draco/],
  ['normals=trivial&radius=3', 'invalid-option', '/options/radius', /radius/],
  [
    'normals=auto&smoothing_alpha=1',
    'invalid-option',
    '/options/smoothing_alpha',
    /piecewise-smooth/,
  ],
  ['dims=2x2x2', 'invalid-option', '/options/dims', /format=raw/],
  ['format=raw', 'invalid-option', '/options/dims', /dims/],
  ['format=raw&dims=2x2', 'invalid-option', '/options/dims', /dims/],
  ['format=raw&dims=0x2x2', 'invalid-option', '/options/dims', /dims/],
  ['format=raw&dims=99999999999x2x2', 'invalid-option', '/options/dims', /dims/],
  [`${kRaw}&labels=%7B`, undefined, '/options/labels', /./],
  [`${kRaw}&weights=%7B%22a%22:%7B%22alpha%22:0%7D%7D`, undefined, undefined, /./],
  ['emboss=bricks', 'invalid-option', '/options/emboss', /did you mean brick/],
  ['emboss=%7B%22a%22:1%7D', 'invalid-option', '/options/emboss/a', /a tile is brick/],
  ['emboss_detail=4', 'invalid-option', '/options/emboss_detail', /emboss other than none/],
  ['emboss=brick&emboss_detail=9', 'invalid-option', '/options/emboss_detail', /2 to 8/],
  ['emboss=none&emboss_method=displace', 'invalid-option', '/options/emboss_method', /emboss/],
  ['deadline_ms=0', 'invalid-option', '/options/deadline_ms', /deadline_ms/],
  ['deadline_ms=60001', 'invalid-option', '/options/deadline_ms', /./],
];

describe('options', () => {
  const server = useFakeServer(['--deadline', '60s']);

  for (const [query, slug, field, detail] of kRefused)
    test(`${query.slice(0, 60)} is refused`, async () => {
      for (const route of ['/v1/regularize', '/v1/jobs']) {
        const answer = await server.post(`${route}?${query}`, fresh());
        assert.equal(answer.status, 400, answer.text);
        if (slug) assert.equal(answer.problem, slug, answer.text);
        if (field) assert.equal(answer.json.field, field);
        assert.match(answer.json.detail, detail);
        assert.ok(answer.json.detail.length < 500, 'a short detail');
      }
    });

  const deep = (count) => `${'['.repeat(count)}${']'.repeat(count)}`;
  const kForms = {
    'no JSON': 'alpha=1',
    'an array': '[]',
    'a text': '"x"',
    null: 'null',
    'nothing behind a brace': '{',
    'a comma too many': '{"alpha": 1,}',
    'something behind it': '{} {}',
    'a member twice': '{"alpha": 1, "alpha": 1}',
    'a NaN': '{"alpha": NaN}',
    'a number that is too large': '{"alpha": 1e999}',
    'a NUL': '{"al\u0000pha": 1}',
    'a broken UTF-8': Buffer.from([0x7b, 0x22, 0xff, 0xfe, 0x22, 0x3a, 0x31, 0x7d]),
    'the wrong type': '{"alpha": "much"}',
    'an object for a number': '{"alpha": {}}',
    'a number for a flag': '{"untangle": 1}',
    'a depth of 33': `{"labels": ${deep(33)}}`,
    'a depth of 30,000': `{"labels": ${deep(30000)}}`,
    '6000 members': `{${Array.from({length: 6000}, (_, i) => `"o${i}": 1`).join(',')}}`,
  };
  for (const [what, options] of Object.entries(kForms))
    test(`options with ${what} are refused`, async () => {
      const {body, headers} = form([
        ['grid', fresh()],
        ['options', options],
      ]);
      const answer = await server.post('/v1/regularize', body, {headers});
      assert.equal(answer.status, 400, answer.text);
      assert.ok(answer.json.field.startsWith('/options'), answer.json.field);
    });

  test('options 200,000 deep are refused, and the server lives', async () => {
    const {body, headers} = form([
      ['grid', fresh()],
      ['options', deep(200000)],
    ]);
    const answer = await server.post('/v1/regularize', body, {headers});
    assert.ok([400, 413].includes(answer.status), answer.text);
    assert.equal((await server.get('/livez', {admin: true})).status, 200);
  });

  test('a query of 6 kB is read, one of 100 kB is too long', async () => {
    const long = (length) => `/v1/jobs?labels=${'x'.repeat(length)}`;
    assertProblem(await server.post(long(6000), 'ok'), 400, 'invalid-option');
    assertProblem(
      await server.raw(`POST ${long(100000)} HTTP/1.1\r\nHost: x\r\nContent-Length: 2\r\n\r\n`, {
        method: 'POST',
        target: '/v1/jobs',
      }),
      414,
      'uri-too-long'
    );
  });

  test('the job echoes the options in force, in the form that is read', async () => {
    const path = await server.submit(fresh(), {query: '?preset=paper&alpha=0.5'});
    const {options} = await server.follow(path);
    assert.equal(options.alpha, 0.5);
    assert.equal(options.preset, 'paper');
    assert.equal(options.fairness, 'umbrella');
    const {body, headers} = form([
      ['grid', fresh()],
      ['options', JSON.stringify(options)],
    ]);
    const again = await server.follow(await server.submit(body, {headers}));
    assert.deepEqual(again.options, options);
  });

  test('every option takes its default value', async () => {
    for (const {name, default: value, only_with: only} of (await server.get('/v1/options')).json
      .options) {
      if (value === null || only || ['dims', 'labels', 'weights', 'spacing', 'type'].includes(name))
        continue;
      const answer = await server.post(`/v1/regularize?${name}=${value}`, 'ok');
      assert.equal(answer.status, 200, `${name}=${value}: ${answer.text}`);
    }
  });
});

describe('options of the real engine', () => {
  const server = useServer(['--max-labels', '2', '--max-voxels', '1000', '--max-extent', '64']);
  const post = (query, body, route = '/v1/regularize') => server.post(`${route}?${query}`, body);

  for (const route of ['/v1/regularize', '/v1/inspect']) {
    test(`${route}: limits of the grid have their problem`, async () => {
      assertProblem(
        await post('format=raw&dims=4x1x1', Buffer.from([1, 2, 3, 4]), route),
        422,
        'too-many-labels',
        {limit: 2, setting: '--max-labels'}
      );
      assertProblem(
        await post('format=raw&dims=11x10x10', Buffer.alloc(1100, 1), route),
        413,
        'too-large',
        {limit: 1000, setting: '--max-voxels'}
      );
      assertProblem(
        await post('format=raw&dims=65x1x1', Buffer.alloc(65, 1), route),
        413,
        'too-large',
        {limit: 64, setting: '--max-extent'}
      );
      assertProblem(await post(kRaw, Buffer.alloc(8), route), 422, 'empty-grid');
    });
    test(`${route}: a tiny file that claims 2048^3 voxels is refused`, async () => {
      const answer = await post('format=raw&dims=2048x2048x2048', Buffer.from('tiny'), route);
      assert.ok([400, 413, 422].includes(answer.status), answer.text);
    });
    test(`${route}: bytes that are no grid`, async () => {
      assertProblem(await post(kRaw, Buffer.alloc(7, 1), route), 400, 'malformed-input');
      assertProblem(await post(kRaw, Buffer.alloc(9, 1), route), 400, 'malformed-input');
      assertProblem(
        await post('format=vox', Buffer.from('VOX \x96\0\0\0MAIN', 'latin1'), route),
        400,
        'malformed-input'
      );
      assertProblem(await post('format=npy', 'nonsense', route), 400, 'malformed-input');
      assertProblem(await post('', 'what is this?', route), 415, 'unsupported-format');
    });
  }

  for (const method of ['normals', 'displace'])
    test(`relief by ${method}: the job's report says what was made`, async () => {
      const query = `${cubeQuery}&emboss=brick&emboss_detail=3&emboss_method=${method}`;
      const {state, report, options} = await server.follow(await server.submit(cube, {query}));
      assert.equal(state, 'succeeded');
      assert.equal(options.emboss, 'brick');
      assert.equal(report.emboss.method, method);
      assert.equal(report.emboss.surfels, 9 * 24);
      assert.equal(report.emboss.solver === undefined, method === 'displace');
      assert.deepEqual(report.emboss.tiles, [{material: '*', tile: 'brick', surfels: 24}]);
      assert.ok(report.emboss.displacement_max < 0.5);
      assert.ok(report.milliseconds.emboss >= 0);
      assert.equal(report.output.triangles, 2 * 9 * 24);
    });

  test('relief for a material that the grid does not have', async () => {
    const map = encodeURIComponent('{"roof":"shingles"}');
    const answer = await post(`${cubeQuery.slice(1)}&emboss=${map}`, cube);
    assertProblem(answer, 400, 'invalid-option');
    assert.equal(answer.json.field, '/options/emboss/roof');
  });

  test('heights of the caller come as JSON beside the grid', async () => {
    const height = Array.from({length: 64}, (_, y) =>
      Array.from({length: 64}, (_, x) => ((x ^ y) & 8) / 8)
    );
    const options = {
      format: 'raw',
      dims: [2, 2, 2],
      compression: 'none',
      emboss: {1: {height, size: 2, depth: 0.1}},
    };
    const {body, headers} = form([
      ['grid', cube],
      ['options', JSON.stringify(options)],
    ]);
    const {state, report} = await server.follow(await server.submit(body, {headers}));
    assert.equal(state, 'succeeded');
    assert.equal(report.emboss.tiles[0].tile, 'own');
  });
});
