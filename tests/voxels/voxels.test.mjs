// Voxel outputs of the real programs, read by readers that share no code with them.
import assert from 'node:assert/strict';
import {readFileSync, writeFileSync} from 'node:fs';
import {join} from 'node:path';
import test from 'node:test';

import {makeFolder, rivage} from '../client/programs.mjs';
import {readNrrd} from './read_nrrd.mjs';
import {forEachVoxel, readVox} from './read_vox.mjs';

/** A NumPy file of values [z][y][x], 1 or 2 bytes each. */
function npy([nx, ny, nz], bytes, valueAt) {
  const head = `{'descr': '${bytes === 2 ? '<u2' : '|u1'}', 'fortran_order': False, ` +
      `'shape': (${nz}, ${ny}, ${nx}), }`;
  const padded = head.padEnd(Math.ceil((head.length + 11) / 64) * 64 - 11) + '\n';
  const start = Buffer.from('\x93NUMPY\x01\x00..' + padded, 'latin1');
  start.writeUInt16LE(padded.length, 8);
  const values = Buffer.alloc(nx * ny * nz * bytes);
  for (let i = 0; i < nx * ny * nz; i++) {
    const value = valueAt(i % nx, Math.floor(i / nx) % ny, Math.floor(i / nx / ny));
    if (bytes === 2) values.writeUInt16LE(value, 2 * i);
    else values[i] = value;
  }
  return Buffer.concat([start, values]);
}

/** Three regions: a long hill, a ball on it, the ground below. */
const kSize = [62, 18, 13];
function landscape(x, y, z) {
  if ((x - 50) ** 2 + (y - 9) ** 2 + (z - 8) ** 2 < 25) return 3;
  if (z < 2) return 1;
  return z < 5 + 3 * Math.sin(x / 6) - Math.abs(y - 9) / 3 ? 2 : 0;
}

async function convert(folder, input, output, ...options) {
  const ended = await rivage(['regularize', input, '-o', output, '--json', ...options], {folder});
  assert.equal(ended.code, 0, ended.stderr);
  const report = JSON.parse(ended.stdout);
  return {report, bytes: readFileSync(join(folder, output))};
}

test('above 256 voxels the pieces of a .vox line up exactly', async (t) => {
  const folder = makeFolder(t);
  writeFileSync(join(folder, 'in.npy'), npy(kSize, 1, landscape));
  const {report, bytes} = await convert(folder, 'in.npy', 'out.vox', '--scale', '9');
  assert.deepEqual(report.voxels.dims, kSize.map((side) => 9 * side));
  assert.equal(report.output.media_type, 'application/x-magicavoxel');
  const vox = readVox(bytes);
  assert.equal(vox.models.length, report.voxels.models);
  assert.ok(vox.models.length >= 3, `${vox.models.length} models`);

  const volume = await convert(folder, 'in.npy', 'out.nrrd', '--scale', '9');
  const {sizes, values, fields} = readNrrd(volume.bytes);
  assert.deepEqual(sizes, report.voxels.dims);
  assert.equal(fields.Segment2_LabelValue, '3');
  // The same conversion as one volume: voxel by voxel the same, each once.
  const seen = new Uint8Array(values.length);
  forEachVoxel(vox, (x, y, z, index) => {
    const at = x + sizes[0] * (y + sizes[1] * z);
    assert.ok(x >= 0 && x < sizes[0] && y >= 0 && y < sizes[1] && z >= 0 && z < sizes[2]);
    assert.equal(seen[at], 0, `one voxel at ${x} ${y} ${z}`);
    assert.equal(index, values[at], `the same at ${x} ${y} ${z}`);
    seen[at] = 1;
  });
  const solid = values.reduce((sum, value) => sum + (value ? 1 : 0), 0);
  assert.equal(seen.reduce((sum, value) => sum + value, 0), solid);
  assert.equal(report.voxels.voxels, solid);
  // Every ninth voxel is the centre of one of the input.
  for (let z = 0; z < kSize[2]; z++)
    for (let y = 0; y < kSize[1]; y++)
      for (let x = 0; x < kSize[0]; x++)
        assert.equal(values[9 * x + 4 + sizes[0] * (9 * y + 4 + sizes[1] * (9 * z + 4))],
          landscape(x, y, z));
});

