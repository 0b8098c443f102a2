// The writer's fixtures (folder in RIVAGE_FIXTURES) load and show in three.js, offline.
import assert from 'node:assert/strict';
import {readFileSync} from 'node:fs';
import {join} from 'node:path';
import test from 'node:test';

import {check} from '../gltf/glb.mjs';
import {renderModel} from './harness.mjs';

const folder = process.env.RIVAGE_FIXTURES;
assert.ok(folder, 'RIVAGE_FIXTURES names the folder of the fixtures');

for (const name of ['island.glb', 'island_plain.glb', 'island_flat_labels.glb', 'materials.glb'])
  test(`${name}: three.js shows it as it was written`, async () => {
    const bytes = readFileSync(join(folder, name));
    const expected = await check(bytes);
    const shown = await renderModel(bytes, {width: 320, height: 240});
    assert.deepEqual(shown.outside, []);
    assert.deepEqual(shown.complaints, []);
    assert.equal(shown.parts.length, expected.vertices.length);
    shown.parts.forEach((part, i) => {
      assert.equal(part.vertices, expected.vertices[i]);
      assert.equal(part.colors, expected.colors);
      assert.equal(part.flat, !expected.normals);
    });
    assert.equal(shown.extras.rivage.sample, name.replace('.glb', ''));
    assert.ok(shown.picture.coverage > 0.05, 'the picture is blank');
    assert.ok(shown.picture.colors > 8, 'the picture has one colour');
  });

test('materials.glb: glass transmits and light shines', async () => {
  const {parts} = await renderModel(readFileSync(join(folder, 'materials.glb')));
  assert.equal(parts.filter((part) => part.transmission === 0.8).length, 1);
  assert.equal(parts.filter((part) => part.emissive !== 0).length, 1);
});
