// Reads what a GLB file says about itself. Throws if it is none.
import assert from 'node:assert/strict';

export function readGlb(bytes) {
  assert.equal(bytes.toString('latin1', 0, 4), 'glTF');
  assert.equal(bytes.readUInt32LE(4), 2, 'its version');
  assert.equal(bytes.readUInt32LE(8), bytes.length, 'its length');
  const json = JSON.parse(bytes.subarray(20, 20 + bytes.readUInt32LE(12)));
  const triangles = json.meshes.flatMap(({primitives}) => primitives)
    .reduce((sum, {indices}) => sum + json.accessors[indices].count / 3, 0);
  return {json, triangles};
}
