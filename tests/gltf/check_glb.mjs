// node check_glb.mjs FILE...: checks GLB files and prints one line each; exit code 1 on a problem.
import {readFileSync} from 'node:fs';

import {check} from './glb.mjs';

const files = process.argv.slice(2);
if (files.length === 0) {
  console.error('usage: node check_glb.mjs FILE...');
  process.exit(2);
}
let failed = 0;
for (const file of files) {
  const bytes = readFileSync(file);
  let found;
  try {
    found = await check(bytes);
  } catch (error) {
    found = {problems: [error.message], vertices: []};
  }
  const vertices = found.vertices.reduce((sum, n) => sum + n, 0);
  const verdict = found.problems.length === 0 ? 'ok' : 'BAD';
  console.log(`${verdict}  ${file}  ${bytes.length} bytes, ${found.parts ?? 0} parts, ` +
              `${vertices} vertices, ${found.triangles ?? 0} triangles`);
  for (const problem of found.problems) console.log(`     ${problem}`);
  failed += found.problems.length > 0 ? 1 : 0;
}
process.exit(failed > 0 ? 1 : 0);
