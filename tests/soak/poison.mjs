// Plants a grid that crashes the server. Promises: it is in quarantine after two crashes, its job
// has failed with the problem `poison`, later posts of it are refused at once, also by the next
// process, and no other job is harmed, not even those that were running at the crashes.
import {
  Load, Server, checkFolder, checkJobs, jsonOf, main, makeFolder, post, removeFolder, request, sleep, until,
} from './support.mjs';

const isPoison = (problem) => problem?.type === '/problems/poison';

// Posts one crashing grid and follows it. @return {crashes, problems}
async function plant(server, text) {
  const problems = [];
  const before = server.crashes;
  let answer;
  await until(async () => {
    answer = await post(server, '/v1/jobs', text).catch(() => null);
    return answer?.status === 202 || answer?.status === 422;
  });
  if (answer.status !== 202) return {crashes: 0, problems: [`${text} was refused at first`]};
  let job = {};
  await until(async () => {
    const shown = await request(server.url + answer.headers.location).catch(() => null);
    if (shown) job = jsonOf(shown);
    return !['queued', 'running', undefined].includes(job.state);
  });
  const crashes = server.crashes - before;
  if (job.state !== 'failed' || !isPoison(job.error)) problems.push(`${text} is ${JSON.stringify(job)}`);
  if (crashes !== 2) problems.push(`${text} crashed the server ${crashes} times`);
  problems.push(...await refusals(server, text));
  if (server.crashes - before !== crashes) problems.push(`${text} crashed the server once more`);
  return {crashes, problems};
}

async function refusals(server, text) {
  const problems = [];
  for (const path of ['/v1/jobs', '/v1/regularize']) {
    const since = performance.now();
    const answer = await post(server, path, text);
    const took = performance.now() - since;
    if (answer.status !== 422 || !isPoison(jsonOf(answer)))
      problems.push(`${path} of ${text} answers ${answer.status}`);
    if (took > 500) problems.push(`${path} of ${text} took ${took.toFixed(0)} ms`);
  }
  return problems;
}

export async function drive(build, times = 10) {
  const folder = makeFolder();
  const problems = [];
  let server = await new Server(build, folder).started();
  const load = new Load(() => server, {makeText: (name) => `hold:150 ${name}`, posters: 3, pause: 250});
  await sleep(1100);  // crashes after a second are not spaced out
  let crashes = 0;
  for (let i = 0; i < times; ++i) {
    const planted = await plant(server, `${i % 2 ? 'abort' : 'crash'} ${i}`);
    crashes += planted.crashes;
    problems.push(...planted.problems);
    await sleep(1100);
  }
  await load.stop();
  const count = await checkJobs(server, load.accepted);
  problems.push(...count.problems);
  await server.stop();
  server = await new Server(build, folder).started();
  problems.push(...await refusals(server, 'crash 0'));
  if (await server.stop() !== 0) problems.push('the last server did not end with 0');
  problems.push(...checkFolder(build, folder));
  removeFolder(folder);
  return {problems, figures: {
    'crashing grids': times, 'crashes': crashes, 'other jobs': load.accepted.size,
    'of them succeeded': count.succeeded,
  }};
}

await main(import.meta.url, 'poison', drive);
