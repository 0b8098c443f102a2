// A Docker engine: the one that answers, or Debian's, started here with folders of its own.
import {spawn} from 'node:child_process';
import {existsSync, mkdirSync, mkdtempSync, openSync, readFileSync} from 'node:fs';
import {homedir, tmpdir} from 'node:os';
import {join} from 'node:path';
import {docker, run, sleep} from './docker.mjs';

const kPatience = 60000;
export const cache = process.env.RIVAGE_CACHE ??
  join(process.env.XDG_CACHE_HOME ?? join(homedir(), '.cache'), 'rivage');

const answers = async () => (await docker(['info', '--format', '{{.ServerVersion}}'], {timeout: 10000})
  .catch(() => ({code: 1}))).code === 0;

// No engine can run here; the message says why.
export class NoEngine extends Error {}

const asRoot = (...words) => process.getuid() === 0 ? words : ['sudo', '-n', ...words];

// Runs a program as root; like `run`.
export function runAsRoot(words, options) {
  const [program, ...args] = asRoot(...words);
  return run(program, args, options);
}

async function checkMeans() {
  if (process.platform !== 'linux') throw new NoEngine('there is no engine, and only Linux can start one');
  if ((await run('docker', ['--version']).catch(() => ({code: 1}))).code !== 0)
    throw new NoEngine('there is no docker command');
  if ((await runAsRoot(['dockerd', '--version']).catch(() => ({code: 1}))).code !== 0)
    throw new NoEngine('no engine answers, and dockerd cannot be started: it needs Debian\'s docker.io, and root or sudo');
}

export class Engine {
  // @return an engine that answers. One that was there already is used, and left alone.
  static async get() {
    const engine = new Engine();
    if (await answers()) return engine;
    await checkMeans();
    await engine.#start();
    return engine;
  }

  get own() { return this.pidFile !== undefined; }

  // No bridge and no firewall rules outside of its own networks: the machine stays as it is.
  async #start() {
    mkdirSync(join(cache, 'engine'), {recursive: true});
    this.folder = mkdtempSync(join(tmpdir(), 'rivage-engine-'));
    this.pidFile = join(this.folder, 'pid');
    const log = join(cache, 'engine', 'log');
    const words = openSync(log, 'w');
    process.env.DOCKER_HOST = `unix://${this.folder}/socket`;
    const [program, ...args] = asRoot('dockerd', '--data-root', join(cache, 'engine', 'data'),
      '--exec-root', join(this.folder, 'exec'), '--pidfile', this.pidFile,
      '--host', process.env.DOCKER_HOST, '--group', String(process.getgid()),
      '--bridge=none', '--iptables=false', '--ip-masq=false');
    const child = spawn(program, args, {stdio: ['ignore', words, words], detached: true});
    this.ended = new Promise((done) => child.on('exit', done).on('error', done));
    let over = false;
    this.ended.then(() => { over = true; });
    for (const limit = Date.now() + kPatience; !(await answers()); await sleep(200)) {
      if (!over && Date.now() < limit) continue;
      const said = readFileSync(log, 'utf8').split('\n').filter((line) => /level=(error|fatal)|^failed/.test(line));
      await this.stop();
      throw new NoEngine(`dockerd did not start: ${said.at(-1) ?? `see ${log}`}`);
    }
  }

  // Ends it if it was started here, by its own process id.
  async stop() {
    if (!this.own) return;
    if (existsSync(this.pidFile)) {
      await runAsRoot(['kill', readFileSync(this.pidFile, 'utf8').trim()]);
      await this.ended;
    }
    // It leaves the mount of its own network namespace behind.
    await runAsRoot(['bash', '-c', `umount -q '${this.folder}'/exec/netns/*; rm -rf '${this.folder}'`]);
  }
}
