// node render.mjs IN.glb OUT.png [--angle 35] [--elevation 30] [--zoom 1] [--size 900x700] [--wire]
import {readFileSync, writeFileSync} from 'node:fs';
import {parseArgs} from 'node:util';

import {kDefaults, renderModel} from './harness.mjs';

const {values, positionals} = parseArgs({
  allowPositionals: true,
  options: {
    angle: {type: 'string'},
    elevation: {type: 'string'},
    zoom: {type: 'string'},
    size: {type: 'string', default: `${kDefaults.width}x${kDefaults.height}`},
    wire: {type: 'boolean', default: false},
  },
});
const [width, height] = values.size.split('x').map(Number);
const options = {width, height, wire: values.wire};
for (const name of ['angle', 'elevation', 'zoom'])
  if (values[name] !== undefined) options[name] = Number(values[name]);
const numbers = Object.values(options).filter((value) => typeof value === 'number');
if (positionals.length !== 2 || !numbers.every(Number.isFinite)) {
  console.error('usage: node render.mjs IN.glb OUT.png [--angle DEGREES] [--elevation DEGREES] ' +
                '[--zoom FACTOR] [--size WIDTHxHEIGHT] [--wire]');
  process.exit(2);
}
const {png, parts, picture, outside, complaints} =
    await renderModel(readFileSync(positionals[0]), options);
writeFileSync(positionals[1], png);
const vertices = parts.reduce((sum, part) => sum + part.vertices, 0);
console.log(`${positionals[1]}: ${parts.length} meshes, ${vertices} vertices, ` +
            `${Math.round(100 * picture.coverage)} % of the picture covered`);
for (const problem of [...outside.map((url) => `outside request ${url}`), ...complaints])
  console.error(problem);
process.exit(outside.length + complaints.length > 0 ? 1 : 0);
