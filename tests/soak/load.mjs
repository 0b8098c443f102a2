// Offers the real server more than it can do, and keeps it busy beside slow clients. Promises: at
// three times the peak it does at least 90 % of what it does at best; refusals come at once and say
// when to come again; probes are answered while the workers are busy and 200 clients are slow.
import {rmSync, writeFileSync} from 'node:fs';
import {join} from 'node:path';
import {LoadProcess} from './lib/load_process.mjs';
import {ms, secondsOf, secondsOfAll, table} from './lib/measure.mjs';
import {SlowCrowd} from './lib/slow.mjs';
import {Server, jsonOf, main, makeFolder, request, sleep, until} from './support.mjs';

const kConvert = {method: 'POST', target: '/v1/regularize?compression=none', vary: true};
const kVersion = {method: 'GET', target: '/version'};
const kHead = ['load', 'offered/s', 'done/s', 'refused/s', 'done ms p50', 'p99', 'refused ms p50',
  'p99', 'p99 from due', 'late ms p99', 'loop ms p99', 'generator CPU', 'CPU of others', 'done per CPU s'];

// Runs a load and says what else used the processors meanwhile.
async function measured(server, load, spec) {
  const all = secondsOfAll();
  const used = () => [server.servingPid, load.pid, process.pid].map(secondsOf);
  const before = used();
  const since = performance.now();
  const figures = await load.run(spec);
  const own = used().map((seconds, i) => seconds - before[i]);
  const others = secondsOfAll() - all - own[0] - own[1] - own[2];
  return {...figures, perCpu: figures.okMs.count / Math.max(own[0], 0.01),
    others: Math.max(0, others) / ((performance.now() - since) / 1000)};
}

const percent = (share) => `${(100 * share).toFixed(0)} %`;

function row(name, figures) {
  const {sent, seconds, goodput, refused, okMs, refusedMs, refusedDueMs, lateMs, loopMs, cpu} = figures;
  const refusals = refused ? [refusedMs.p50, refusedMs.p99, refusedDueMs.p99].map(ms) : ['', '', ''];
  return [name, (sent / seconds).toFixed(1), goodput.toFixed(1), (refused / seconds).toFixed(1),
    ms(okMs.p50), ms(okMs.p99), ...refusals, ms(lateMs.p99), ms(loopMs), percent(cpu),
    percent(figures.others), figures.perCpu.toFixed(1)];
}

function checkAnswers(name, figures, problems) {
  for (const what of ['other', 'broken', 'cached', 'silent', 'pending'])
    if (figures[what]) problems.push(`${name}: ${figures[what]} ${what} (${figures.lastError})`);
}

// A closed loop with more and more clients. @return the best {clients, goodput}
async function sweep(server, load, spec, seconds, state) {
  let best = {goodput: 0};
  for (const clients of [1, 2, 4, 8, 16]) {
    const figures = await measured(server, load, {...spec, clients, seconds});
    state.rows.push(row(`closed, ${clients} clients`, figures));
    checkAnswers(`closed, ${clients}`, figures, state.problems);
    if (figures.goodput > best.goodput) best = {clients, goodput: figures.goodput};
  }
  return best;
}

// An open loop at a multiple of the peak, between two closed ones: what the machine does for
// others changes, so the peak that counts is the one of the same minute. Where others take more
// than a quarter of a processor, jobs are counted by the processor time that the server got.
async function overload(server, load, spec, {factor, peak, seconds}, state) {
  const closed = {...spec, clients: peak.clients, seconds: seconds / 2};
  const before = await measured(server, load, closed);
  const figures = await measured(server, load, {...spec, rate: factor * peak.goodput, seconds});
  await sleep(1000);  // until the queue is empty
  const after = await measured(server, load, closed);
  state.rows.push(row('closed, just before', before), row(`open, ${factor}x`, figures),
    row('closed, just after', after));
  checkAnswers(`open, ${factor}x`, figures, state.problems);
  const compare = (what) => 2 * figures[what] / (before[what] + after[what]);
  const shared = Math.max(...[before, figures, after].map(({others}) => others)) > 0.25;
  const [byTime, byCpu] = [compare('goodput'), compare('perCpu')];
  const share = shared ? Math.max(byTime, byCpu) : byTime;
  if (figures.refusedMs.p99 >= 20)
    state.late.push(`${factor}x: refusals take ${ms(figures.refusedMs.p99)} ms, p99`);
  if (factor > 1 && share < 0.9) state.late.push(`${factor}x: ${percent(share)} of the peak`);
  return [`goodput at ${factor}x`, `${percent(byTime)} of the peak just before and after, ` +
    `${percent(byCpu)} by processor time, ${percent(figures.goodput / peak.goodput)} of the first peak`];
}

