// A few cycles of each driver. RIVAGE_BUILD names the folder of the build. What depends on how fast
// the machine is just now, is left to the long runs.
import assert from 'node:assert/strict';
import test from 'node:test';
import {drive as attacks} from './attacks.mjs';
import {drive as crash} from './crash.mjs';
import {drive as diskFull} from './disk-full.mjs';
import {drive as load} from './load.mjs';
import {drive as memory} from './memory.mjs';
import {drive as poison} from './poison.mjs';
import {drive as sigterm} from './sigterm.mjs';

const build = process.env.RIVAGE_BUILD;
assert.ok(build, 'RIVAGE_BUILD names the folder of the build');

// Not those that last longer than any limit that can be set, and not what only the long run judges.
const isShort = ({name}) => !/slow bod|1.1 KB|trailers|2\^64|at once|2047 apart/.test(name);

for (const [name, drive] of [
  ['crash', () => crash(build, 3)],
  ['poison', () => poison(build, 1)],
  ['sigterm', () => sigterm(build, 3)],
  ['disk full', () => diskFull(build, 1)],
  ['load', () => load(build, 1, 60, [3])],
  ['memory', () => memory(build, 4, 100, 300)],
  ['attacks', () => attacks(build, 1, isShort, 100)],
])
  test(`soak: ${name}`, async (t) => {
    const {problems, skipped} = await drive();
    if (skipped) return t.skip(skipped);
    assert.deepEqual(problems, []);
  });
