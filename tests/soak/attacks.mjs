// Attacks the real server in every way that we could think of, each time a fresh one, while another
// process asks it for its version 50 times a second and samples its memory as often. Promises: an
// honest answer or a cut, little memory, the others are served as ever, and no crash.
import {LoadProcess} from './lib/load_process.mjs';
import {kMiB, mib, ms, rssOf, table} from './lib/measure.mjs';
import {attacks} from './lib/attack_list.mjs';
import {Server, main, post, request, sleep} from './support.mjs';

const kHead = ['attack', 'answers', 'ms, most', 'MB sent, most', 'memory, MiB more', 'probe ms p50', 'p99', 'max',
  'probes'];

// "400 malformed-request x5, cut x2"
function tally(outcomes) {
  const counts = new Map();
  for (const {status, problem} of outcomes) {
    const name = problem ? `${status} ${problem}` : `${status}`;
    counts.set(name, (counts.get(name) ?? 0) + 1);
  }
  return [...counts].map(([name, count]) => count > 1 ? `${name} x${count}` : name).join(', ');
}

function checkOutcome(attack, outcome) {
  const {status, problem, silent} = outcome;
  const refused = (status >= 400 && status < 500) || status === 503;
  if (status !== 'cut' && !refused && !attack.allow.includes(status)) return `it answers ${status}`;
  if (refused && !problem) return `it answers ${status} without a problem`;
  if (silent) return `it answers ${status} without Retry-After`;
  return attack.check?.(outcome);
}

// What is still as it was before the attack.
async function checkAfter(server, attack, pid) {
  const problems = [];
  if (server.crashes || server.servingPid !== pid) problems.push('the server crashed');
  const body = attack.fake ? 'ok after' : Buffer.alloc(8, 1);
  const answer = await post(server, '/v1/regularize?format=raw&dims=2x2x2', body).catch((error) => error);
  if (answer.status !== 200) problems.push(`a job afterwards: ${answer.status ?? answer.message}`);
  if (await server.stop() !== 0) problems.push('the server did not end with 0');
  return problems;
}

// @return {row of the table, late, problems}
async function carryOut(build, attack, probe, least) {
  const server = await (attack.fake ? Server.fake : Server.real)(build, attack.args);
  const pid = server.servingPid;
  const context = await attack.prepare?.(server);
  for (let i = 0; i < 20; ++i) await request(`${server.url}/version`);
  await sleep(300);
  const before = rssOf(pid);
  const probing = probe.run({address: server.address, method: 'GET', target: '/version', rate: 50, steady: true, watch: pid});
  const [outcomes] = await Promise.all([attack.run(server, context), sleep(least)]);
  probe.stop();
  const figures = await probing;
  const growth = figures.peak - before;
  const found = new Set(outcomes.map((outcome) => checkOutcome(attack, outcome)).filter(Boolean));
  for (const text of await checkAfter(server, attack, pid)) found.add(text);
  if (growth >= attack.growth * kMiB) found.add(`${mib(growth)} MiB more memory`);
  const late = figures.okMs.p99 < 50 ? [] : [`${attack.name}: others wait ${ms(figures.okMs.p99)} ms, p99`];
  if (!figures.okMs.count) found.add('others are not answered');
  for (const what of ['refused', 'other', 'broken', 'pending'])
    if (figures[what]) found.add(`others: ${figures[what]} ${what} (${figures.lastError})`);
  const most = (name) => Math.max(0, ...outcomes.map((outcome) => outcome[name] ?? 0));
  const row = [attack.name, tally(outcomes), ms(most('ms')), (most('sent') / 1e6).toFixed(1), mib(growth),
    ms(figures.okMs.p50), ms(figures.okMs.p99), ms(figures.okMs.max), figures.okMs.count];
  return {row, late, problems: [...found].map((text) => `${attack.name}: ${text}`)};
}

// seconds: how long slow clients are borne with; filter: which attacks; least: milliseconds of
// probing, 100 probes, so that a percentile means something
export async function drive(build, seconds = 10, filter = () => true, least = 2000) {
  const probe = new LoadProcess();
  const rows = [];
  const problems = [];
  const late = [];
  const quiet = {name: '(none)', growth: 64, allow: [], run: async () => []};
  try {
    for (const attack of [quiet, ...attacks(seconds)].filter(filter)) {
      const result = await carryOut(build, attack, probe, least);
      rows.push(result.row);
      problems.push(...result.problems);
      late.push(...result.late);
    }
  } finally {
    probe.close();
  }
  return {problems, late, tables: [table(kHead, rows)], figures: {'attacks': rows.length - 1}};
}

await main(import.meta.url, 'attacks', drive, '--seconds');
