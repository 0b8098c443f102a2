// A server program on free loopback ports, and requests to it whose answers are all compared with
// the schema. RIVAGE_SERVER_PROGRAM and RIVAGE_FAKE_SERVER_PROGRAM name the programs.
import assert from 'node:assert/strict';
import {spawn} from 'node:child_process';
import {mkdtempSync, rmSync, writeFileSync} from 'node:fs';
import {tmpdir} from 'node:os';
import {join} from 'node:path';
import {after, before} from 'node:test';
import {Answer, Connection, requestBytes} from './http.mjs';
import {checkAnswer} from './schema.mjs';

const kPatience = 20000;
const kBase = [
  '--listen',
  '127.0.0.1:0',
  '--admin-listen',
  '127.0.0.1:0',
  '--log-format',
  'json',
  '--log-level',
  'info',
];
// What still runs when a server is stopped is canceled, unless a test says otherwise.
const kDrain = ['--drain-timeout', '0s'];

// Only what the tests set themselves: another RIVAGE_ variable would be a setting.
function cleanEnvironment(extra) {
  const kept = Object.entries(process.env).filter(([name]) => !name.startsWith('RIVAGE_'));
  return {...Object.fromEntries(kept), ...extra};
}

export function programPath(fake) {
  const name = fake ? 'RIVAGE_FAKE_SERVER_PROGRAM' : 'RIVAGE_SERVER_PROGRAM';
  assert.ok(process.env[name], `${name} names the program`);
  return process.env[name];
}

// A folder that is removed when the tests of the suite have ended.
export function useFolder() {
  const folder = mkdtempSync(join(tmpdir(), 'rivage-contract-'));
  after(() => rmSync(folder, {recursive: true, force: true}));
  return folder;
}

export function writeFile(folder, name, text) {
  writeFileSync(join(folder, name), text);
  return join(folder, name);
}

const portOf = (url) => Number(new URL(url).port);

// Asks again until `look` gives something; for what a server does not announce.
export async function eventually(look, what) {
  for (const limit = Date.now() + kPatience; Date.now() < limit;) {
    const found = await look();
    if (found) return found;
    await new Promise((resolve) => setTimeout(resolve, 5));
  }
  throw new Error(`it never came to this: ${what}`);
}

export class Server {
  #out = '';
  #lines = [];
  #partial = '';
  #wake = new Set();
  #asked = false;

  constructor(args, {fake = false, env = {}} = {}) {
    this.args = args.includes(kDrain[0]) ? args : [...kDrain, ...args];
    this.fake = fake;
    this.env = env;
  }

  #spawn() {
    this.child = spawn(programPath(this.fake), [...kBase, ...this.args], {
      env: cleanEnvironment(this.env),
      stdio: ['ignore', 'pipe', 'pipe'],
    });
    this.child.stdout.setEncoding('utf8').on('data', (text) => {
      this.#out += text;
      this.#tell();
    });
    this.child.stderr.setEncoding('utf8').on('data', (text) => this.#read(text));
    this.ended = new Promise((resolve, reject) => {
      this.child.on('error', reject);
      const end = (code, signal) => {
        this.code = code ?? signal;
        this.#tell();
        resolve(this.code);
      };
      this.child.on('close', end);
      // A process that it left behind would keep the pipes open.
      this.child.on('exit', (code, signal) =>
        setTimeout(() => {
          this.child.stdout.destroy();
          this.child.stderr.destroy();
          end(code, signal);
        }, 1000)
      );
    });
    this.ended.catch(() => {});
  }

  #tell() {
    for (const wake of this.#wake) wake();
  }

  #read(text) {
    const lines = (this.#partial + text).split('\n');
    this.#partial = lines.pop();
    this.#lines.push(...lines);
    this.#tell();
  }

  // Waits until `look` gives something.
  async until(look, what) {
    const limit = Date.now() + kPatience;
    for (;;) {
      const found = look();
      if (found) return found;
      const left = limit - Date.now();
      if (left <= 0 || this.code !== undefined)
        throw new Error(
          `no ${what}; the server said:\n${this.#out}${this.#lines.slice(-8).join('\n')}`
        );
      await new Promise((resolve) => {
        const wake = () => {
          clearTimeout(timer);
          this.#wake.delete(wake);
          resolve();
        };
        const timer = setTimeout(wake, left);
        this.#wake.add(wake);
      });
    }
  }

  // The lines of the log, each of which must be JSON.
  get log() {
    return this.#lines.filter((line) => line !== '').map((line) => JSON.parse(line));
  }
  logged(look, what) {
    return this.until(() => this.log.find(look), what);
  }