test('the island three times as fine keeps its colours and materials', async (t) => {
  const folder = makeFolder(t);
  assert.equal((await rivage(['sample', 'island', '-o', 'island.vox'], {folder})).code, 0);
  const was = readVox(readFileSync(join(folder, 'island.vox')));
  const is = readVox((await convert(folder, 'island.vox', 'fine.vox', '--scale', '3')).bytes);
  const fine = new Map();
  forEachVoxel(is, (x, y, z, index) => fine.set(`${x} ${y} ${z}`, index));
  let voxels = 0;
  forEachVoxel(was, (x, y, z, index) => {
    voxels++;
    const now = fine.get(`${3 * x + 1} ${3 * y + 1} ${3 * z + 1}`);
    assert.equal(now, index);
    assert.deepEqual(is.palette[now], was.palette[index]);
    assert.deepEqual(is.materials.get(now), was.materials.get(index));
  });
  const centres = [...fine.keys()].filter((key) =>
    key.split(' ').every((value) => (((Number(value) % 3) + 3) % 3) === 1));
  assert.equal(centres.length, voxels, 'and there is nothing where nothing was');
});

test('an NRRD volume that was written is read with the same regions, names, colours and sides', async (t) => {
  const folder = makeFolder(t);
  assert.equal((await rivage(['sample', 'foam', '-o', 'foam.vox'], {folder})).code, 0);
  const written = await convert(folder, 'foam.vox', 'foam.nrrd', '--labels', 'palette', '--spacing', '1x1x2');
  const read = await convert(folder, 'foam.nrrd', 'again.nrrd');
  assert.match(read.report.input.format, /^nrrd 5 uint8$/);
  assert.deepEqual(read.report.input.spacing, [1, 1, 2]);
  assert.deepEqual(read.report.input.labels, written.report.input.labels);
  const [one, two] = [written, read].map(({bytes}) => readNrrd(bytes));
  assert.deepEqual(two.sizes, one.sizes);
  assert.deepEqual(two.values, one.values);
  const colours = ({fields}) => Object.entries(fields).filter(([key]) => /_(Name|Color)$/.test(key));
  assert.ok(colours(one).length > 2);
  assert.deepEqual(colours(two), colours(one));
});

test('more than 255 colours are joined, and the report says how far off they are', async (t) => {
  const folder = makeFolder(t);
  writeFileSync(join(folder, 'in.npy'), npy([20, 20, 2], 2, (x, y, z) => 1 + x + 20 * y + 400 * z));
  const {report, bytes} = await convert(folder, 'in.npy', 'out.vox', '--labels', 'solid');
  assert.equal(report.input.materials, 800);
  const used = new Set();
  forEachVoxel(readVox(bytes), (x, y, z, index) => used.add(index));
  assert.equal(used.size, report.voxels.colors);
  assert.ok(used.size <= 255 && used.size > 200);
  assert.ok(report.voxels.palette_error.mean > 0);
  assert.ok(report.voxels.palette_error.max >= report.voxels.palette_error.mean);
  assert.ok(report.voxels.palette_error.max < 0.1);
});

test('a scale that is none, and voxels where a mesh is asked for, are refused', async (t) => {
  const folder = makeFolder(t);
  writeFileSync(join(folder, 'in.npy'), npy([2, 2, 2], 1, () => 1));
  for (const args of [['out.vox', '--scale', '0'], ['out.vox', '--scale', '7/1000000007'],
    ['out.glb', '--scale', '2'], ['out.vox', '--shading', 'flat'], ['out.nrrd', '--up', 'z']]) {
    const [output, ...options] = args;
    const ended = await rivage(['regularize', 'in.npy', '-o', output, ...options], {folder});
    assert.equal(ended.code, 2, `${args.join(' ')}: ${ended.stderr}`);
  }
});
