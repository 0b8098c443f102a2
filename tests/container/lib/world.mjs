// What a scenario works with: a private network, servers and clients in it, and a container with node,
// from which requests are sent that no proper client would send.
import {randomBytes} from 'node:crypto';
import {readFileSync} from 'node:fs';
import {Labelled, docker, inspect, must, until} from './docker.mjs';
import {image} from './images.mjs';

const kClientPatience = 120000;
const inside = (name) => readFileSync(new URL(`../inside/${name}.mjs`, import.meta.url));

export const kServer = '/usr/bin/rivage-server';
export const kHardened = ['--read-only', '--cap-drop', 'ALL', '--security-opt', 'no-new-privileges',
  '--user', '12345:0', '--memory', '512m', '--pids-limit', '256'];

export class World {
  constructor() {
    this.id = `rivage-test-${randomBytes(4).toString('hex')}`;
    this.all = new Labelled(`org.rivage.test=${this.id}`);
    this.counter = 0;
  }

  // A network without a way out, and the container that asks.
  async open() {
    await must(['network', 'create', '--internal', ...this.all.flags, this.id]);
    await must(['run', '--detach', '--name', `${this.id}-asker`, '--network', this.id, ...this.all.flags,
      '--init', image('test')]);
    return this;
  }
  close() { return this.all.removeAll(); }

  name() { return `${this.id}-${++this.counter}`; }

  async volume() {
    const name = this.name();
    await must(['volume', 'create', ...this.all.flags, name]);
    return name;
  }

  // A server that takes work. `flags` are those of docker run, `env` its settings.
  async server({flags = [], env = {}, args = [], from = image('server'), alias = 'server', ready = true} = {}) {
    const name = this.name();
    const settings = Object.entries(env).flatMap(([key, value]) => ['--env', `${key}=${value}`]);
    await must(['run', '--detach', '--name', name, '--network', this.id, '--network-alias', alias,
      ...this.all.flags, ...settings, ...flags, from, ...args]);
    const server = new Server(this, name, alias);
    if (ready) await server.ready();
    return server;
  }

  // The client, in a container of its own.
  client(args, {input, server = 'http://server:8080', flags = [], timeout = kClientPatience} = {}) {
    return docker(['run', '--rm', '--interactive', '--network', this.id, ...this.all.flags, '--read-only',
      '--cap-drop', 'ALL', ...flags, image('client'), '--server', server, ...args], {input, timeout});
  }

  // The sample scene, and its surface.
  async sample() {
    const {out, code, errors} = await this.client(['sample', 'island', '-o', '-']);
    if (code !== 0) throw new Error(`sample: ${code} ${errors}`);
    return out;
  }

  // Runs inside/NAME.mjs in the network. @return what it prints, read as JSON
  async ask(script, argument = {}, timeout = 300000) {
    const ended = await docker(['exec', '--interactive', '--env', `ARGUMENT=${JSON.stringify(argument)}`,
      `${this.id}-asker`, 'node', '--input-type=module', '-'], {input: inside(script), timeout});
    if (ended.code !== 0) throw new Error(`inside/${script}: ${ended.code}\n${ended.errors.slice(-2000)}`);
    return JSON.parse(ended.text.split('\n').at(-1));
  }

  // Runs a shell command beside a container: in its network or among its processes.
  async beside(container, share, command, flags = []) {
    return (await must(['run', '--rm', `--${share}=container:${container}`, ...this.all.flags, ...flags,
      image('test'), 'bash', '-euc', command])).text;
  }
}

class Server {
  constructor(world, name, alias) {
    this.world = world;
    this.name = name;
    this.url = `http://${alias}:8080`;
    this.admin = `http://${alias}:8081`;
  }

  probe(question) { return docker(['exec', this.name, kServer, '--probe', question]); }

  async ready(milliseconds = 20000) {
    await until(async () => (await this.probe('ready')).code === 0 || (await this.state()).Status === 'exited',
      `${this.name} is ready`, milliseconds);
    const {Status: status, ExitCode: code} = await this.state();
    if (status !== 'running') throw new Error(`${this.name} is ${status} with ${code}:\n${await this.said()}`);
  }

  state() { return inspect(this.name, '.State'); }

  // All that it wrote.
  async said() {
    const {text, errors} = await docker(['logs', this.name]);
    return text + errors;
  }
  async log() {
    return (await this.said()).split('\n').filter(Boolean).map((line) => JSON.parse(line));
  }

  // The process that serves, as the processes beside it see it: the child of the first.
  async servingPid() {
    return (await this.world.beside(this.name, 'pid',
      `for s in /proc/[0-9]*/status; do [ "$(awk '/^PPid:/ {print $2}' $s)" = 1 ] && ` +
      `grep -q '^Name:.*rivage-server' $s && awk '/^Pid:/ {print $2}' $s; done | sort -n | head -n 1`));
  }

  signal(signal, pid) {
    return this.world.beside(this.name, 'pid', `kill -${signal} ${pid}`,
      ['--user', '0', '--cap-add', 'KILL', '--cap-add', 'SYS_PTRACE']);
  }

  // Memory of its processes together, in bytes: what they have, and the most that they ever had.
  memory() { return this.#memory('VmRSS'); }
  peakMemory() { return this.#memory('VmHWM'); }
  async #memory(field) {
    const words = await this.world.beside(this.name, 'pid',
      `grep -h '^${field}:' $(grep -l '^Name:.*rivage-server' /proc/[0-9]*/status) | awk '{sum += $2} END {print sum}'`);
    return Number(words) * 1024;
  }

  // What happens to the packets of this container from now on. A narrow link and rules that drop, since
  // not every kernel has netem.
  #network(...commands) {
    return this.world.beside(this.name, 'network', commands.join('; '),
      ['--cap-drop', 'ALL', '--cap-add', 'NET_ADMIN', '--cap-add', 'NET_RAW', '--user', '0']);
  }
  slow(rate) {
    const drop = '-m statistic --mode random --probability 0.05 -j DROP';
    return this.#network(`tc qdisc add dev eth0 root tbf rate ${rate} burst 8kb latency 2s`,
      `iptables -A INPUT -i eth0 ${drop}`, `iptables -A OUTPUT -o eth0 ${drop}`);
  }
  cut() { return this.#network('iptables -I INPUT -i eth0 -j DROP', 'iptables -I OUTPUT -o eth0 -j DROP'); }
  mend() { return this.#network('iptables -F'); }
}
