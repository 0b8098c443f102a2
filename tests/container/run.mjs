#!/usr/bin/env node
// node tests/container/run.mjs [--faults] [--soak=MINUTES] [--built] [--clean] [PATTERN]: builds the
// images and runs the scenarios whose name contains PATTERN, in containers. With --faults each has a
// fault put into it, and must fail. --soak runs the one long scenario. --built takes the images as they
// are, --clean removes them instead. Exit code 77 where no engine can run.
import {Engine, NoEngine} from './lib/engine.mjs';
import {Images} from './lib/images.mjs';
import {World} from './lib/world.mjs';
import compose from './scenarios/compose.mjs';
import image from './scenarios/image.mjs';
import jobs from './scenarios/jobs.mjs';
import life from './scenarios/life.mjs';
import limits from './scenarios/limits.mjs';
import network from './scenarios/network.mjs';
import {soak} from './scenarios/soak.mjs';

const flags = process.argv.slice(2).filter((word) => word.startsWith('--'));
const [pattern = ''] = process.argv.slice(2).filter((word) => !word.startsWith('--'));
const minutes = Number(flags.find((flag) => flag.startsWith('--soak='))?.slice('--soak='.length));
const scenarios = minutes > 0 ? [soak(minutes)]
  : [...image, ...jobs, ...limits, ...life, ...network, ...compose].filter(({name}) => name.includes(pattern));
const seconds = (since) => ((Date.now() - since) / 1000).toFixed(1);
const count = {passed: 0, failed: 0, skipped: 0};
let current;

// One scenario in a world of its own. With a fault, its failure is what is wanted.
async function play({name, fault, run}, faulty) {
  const since = Date.now();
  const world = new World();
  current = world;
  let outcome;
  let words = '';
  try {
    await world.open();
    const found = await run(world, faulty);
    outcome = found?.skipped ? 'skipped' : faulty ? 'failed' : 'passed';
    words = found?.skipped ?? found ?? '';
    if (faulty && outcome === 'failed') words = `the fault was not noticed: ${fault}`;
  } catch (error) {
    outcome = faulty ? 'passed' : 'failed';
    words = faulty ? `${fault} -> ${error.message.replace(/\s+/g, ' ').slice(0, 300)}` : error.stack;
  } finally {
    await world.close();
  }
  ++count[outcome];
  console.log(`${{passed: 'ok  ', failed: 'FAIL', skipped: 'skip'}[outcome]} ${name}, ${seconds(since)} s`);
  if (words) console.log(`     ${words}`);
}

async function main(engine) {
  const images = new Images(engine);
  if (flags.includes('--clean')) {
    await images.removeAll();
    return;
  }
  const since = Date.now();
  if (!flags.includes('--built')) await images.makeAll();
  const built = seconds(since);
  for (const scenario of scenarios) await play(scenario, flags.includes('--faults'));
  const {base, server, client} = await images.sizes();
  const mb = (bytes) => `${(bytes / 1e6).toFixed(1)} MB`;
  console.log(`images: server ${mb(server)} and client ${mb(client)} beyond a base of ${mb(base)}`);
  console.log(`time: ${seconds(since)} s, ${built} s of it for the images`);
  console.log(`${count.passed} passed, ${count.failed} failed, ${count.skipped} skipped`);
  process.exitCode = count.failed || !scenarios.length ? 1 : 0;
}

let engine;
async function end() {
  await current?.close();
  await engine?.stop();
}
for (const signal of ['SIGINT', 'SIGTERM'])
  process.once(signal, () => end().finally(() => process.exit(130)));
try {
  engine = await Engine.get();
  await main(engine);
} catch (error) {
  console.error(error instanceof NoEngine ? `skipped: ${error.message}` : error.stack);
  process.exitCode = error instanceof NoEngine ? 77 : 1;
} finally {
  await engine?.stop();
}
