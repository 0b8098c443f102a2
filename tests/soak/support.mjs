// What the drivers share: a server that runs the fake engine, requests, and the promises that a
// state folder keeps.
import {spawn, spawnSync} from 'node:child_process';
import {createHash} from 'node:crypto';
import {mkdtempSync, readdirSync, readFileSync, rmSync} from 'node:fs';
import http from 'node:http';
import {tmpdir} from 'node:os';
import {join, resolve} from 'node:path';
import {setTimeout as sleep} from 'node:timers/promises';
import {pathToFileURL} from 'node:url';

export {random} from './lib/measure.mjs';
export {sleep};
export const sha256 = (bytes) => createHash('sha256').update(bytes).digest();

// What the fake engine makes of a grid; tests/server/fake_engine.cpp has the same rule.
export function expectedResult(text) {
  const big = /^big:(\d+)/.exec(text);
  if (!big) return Buffer.from(`asset of ${text}`);
  const bytes = Buffer.alloc(Number(big[1]));
  for (let i = 0, state = 1; i < bytes.length; ++i) {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    bytes[i] = state >>> 24;
  }
  return bytes;
}

// One request on a connection of its own. Rejects if no whole answer comes; `error.answered` says
// whether it had begun.
export function request(url, {method = 'GET', body, headers = {}, timeout = 30000} = {}) {
  return new Promise((done, fail) => {
    let answered = false;
    const broken = (error) => fail(Object.assign(error, {answered}));
    const outgoing = http.request(url, {method, headers, agent: false, timeout}, (answer) => {
      answered = true;
      const chunks = [];
      answer.on('data', (chunk) => chunks.push(chunk));
      answer.on('error', broken);
      answer.on('end', () => done(
        {status: answer.statusCode, headers: answer.headers, body: Buffer.concat(chunks)}));
    });
    outgoing.on('timeout', () => outgoing.destroy(new Error('no answer in time')));
    outgoing.on('error', broken);
    outgoing.end(body);
  });
}

export const post = (server, path, text) => request(server.url + path,
  {method: 'POST', body: text, headers: {'Content-Type': 'application/octet-stream'}});
export const jsonOf = (answer) => JSON.parse(answer.body.toString());

const addressOf = (url) => ({host: '127.0.0.1', port: Number(new URL(url).port)});

// Without our own variables, which the server would take for settings.
const plainEnvironment = () => Object.fromEntries(
  Object.entries(process.env).filter(([name]) => !name.startsWith('RIVAGE_')));

// A driver that fails leaves no server behind.
const running = new Set();
process.on('exit', () => running.forEach((child) => child.kill()));

const kFakeServer = 'tests/rivage-fake-server';
const kRealServer = 'bin/rivage-server';

// A server program with a supervisor; with a folder for its state it forgets no job.
export class Server {
  constructor(build, folder, args = [], listen = '127.0.0.1:0', program = kFakeServer) {
    this.folder = folder;
    this.log = '';
    const lasting = ['--state-dir', folder, '--kept-jobs', '100000', '--result-budget', '4GiB'];
    this.child = spawn(resolve(build, program), ['--listen', listen, '--admin-listen', '127.0.0.1:0',
      '--workers', '2', ...(folder ? lasting : []), ...args], {env: plainEnvironment()});
    for (const stream of [this.child.stdout, this.child.stderr])
      stream.on('data', (data) => { this.log += data; });
    running.add(this.child);
    this.child.on('exit', () => running.delete(this.child));
    this.ended = new Promise((done) => this.child.on('close', (code) => done(code)));
  }

  async started() {
    // The address is said before the process, and each may come alone.
    const saysAll = () => [/listening on \S+/, / started pid=\d+/].every((line) => line.test(this.log));
    await until(() => saysAll() || this.child.exitCode !== null);
    this.url = /listening on (\S+)/.exec(this.log)?.[1];
    if (!this.url) throw new Error(`the server did not start:\n${this.log}`);
    return this;
  }

  static real(build, args) { return new Server(build, null, args, undefined, kRealServer).started(); }
  static fake(build, args) { return new Server(build, null, args).started(); }

  get address() { return addressOf(this.url); }
  get adminAddress() { return addressOf(this.adminUrl); }
  get adminUrl() { return /admin address=(\S+)/.exec(this.log)[1]; }

  get servingPid() {
    return Number([...this.log.matchAll(/ started pid=(\d+)/g)].at(-1)[1]);
  }

  get crashes() { return [...this.log.matchAll(/ crashed pid=/g)].length; }

  // How often the log says that a job has ended.
  endsOf(id) { return this.log.split(`job job=${id} `).length - 1; }

  // Asks it to stop. @return its exit code
  stop(signal = 'SIGTERM') {
    this.child.kill(signal);
    return this.ended;
  }
}

export async function until(condition, milliseconds = 20000) {
  const since = Date.now();
  while (!(await condition())) {
    if (Date.now() - since > milliseconds) throw new Error(`waited ${milliseconds} ms in vain`);
    await sleep(2);
  }
}

