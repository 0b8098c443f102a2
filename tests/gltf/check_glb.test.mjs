// The writer's fixtures (folder in RIVAGE_FIXTURES, made by write_fixtures) pass every check.
import assert from 'node:assert/strict';
import {readFileSync} from 'node:fs';
import {join} from 'node:path';
import test from 'node:test';

import {check, jsonOf, openEdges, read} from './glb.mjs';

const folder = process.env.RIVAGE_FIXTURES;
assert.ok(folder, 'RIVAGE_FIXTURES names the folder of the fixtures');
const expected = JSON.parse(readFileSync(join(folder, 'expected.json')));
const bytesOf = (name) => readFileSync(join(folder, name));

for (const [name, want] of Object.entries(expected))
  test(`${name}: valid, as expected, and closed`, async () => {
    const found = await check(bytesOf(name));
    assert.deepEqual(found.problems, []);
    for (const key of ['parts', 'materials', 'triangles', 'draco', 'normals', 'colors'])
      assert.equal(found[key], want[key], key);
    // Draco may split vertices where sheets touch, and never merges any.
    found.vertices.forEach((count, part) => {
      assert.ok(count >= want.vertices[part], `${count} vertices in part ${part}`);
      assert.ok(count <= 1.2 * want.vertices[part], `${count} vertices in part ${part}`);
    });
  });

test('the report is in the asset extras', () => {
  assert.deepEqual(jsonOf(bytesOf('island.glb')).asset.extras, {rivage: {sample: 'island'}});
});

test('Draco keeps the colours of plain buffers exactly', async () => {
  const colorsOf = async (name) => {
    const all = new Set();
    for (const mesh of (await read(bytesOf(name))).getRoot().listMeshes())
      for (const primitive of mesh.listPrimitives()) {
        const colors = primitive.getAttribute('COLOR_0').getArray();
        for (let i = 0; i < colors.length; i += 4) all.add(colors.slice(i, i + 4).join());
      }
    return [...all].sort();
  };
  assert.deepEqual(await colorsOf('island.glb'), await colorsOf('island_plain.glb'));
});

test('the checks see a crack, a broken bound and a broken file', async () => {
  const document = await read(bytesOf('island_plain.glb'));
  const meshes = document.getRoot().listMeshes();
  assert.equal(openEdges(meshes), 0);
  assert.ok(openEdges([meshes[0]]) > 0);
  // A vertex on the shore line, moved in one part only.
  const [sea, hill] = meshes.map((m) => m.listPrimitives()[0].getAttribute('POSITION'));
  const ofHill = new Set();
  for (let v = 0; v < hill.getCount(); ++v) ofHill.add(hill.getElement(v, []).join());
  let shore = 0;
  while (!ofHill.has(sea.getElement(shore, []).join())) ++shore;
  sea.getArray()[3 * shore] += 1e-6;
  assert.ok(openEdges(meshes) > 0);

  const bytes = bytesOf('island_plain.glb');
  const at = bytes.indexOf('"max":[') + 7;
  bytes.write(bytes[at] === 0x31 ? '2' : '1', at);
  const {problems} = await check(bytes);
  assert.ok(problems.some((p) => p.includes('ACCESSOR_MAX_MISMATCH')), problems.join());
  await assert.rejects(check(bytes.subarray(0, bytes.length - 8)));
});
