// A reader of NRRD files, from the published format alone.
import assert from 'node:assert/strict';
import {gunzipSync} from 'node:zlib';

/**
 * @param {Buffer} file
 * @returns `fields` by name, keys with their own values among them, `sizes`, and `values`
 */
export function readNrrd(file) {
  const end = file.indexOf('\n\n');
  const lines = file.subarray(0, end).toString('utf8').split('\n');
  assert.match(lines[0], /^NRRD000[1-5]$/);
  const fields = {};
  for (const line of lines.slice(1).filter((text) => !text.startsWith('#'))) {
    const [, name, value] = /^([^:]+):[= ](.*)$/.exec(line);
    assert.ok(!(name in fields), `${name} is there once`);
    fields[name] = value;
  }
  const data = file.subarray(end + 2);
  const raw = fields.encoding === 'gzip' ? gunzipSync(data) : data;
  const sizes = fields.sizes.split(' ').map(Number);
  const count = sizes.reduce((product, side) => product * side, 1);
  const wide = fields.type === 'uint16';
  if (wide) assert.equal(fields.endian, 'little');
  assert.equal(raw.length, count * (wide ? 2 : 1));
  const values = wide
    ? Uint16Array.from({length: count}, (_, i) => raw.readUInt16LE(2 * i))
    : Uint8Array.from(raw);
  return {fields, sizes, values};
}
