// Reads a GLB with readers that share no code with the writer, and measures what it holds.
import {Document, NodeIO} from '@gltf-transform/core';
import {ALL_EXTENSIONS} from '@gltf-transform/extensions';
import draco3d from 'draco3dgltf';
import {validateBytes} from 'gltf-validator';

const kDraco = 'KHR_draco_mesh_compression';

/** The JSON chunk of a GLB. */
export function jsonOf(bytes) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  if (view.getUint32(0, true) !== 0x46546c67) throw new Error('not a GLB file');
  return JSON.parse(new TextDecoder().decode(bytes.subarray(20, 20 + view.getUint32(12, true))));
}

/** The validator's verdict: {errors, warnings, messages}. */
export async function validate(bytes) {
  const report = await validateBytes(new Uint8Array(bytes), {maxIssues: 100});
  const {numErrors, numWarnings, messages} = report.issues;
  return {
    errors: numErrors,
    warnings: numWarnings,
    messages: messages.map((m) => `${m.code} ${m.pointer ?? ''} ${m.message}`),
  };
}

let reader;
/** A gltf-transform document; Draco streams are decoded by draco3dgltf. @returns {Document} */
export async function read(bytes) {
  reader ??= new NodeIO().registerExtensions(ALL_EXTENSIONS).registerDependencies({
    'draco3d.decoder': await draco3d.createDecoderModule(),
  });
  return reader.readBinary(new Uint8Array(bytes));
}

function checkRow(row, length, what, problems) {
  if (!row.every(Number.isFinite)) problems.push(`${what}: not finite`);
  if (length && Math.abs(Math.hypot(...row) - 1) > 0.01) problems.push(`${what}: not of length 1`);
}

// Values of one primitive against what its accessors promise.
function checkPrimitive(primitive, declared, name, problems) {
  const position = primitive.getAttribute('POSITION');
  const normal = primitive.getAttribute('NORMAL');
  const color = primitive.getAttribute('COLOR_0');
  for (const [semantic, accessor] of Object.entries(declared.attributes))
    if (primitive.getAttribute(semantic).getCount() !== accessor.count)
      problems.push(`${name}: ${semantic} has not the declared count`);
  if (primitive.getIndices().getCount() !== declared.indices.count)
    problems.push(`${name}: indices have not the declared count`);
  const low = [Infinity, Infinity, Infinity];
  const high = [-Infinity, -Infinity, -Infinity];
  for (let v = 0; v < position.getCount(); ++v) {
    const row = position.getElement(v, []);
    checkRow(row, false, `${name}: position ${v}`, problems);
    row.forEach((x, i) => {
      low[i] = Math.min(low[i], x);
      high[i] = Math.max(high[i], x);
    });
    if (normal) checkRow(normal.getElement(v, []), true, `${name}: normal ${v}`, problems);
  }
  const bounds = declared.attributes.POSITION;
  if (low.some((x, i) => x !== bounds.min[i]) || high.some((x, i) => x !== bounds.max[i]))
    problems.push(`${name}: bounds are not those of the decoded positions`);
  if (color && !(color.getArray() instanceof Uint16Array && color.getNormalized()))
    problems.push(`${name}: colours are not normalized 16-bit integers`);
  for (const index of primitive.getIndices().getArray())
    if (index >= position.getCount()) problems.push(`${name}: index out of range`);
}

/** All triangles of a mesh as triples of position keys; equal keys mean equal bits. */
function* trianglesOf(mesh) {
  for (const primitive of mesh.listPrimitives()) {
    const positions = primitive.getAttribute('POSITION').getArray();
    const indices = primitive.getIndices().getArray();
    const key = (v) => `${positions[3 * v]},${positions[3 * v + 1]},${positions[3 * v + 2]}`;
    for (let i = 0; i < indices.length; i += 3)
      yield [key(indices[i]), key(indices[i + 1]), key(indices[i + 2])];
  }
}

/** The number of edges of these meshes, taken together, that an odd number of triangles has. */
export function openEdges(meshes) {
  const odd = new Set();
  for (const mesh of meshes)
    for (const triangle of trianglesOf(mesh))
      for (let k = 0; k < 3; ++k) {
        const [a, b] = [triangle[k], triangle[(k + 1) % 3]].sort();
        if (a === b) continue;
        const edge = `${a} ${b}`;
        if (!odd.delete(edge)) odd.add(edge);
      }
  return odd.size;
}

// What must be closed: the exterior as a whole, or with interfaces each label for itself.
function closedSets(nodes) {
  const labels = new Set(nodes.flatMap((n) => [n.getExtras().inner, n.getExtras().outer]));
  const isExterior = nodes.every((n) => n.getExtras().outer === 'background');
  if (isExterior) return [['the exterior', nodes]];
  labels.delete('background');
  return [...labels].map((label) => [
    label,
    nodes.filter((n) => n.getExtras().inner === label || n.getExtras().outer === label),
  ]);
}

function declaredOf(json, mesh, index) {
  const primitive = json.meshes[mesh].primitives[index];
  const attributes = {};
  for (const [semantic, a] of Object.entries(primitive.attributes))
    attributes[semantic] = json.accessors[a];
  return {attributes, indices: json.accessors[primitive.indices]};
}

/**
 * Checks a GLB in every way we know.
 * @returns {problems, parts, vertices, triangles, materials, draco, normals, colors, hints}
 */
export async function check(bytes) {
  const verdict = await validate(bytes);
  const problems = [];
  if (verdict.errors + verdict.warnings > 0) problems.push(...verdict.messages);
  const json = jsonOf(bytes);
  const document = await read(bytes);
  const nodes = document.getRoot().listNodes();
  const vertices = [];
  let triangles = 0;
  nodes.forEach((node, part) => {
    let count = 0;
    node.getMesh().listPrimitives().forEach((primitive, i) => {
      checkPrimitive(primitive, declaredOf(json, part, i), `${node.getName()}[${i}]`, problems);
      count += primitive.getAttribute('POSITION').getCount();
      triangles += primitive.getIndices().getCount() / 3;
    });
    vertices.push(count);
  });
  for (const [name, set] of closedSets(nodes)) {
    const open = openEdges(set.map((node) => node.getMesh()));
    if (open > 0) problems.push(`${name}: ${open} open edges, so parts do not meet exactly`);
  }
  const first = json.meshes[0].primitives[0];
  return {
    problems: [...new Set(problems)].slice(0, 20),
    parts: nodes.length,
    vertices,
    triangles,
    materials: json.materials.length,
    draco: (json.extensionsRequired ?? []).includes(kDraco),
    normals: 'NORMAL' in first.attributes,
    colors: 'COLOR_0' in first.attributes,
    hints: verdict.messages,
  };
}
