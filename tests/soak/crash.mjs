// Kills the serving process with SIGKILL in the middle of jobs, again and again, while jobs come in.
// Promises: every job whose 202 arrived ends exactly once with a clear state and the right bytes;
// no blob is half-written; the state folder opens; it serves again within a second.
import {
  Load, Server, checkFolder, checkJobs, main, makeFolder, random, removeFolder, request, sleep, until,
} from './support.mjs';

// Longer than the second after which the supervisor takes a crash for one of its own kind.
const kLife = 1050;

async function killOnce(server, chance) {
  await sleep(kLife + 300 * chance());
  const before = server.servingPid;
  const since = performance.now();
  process.kill(before, 'SIGKILL');
  await until(() => server.servingPid !== before);
  await until(async () => (await request(`${server.url}/version`).catch(() => ({}))).status === 200);
  return performance.now() - since;
}

export async function drive(build, times = 100) {
  const folder = makeFolder();
  const chance = random(1);
  const makeText = (name) => chance() < 0.2 ?
    `big:${Math.floor(3e5 * chance())} ${name}` : `hold:${Math.floor(60 * chance())} ${name}`;
  let server = await new Server(build, folder).started();
  const load = new Load(() => server, {makeText, pause: 250});
  const restarts = [];
  for (let i = 0; i < times; ++i) restarts.push(await killOnce(server, chance));
  await load.stop();
  const count = await checkJobs(server, load.accepted, {allowPoison: true});
  const {problems} = count;
  for (const id of load.accepted.keys())
    if (server.endsOf(id) > 1) problems.push(`${id} ended ${server.endsOf(id)} times`);
  if (server.crashes !== times) problems.push(`${server.crashes} crashes in the log`);
  restarts.sort((a, b) => a - b);
  const slowest = restarts.at(-1);
  // Of a few, one that the machine held up is no promise broken; of many, none may be late.
  const counted = times < 10 ? restarts[times >> 1] : slowest;
  if (counted > 1000) problems.push(`a restart took ${counted.toFixed(0)} ms`);
  const code = await server.stop();
  if (code !== 0) problems.push(`exit code ${code}`);
  problems.push(...checkFolder(build, folder));

  server = await new Server(build, folder).started();
  const again = await checkJobs(server, load.accepted, {allowPoison: true});
  problems.push(...again.problems.map((text) => `in the next process: ${text}`));
  await server.stop();
  removeFolder(folder);
  return {problems, figures: {
    'kills': times, 'jobs accepted': load.accepted.size, 'succeeded': count.succeeded,
    'in quarantine (running at two kills)': count.poisoned,
    'posts without an answer': load.broken,
    'ms from kill to answer, median': restarts[restarts.length >> 1].toFixed(0),
    'ms from kill to answer, most': slowest.toFixed(0),
  }};
}

await main(import.meta.url, 'crash', drive);
