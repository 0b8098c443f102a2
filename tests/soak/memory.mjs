// Has the real server do thousands of jobs, no two of them alike. Promise: it then has at most 5 %
// more memory than after the first thousand, with its jobs in memory and with a state folder.
import {writeFileSync} from 'node:fs';
import {join} from 'node:path';
import {LoadProcess} from './lib/load_process.mjs';
import {mib, peakOf, rssOf, table} from './lib/measure.mjs';
import {Server, jsonOf, main, makeFolder, post, removeFolder, request, sleep, until} from './support.mjs';

const kClients = 4;

// Converts `count` grids, nine tiny ones for each of medium size, by synchronous requests.
async function convert(server, load, folder, count) {
  const spec = {method: 'POST', target: '/v1/regularize?compression=none', vary: true,
    address: server.address, clients: kClients};
  const medium = await load.run({...spec, bodyFile: join(folder, 'sphere'), most: Math.round(count / 10)});
  const tiny = await load.run({...spec, bodyFile: join(folder, 'voxel'), most: Math.round(9 * count / 10)});
  return [medium, tiny].filter((figures) => figures.ok !== figures.sent)
    .map((figures) => `of ${figures.sent} conversions ${figures.ok} succeeded: ${figures.lastError}`);
}

let counter = 0;

// The same by asynchronous jobs. Posts wait for the queue as a client does who is told to come later.
async function submit(server, folder, grids, count) {
  const problems = [];
  let left = count;
  await Promise.all(Array.from({length: kClients}, async () => {
    while (left-- > 0) {
      const path = `/v1/jobs?compression=none&alpha=${(0.5 + 1e-6 * ++counter).toFixed(7)}`;
      let answer;
      for (;;) {
        answer = await post(server, path, grids[counter % 10 ? 'voxel' : 'sphere']);
        if (answer.status !== 503) break;
        await sleep(20);
      }
      if (answer.status !== 202) problems.push(`a job is answered ${answer.status} ${answer.body}`);
    }
  }));
  for (const state of ['queued', 'running'])
    await until(async () =>
      jsonOf(await request(`${server.url}/v1/jobs?state=${state}`)).jobs.length === 0);
  return problems;
}

// @return rows of {jobs, rss, peak}, one for each step: does it end, or go on?
async function grow(server, {jobs, step, idle}, work, problems) {
  const rows = [];
  for (let done = 0; done < jobs; done += step) {
    problems.push(...await work(step));
    await sleep(idle);
    rows.push({jobs: done + step, rss: rssOf(server.servingPid), peak: peakOf(server.servingPid)});
  }
  if (server.crashes || await server.stop() !== 0) problems.push('the server did not end well');
  return rows;
}

function judge(name, rows, problems) {
  const growth = rows.at(-1).rss / rows[0].rss - 1;
  if (!(growth <= 0.05)) problems.push(`${name}: ${(100 * growth).toFixed(1)} % more memory`);
  return [`growth, ${name}`, `${(100 * growth).toFixed(1)} %`];
}

// thousands: of synchronous jobs; of asynchronous ones there are three tenths as many. step: what a
// thousand is; idle: milliseconds before the memory is looked at.
export async function drive(build, thousands = 10, step = 1000, idle = 2000) {
  const folder = makeFolder();
  const problems = [];
  const grids = {};
  const load = new LoadProcess();
  const server = await Server.real(build, ['--kept-jobs', String(step)]);
  for (const name of ['voxel', 'sphere']) {
    grids[name] = (await request(`${server.url}/v1/samples/${name}`)).body;
    writeFileSync(join(folder, name), grids[name]);
  }
  const sync = await grow(server, {jobs: thousands * step, step, idle},
    (count) => convert(server, load, folder, count), problems);
  load.close();
  const args = ['--kept-jobs', String(step), '--state-dir', join(folder, 'state')];
  const durable = await Server.real(build, args);
  const stored = await grow(durable, {jobs: Math.ceil(0.3 * thousands) * step, step, idle},
    (count) => submit(durable, folder, grids, count), problems);
  removeFolder(folder);
  const rows = [['synchronous', sync], ['asynchronous, --state-dir', stored]].flatMap(([name, list]) =>
    list.map(({jobs, rss, peak}) => [name, jobs, mib(rss), mib(peak)]));
  return {problems, tables: [table(['jobs', 'done', 'RSS MiB', 'most ever MiB'], rows)], figures:
    Object.fromEntries([judge('synchronous', sync, problems), judge('with --state-dir', stored, problems)])};
}

await main(import.meta.url, 'memory', drive, '--thousands');
