// A reader of MagicaVoxel files, from the published text of the format alone: shares nothing with
// the C++ reader and writer. Strict where it decides what lies where.
import assert from 'node:assert/strict';

class Cursor {
  constructor(bytes) {
    this.bytes = bytes;
    this.at = 0;
  }
  int() {
    const value = this.bytes.readInt32LE(this.at);
    this.at += 4;
    return value;
  }
  text() {
    const length = this.int();
    this.at += length;
    return this.bytes.subarray(this.at - length, this.at).toString('latin1');
  }
  dict() {
    return Object.fromEntries(Array.from({length: this.int()}, () => [this.text(), this.text()]));
  }
}

function chunksOf(bytes) {
  const chunks = [];
  for (let at = 0; at < bytes.length;) {
    const id = bytes.subarray(at, at + 4).toString('latin1');
    const size = bytes.readInt32LE(at + 4);
    const children = bytes.readInt32LE(at + 8);
    assert.equal(children, 0, `${id} has no children`);
    assert.ok(at + 12 + size <= bytes.length, `${id} ends inside the file`);
    chunks.push({id, content: bytes.subarray(at + 12, at + 12 + size)});
    at += 12 + size;
  }
  return chunks;
}

function readNode({id, content}) {
  const cursor = new Cursor(content);
  const node = {kind: id, id: cursor.int(), attributes: cursor.dict()};
  if (id === 'nTRN') {
    node.child = cursor.int();
    cursor.int(); // reserved
    node.layer = cursor.int();
    node.frames = Array.from({length: cursor.int()}, () => cursor.dict());
  } else if (id === 'nGRP') {
    node.children = Array.from({length: cursor.int()}, () => cursor.int());
  } else {
    node.models = Array.from({length: cursor.int()}, () => ({model: cursor.int(), attributes: cursor.dict()}));
  }
  assert.equal(cursor.at, content.length, `${id} ${node.id} has nothing behind its end`);
  return node;
}

/**
 * @param {Buffer} file
 * @returns models with `size` and `voxels`, `instances` (model, translation), `palette` by colour
 *     index, `materials` by colour index
 */
export function readVox(file) {
  assert.equal(file.subarray(0, 4).toString('latin1'), 'VOX ');
  assert.equal(file.readInt32LE(4), 200);
  assert.equal(file.subarray(8, 12).toString('latin1'), 'MAIN');
  assert.equal(file.readInt32LE(12), 0);
  assert.equal(file.readInt32LE(16), file.length - 20, 'MAIN fills the file');
  const models = [];
  const nodes = new Map();
  const palette = [];
  const materials = new Map();
  let size;
  for (const chunk of chunksOf(file.subarray(20))) {
    const {id, content} = chunk;
    if (id === 'SIZE') {
      size = [0, 4, 8].map((at) => content.readInt32LE(at));
      for (const side of size) assert.ok(side >= 1 && side <= 256, `a model is ${side} long`);
    } else if (id === 'XYZI') {
      const count = content.readUInt32LE(0);
      assert.equal(content.length, 4 + 4 * count);
      models.push({size, voxels: content.subarray(4)});
    } else if (['nTRN', 'nGRP', 'nSHP'].includes(id)) {
      const node = readNode(chunk);
      assert.ok(!nodes.has(node.id), `node ${node.id} is there once`);
      nodes.set(node.id, node);
    } else if (id === 'RGBA') {
      for (let i = 0; i < 255; i++) palette[i + 1] = [...content.subarray(4 * i, 4 * i + 4)];
    } else if (id === 'MATL') {
      const cursor = new Cursor(content);
      materials.set(cursor.int(), cursor.dict());
    }
  }
  const instances = [];
  const visit = (id, [x, y, z]) => {
    const node = nodes.get(id);
    assert.ok(node, `node ${id} exists`);
    if (node.kind === 'nTRN') {
      assert.equal(node.frames.length, 1);
      const {_t: moved = '0 0 0', _r: turned = '4'} = node.frames[0];
      assert.equal(turned, '4', 'nothing is turned');
      const [dx, dy, dz] = moved.split(' ').map(Number);
      visit(node.child, [x + dx, y + dy, z + dz]);
    } else if (node.kind === 'nGRP') {
      for (const child of node.children) visit(child, [x, y, z]);
    } else {
      for (const {model} of node.models) instances.push({model, translation: [x, y, z]});
    }
  };
  visit(0, [0, 0, 0]);
  return {models, instances, palette, materials};
}

/**
 * Calls `visit(x, y, z, index)` for every voxel at its place in the world. A transform moves the
 * point floor(size / 2) of a model to its translation.
 */
export function forEachVoxel({models, instances}, visit) {
  for (const {model, translation} of instances) {
    const {size, voxels} = models[model];
    const low = translation.map((t, axis) => t - Math.floor(size[axis] / 2));
    for (let at = 0; at < voxels.length; at += 4) {
      for (let axis = 0; axis < 3; axis++)
        assert.ok(voxels[at + axis] < size[axis], 'a voxel lies in its model');
      visit(low[0] + voxels[at], low[1] + voxels[at + 1], low[2] + voxels[at + 2], voxels[at + 3]);
    }
  }
}