// Requests that are never complete, bodies at 2 KB/s, and readers who read nothing of 60 results.
async function slowKinds(server, grid, count) {
  const {headers} = await request(`${server.url}/v1/jobs?output=obj`,
    {method: 'POST', body: grid, headers: {'Content-Type': 'application/octet-stream'}});
  await until(async () => jsonOf(await request(server.url + headers.location)).state === 'succeeded');
  const result = `${headers.location}/result`;
  const third = Math.floor(count / 3);
  return [
    [third, {start: 'GET /version HTTP/1.1\r\nHost: soak\r\nX-Slow: ', piece: 'x'}],
    [third, {start: 'POST /v1/inspect HTTP/1.1\r\nHost: soak\r\nContent-Length: 10000000\r\n\r\n',
      piece: Buffer.alloc(2048)}],
    [count - 2 * third, {start: `GET ${result} HTTP/1.1\r\nHost: soak\r\n\r\n`.repeat(60),
      piece: '\r\n', reads: false}],
  ];
}

// Probes of both ports while the workers are busy, first without and then with slow clients.
async function probes(build, spec, grid, {seconds, slow}, state) {
  // Slow bodies hold places in the queue; with enough places the workers stay busy.
  const server = await Server.real(build, ['--queue-limit', String(2 * slow)]);
  const [busy, livez, version] = [0, 1, 2].map(() => new LoadProcess());
  const kinds = await slowKinds(server, grid, slow);
  const results = [];
  for (const crowded of [false, true]) {
    const work = busy.run({...spec, address: server.address, clients: 4});
    const crowd = new SlowCrowd(server.address, crowded ? kinds : []);
    await sleep(1500);
    const beat = {rate: 50, steady: true, seconds};
    const [live, ordinary] = await Promise.all([
      measured(server, livez, {...beat, address: server.adminAddress, method: 'GET', target: '/livez'}),
      measured(server, version, {...beat, ...kVersion, address: server.address})]);
    busy.stop();
    const done = await work;
    const open = crowd.clients.size;
    await crowd.stop();
    results.push({crowded, live, ordinary, done, open, ends: crowd.ends});
    for (const [name, figures] of [['livez', live], ['version', ordinary]]) {
      checkAnswers(name, figures, state.problems);
      if (figures.okMs.p99 >= 50) state.late.push(`${name} takes ${ms(figures.okMs.p99)} ms, p99`);
    }
    if (done.ok === 0) state.problems.push('the workers did nothing beside the slow clients');
  }
  for (const load of [busy, livez, version]) load.close();
  if (server.crashes || await server.stop() !== 0) state.problems.push('it did not end well');
  return results;
}

const probeRow = ({crowded, live, ordinary, done, open, ends}) => [
  crowded ? `${open} slow clients` : 'none', done.goodput.toFixed(1),
  ms(live.okMs.p50), ms(live.okMs.p99), ms(live.okMs.max),
  ms(ordinary.okMs.p50), ms(ordinary.okMs.p99), ms(ordinary.okMs.max), ms(live.lateMs.p99),
  percent(live.others), [...ends].map(([status, count]) => `${status} x${count}`).join(', ')];

const kProbeHead = ['beside', 'jobs/s', 'livez ms p50', 'p99', 'max', 'version ms p50', 'p99', 'max',
  'late ms p99', 'CPU of others', 'ends of slow clients'];

export async function drive(build, seconds = 20, slow = 200, factors = [1, 2, 3]) {
  const folder = makeFolder();
  const server = await Server.real(build);
  const {body} = await request(`${server.url}/v1/samples/sphere`);
  const bodyFile = join(folder, 'grid');
  writeFileSync(bodyFile, body);
  const load = new LoadProcess();
  const spec = {...kConvert, bodyFile, address: server.address};
  const state = {rows: [], problems: [], late: []};
  await load.run({...spec, clients: 4, seconds: 1});  // the first requests start threads
  const peak = await sweep(server, load, spec, seconds / 4, state);
  const shares = [];
  for (const factor of factors)
    shares.push(await overload(server, load, spec, {factor, peak, seconds}, state));
  load.close();
  if (server.crashes || await server.stop() !== 0) state.problems.push('it did not end well');
  const slowResults = await probes(build, spec, body, {seconds, slow}, state);
  rmSync(folder, {recursive: true});
  return {problems: state.problems, late: state.late, tables: [
    table(kHead, state.rows), table(kProbeHead, slowResults.map(probeRow)),
  ], figures: {
    'peak of the closed loops, jobs/s': `${peak.goodput.toFixed(1)} with ${peak.clients} clients`,
    ...Object.fromEntries(shares),
  }};
}

await main(import.meta.url, 'load', drive, '--seconds');
