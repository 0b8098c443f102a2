// Fills the disk of the state folder, a tmpfs of 2 MB that only root can mount, again and again.
// Promises: jobs are refused with 507 or 503 and the problem `storage-full`, what was accepted ends
// with a clear state, conversions that need no room go on, nothing is corrupted, and all is well
// once there is room.
import {spawnSync} from 'node:child_process';
import {closeSync, openSync, rmSync, writeSync} from 'node:fs';
import {join} from 'node:path';
import {Server, checkFolder, jsonOf, main, makeFolder, post, removeFolder, request, until} from './support.mjs';

// Takes all the room that is left.
function fill(path) {
  const file = openSync(path, 'w');
  try {
    for (const block = Buffer.alloc(4096, 1); ;) writeSync(file, block);
  } catch (error) {
    if (error.code !== 'ENOSPC') throw error;
  } finally {
    closeSync(file);
  }
}

async function endOf(server, id) {
  let job;
  await until(async () => {
    job = jsonOf(await request(`${server.url}/v1/jobs/${id}`));
    return !['queued', 'running'].includes(job.state);
  });
  return job;
}

// Posts jobs with large results until one is refused. @return {ids, refused}
async function postUntilRefused(server, name, problems) {
  const ids = [];
  for (let i = 0; i < 100; ++i) {
    const answer = await post(server, '/v1/jobs', `big:${100000 + i} ${name}`);
    if (answer.status === 202) {
      ids.push(answer.headers.location.split('/').at(-1));
      await endOf(server, ids.at(-1));
      continue;
    }
    const problem = jsonOf(answer);
    if (![503, 507].includes(answer.status) || problem.type !== '/problems/storage-full')
      problems.push(`refused with ${answer.status} ${answer.body}`);
    if (!answer.headers['retry-after']) problems.push('a refusal without Retry-After');
    return {ids, refused: true};
  }
  return {ids, refused: false};
}

async function cycle(server, disk, name, problems) {
  const first = await postUntilRefused(server, name, problems);
  let refused = first.refused;
  fill(join(disk, 'filler'));
  const full = await post(server, '/v1/jobs', `ok ${name}`);
  refused ||= full.status === 507 || full.status === 503;
  if (!refused) problems.push(`no refusal on a full disk, but ${full.status}`);
  const direct = await post(server, '/v1/regularize', `ok direct ${name}`);
  if (direct.status !== 200) problems.push(`a conversion that needs no room answers ${direct.status}`);
  for (const id of first.ids) {
    const job = await endOf(server, id);
    if (job.state !== 'succeeded' && job.error?.type !== '/problems/storage-full')
      problems.push(`${id} is ${JSON.stringify(job)}`);
  }
  rmSync(join(disk, 'filler'));
  for (const id of first.ids) await request(`${server.url}/v1/jobs/${id}`, {method: 'DELETE'});
  // The room comes back when what was forgotten is collected, a little later.
  let last;
  await until(async () => {
    last = await post(server, '/v1/jobs', `ok after ${name}`);
    if (last.status !== 202) return false;
    last = await endOf(server, last.headers.location.split('/').at(-1));
    return last.state === 'succeeded';
  }, 5000).catch(() => problems.push(`with room again: ${JSON.stringify(last)}`));
  return first.ids.length;
}

export async function drive(build, times = 5) {
  const disk = makeFolder();
  const mounted = process.getuid() === 0 &&
    spawnSync('mount', ['-t', 'tmpfs', '-o', 'size=2m', 'tmpfs', disk]).status === 0;
  if (!mounted) {
    removeFolder(disk);
    return {skipped: 'disk-full needs root, to mount a small disk'};
  }
  const problems = [];
  let accepted = 0;
  try {
    const server = await new Server(build, join(disk, 'state')).started();
    for (let i = 0; i < times; ++i) accepted += await cycle(server, disk, `cycle ${i}`, problems);
    if (server.crashes) problems.push(`${server.crashes} crashes`);
    if (await server.stop() !== 0) problems.push('it did not end with 0');
    problems.push(...checkFolder(build, join(disk, 'state')));
  } finally {
    spawnSync('umount', ['-l', disk]);
    removeFolder(disk);
  }
  return {problems, figures: {'times full': times, 'jobs accepted before': accepted}};
}

await main(import.meta.url, 'disk-full', drive);