// Posts jobs until it is stopped, some of them at the same time, and remembers those accepted.
export class Load {
  constructor(getServer, {makeText, posters = 4, pause = 15}) {
    this.getServer = getServer;
    this.accepted = new Map();  // id -> text
    this.refused = new Map();   // status -> count
    this.broken = 0;            // posts without an answer: nobody knows whether they count
    this.torn = 0;              // answers that broke off
    this.running = true;
    this.loops = Array.from({length: posters}, (_, i) => this.#post(i, makeText, pause));
  }

  async #post(poster, makeText, pause) {
    for (let i = 0; this.running; ++i) {
      const text = makeText(`${poster}-${i}`);
      try {
        const answer = await post(this.getServer(), '/v1/jobs', text);
        const id = /\/v1\/jobs\/(\S+)$/.exec(answer.headers.location ?? '')?.[1];
        if (answer.status === 202) this.accepted.set(id, text);
        else this.refused.set(answer.status, (this.refused.get(answer.status) ?? 0) + 1);
      } catch (error) {
        ++this.broken;
        if (error.answered) ++this.torn;
      }
      await sleep(pause);
    }
  }

  async stop() {
    this.running = false;
    await Promise.all(this.loops);
  }
}

// Waits until every accepted job has ended, and checks each: its state is clear, its result is that
// of its grid, and the digests in the headers are those of the bytes.
// @return {succeeded, poisoned, problems: text of each broken promise}
export async function checkJobs(server, accepted, {allowPoison = false} = {}) {
  const count = {succeeded: 0, poisoned: 0, problems: []};
  for (const [id, text] of accepted) {
    let job;
    await until(async () => {
      job = jsonOf(await request(`${server.url}/v1/jobs/${id}`));
      return !['queued', 'running'].includes(job.state);
    }, 60000);
    if (job.state === 'succeeded') {
      ++count.succeeded;
      const problem = await checkResult(server, id, text);
      if (problem) count.problems.push(`${id} (${text}): ${problem}`);
    } else if (allowPoison && job.error?.type === '/problems/poison') {
      ++count.poisoned;
    } else {
      count.problems.push(`${id} (${text}): ${job.state} ${JSON.stringify(job.error ?? job)}`);
    }
  }
  return count;
}

async function checkResult(server, id, text) {
  const {status, headers, body} = await request(`${server.url}/v1/jobs/${id}/result`);
  if (status !== 200) return `its result answers ${status} ${body}`;
  if (!body.equals(expectedResult(text))) return 'its result has other bytes';
  const digest = sha256(body);
  if (headers['repr-digest'] !== `sha-256=:${digest.toString('base64')}:`)
    return `Repr-Digest ${headers['repr-digest']}`;
  const tag = headers.etag?.replaceAll('"', '') ?? '';
  return tag && digest.toString('hex').startsWith(tag) ? '' : `ETag ${headers.etag}`;
}

// What a state folder promises while no server uses it. @return text of each broken promise
export function checkFolder(build, folder) {
  const problems = [];
  for (const name of readdirSync(join(folder, 'tmp'))) problems.push(`leftover tmp/${name}`);
  for (const part of readdirSync(join(folder, 'blobs')))
    for (const name of readdirSync(join(folder, 'blobs', part)))
      if (sha256(readFileSync(join(folder, 'blobs', part, name))).toString('hex') !== name)
        problems.push(`blob ${name} has other bytes`);
  const check = spawnSync(resolve(build, 'tests/check_store'), [folder], {encoding: 'utf8'});
  if (check.status !== 0) problems.push(`check_store: ${check.stdout}${check.stderr}`);
  return problems;
}

export function makeFolder() { return mkdtempSync(join(tmpdir(), 'rivage-soak-')); }
export function removeFolder(folder) { rmSync(folder, {recursive: true, force: true}); }

// Tables and figures, and the promises that were broken; `late` are those about time.
export function report(name, {figures, tables = [], problems, late = []}) {
  const rows = Object.entries(figures).map(([what, value]) => `| ${what} | ${value} |`);
  const all = [...problems, ...late];
  const broken = all.length ? all.slice(0, 20).map((text) => `- BROKEN: ${text}`) : ['- all promises kept'];
  const blocks = tables.flatMap((text) => [text, '']);
  return [`## ${name}`, '', ...blocks, '| what | |', '|---|---|', ...rows, '', ...broken, ''].join('\n');
}

// Runs a driver if its file is the program: `node NAME.mjs BUILD [--times N]`, or what the number
// of the driver is called instead of times.
export async function main(url, name, drive, option = '--times') {
  if (url !== pathToFileURL(process.argv[1]).href) return;
  const [build, flag, number] = process.argv.slice(2);
  if (!build || (flag && (flag !== option || !(Number(number) > 0)))) {
    console.error(`usage: node ${name}.mjs BUILD [${option} N]`);
    process.exit(2);
  }
  const result = await drive(build, number ? Number(number) : undefined);
  if (result.skipped) {
    console.error(result.skipped);
    process.exit(77);
  }
  console.log(report(name, result));
  process.exit(result.problems.length || result.late?.length ? 1 : 0);
}
