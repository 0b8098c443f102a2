// A few cycles of each driver. RIVAGE_BUILD names the folder of the build.
import assert from 'node:assert/strict';
import test from 'node:test';
import {drive as crash} from './crash.mjs';
import {drive as diskFull} from './disk-full.mjs';
import {drive as poison} from './poison.mjs';
import {drive as sigterm} from './sigterm.mjs';

const build = process.env.RIVAGE_BUILD;
assert.ok(build, 'RIVAGE_BUILD names the folder of the build');

for (const [name, drive, times] of
  [['crash', crash, 3], ['poison', poison, 1], ['sigterm', sigterm, 3], ['disk full', diskFull, 1]])
  test(`soak: ${name}`, async (t) => {
    const {problems, skipped} = await drive(build, times);
    if (skipped) return t.skip(skipped);
    assert.deepEqual(problems, []);
  });