  async start() {
    this.#spawn();
    const {address: url} = await this.logged((line) => line.event === 'started', 'address');
    const admin = await this.logged((line) => line.event === 'admin', 'admin address');
    this.address = {host: '127.0.0.1', port: portOf(url)};
    this.adminAddress = {host: '127.0.0.1', port: portOf(admin.address)};
    return this;
  }

  // Asks the program to end, as an operator would.
  terminate() {
    this.#asked = true;
    this.child.kill('SIGTERM');
  }

  // Ends the program; it must end well.
  async stop() {
    if (!this.#asked) this.terminate();
    const timer = setTimeout(() => this.child.kill('SIGKILL'), kPatience);
    const code = await this.ended;
    clearTimeout(timer);
    assert.equal(code, 0, `the exit code; the log ends with\n${this.#lines.slice(-5).join('\n')}`);
  }

  connect(admin = false) {
    return Connection.open(admin ? this.adminAddress : this.address);
  }

  // One request on a connection of its own. options: headers, body, chunked; key; and those of
  // checkAnswer.
  async ask(method, target, options = {}) {
    const {key, headers = {}, admin = false} = options;
    const pairs = Array.isArray(headers) ? headers : Object.entries(headers);
    const all = key ? [...pairs, ['Authorization', `Bearer ${key}`]] : pairs;
    const connection = await this.connect(admin);
    connection.send(requestBytes(method, target, {...options, headers: all}));
    const answer = await connection.answer(method);
    if (!admin) await connection.closed();
    connection.close();
    this.check(method, target, answer, options);
    return answer;
  }

  // What comes back for bytes that are no proper request; checked as an answer to `method target`.
  async raw(bytes, {method = 'GET', target = '*', ...options} = {}) {
    const connection = await this.connect(options.admin);
    connection.send(bytes);
    const answer = await connection.answer(method);
    this.check(method, target, answer, options);
    connection.close();
    return answer;
  }

  check(method, target, answer, options = {}) {
    const anyBody = this.fake && target.startsWith('/v1/inspect') && answer.status === 200;
    checkAnswer(method, target, answer, {anyBody, ...options});
  }

  get(target, options) {
    return this.ask('GET', target, options);
  }
  post(target, body, options = {}) {
    return this.ask('POST', target, {body, ...options});
  }

  // Posts a job that must be accepted. The path of the job.
  async submit(body, {query = '', ...options} = {}) {
    const answer = await this.post(`/v1/jobs${query}`, body, options);
    assert.equal(answer.status, 202, answer.text);
    return answer.headers.location;
  }

  // Waits for the end of a job. The job.
  async follow(path, options = {}) {
    for (let i = 0; i < 10; ++i) {
      const answer = await this.get(path, {...options, headers: {Prefer: 'wait=5'}});
      assert.equal(answer.status, 200, answer.text);
      if (!['queued', 'running'].includes(answer.json.state)) return answer.json;
    }
    throw new Error(`${path} does not end`);
  }

  // Waits until a job is in a state that it must pass through.
  inState(path, state, options = {}) {
    return eventually(async () => {
      const job = (await this.get(path, options)).json;
      return job.state === state && job;
    }, `${path} is ${state}`);
  }

  // The paths of the jobs in a state.
  async jobsIn(state) {
    return (await this.get(`/v1/jobs?state=${state}`)).json.jobs.map((job) => job.links.self);
  }

  async metrics() {
    const answer = await this.get('/metrics', {admin: true});
    assert.equal(answer.status, 200);
    return answer.text;
  }
}

// A server for the tests of a suite: started before them, stopped, and its exit code checked, after.
export function useServer(args = [], options = {}) {
  const server = new Server(args, options);
  before(() => server.start());
  after(() => server.stop());
  return server;
}

export const useFakeServer = (args = [], options = {}) => useServer(args, {...options, fake: true});

// A server for one test.
export async function withServer(args, options, use) {
  const server = await new Server(args, options).start();
  try {
    return await use(server);
  } finally {
    await server.stop();
  }
}

// Starts a program that must refuse to. Its exit code.
export async function refusedStart(args, options = {}) {
  const server = new Server(args, options);
  try {
    await server.start();
  } catch {
    return server.ended;
  }
  await server.stop();
  return assert.fail('it started');
}

export const withFakeServer = (args, use) => withServer(args, {fake: true}, use);

export function assertProblem(answer, status, slug, members = {}) {
  assert.equal(answer.status, status, answer.text);
  assert.equal(answer.problem, slug, answer.text);
  for (const [name, value] of Object.entries(members)) {
    if (value instanceof RegExp) assert.match(String(answer.json[name]), value);
    else assert.deepEqual(answer.json[name], value, name);
  }
}

export {Answer, Connection, requestBytes};
