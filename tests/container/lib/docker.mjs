// Runs `docker`, and removes all that was made with it.
import {spawn} from 'node:child_process';
import {setTimeout as sleep} from 'node:timers/promises';

export {sleep};

const kPatience = 600000;  // milliseconds; for what has no shorter limit of its own

// Runs a program. @return {code, out: bytes, text, errors}; rejects only if it cannot be started
export function run(program, args, {input, env, timeout = kPatience, log} = {}) {
  return new Promise((done, fail) => {
    const child = spawn(program, args, {stdio: ['pipe', 'pipe', 'pipe'], env: {...process.env, ...env}});
    const out = [];
    let errors = '';
    const timer = setTimeout(() => child.kill('SIGKILL'), timeout);
    child.stdout.on('data', (data) => { out.push(data); log?.write(data); });
    child.stderr.on('data', (data) => { errors += data; log?.write(data); });
    child.stdin.on('error', () => {});  // it may end before it has read all
    child.on('error', (error) => { clearTimeout(timer); fail(error); });
    child.on('close', (code, signal) => {
      clearTimeout(timer);
      const bytes = Buffer.concat(out);
      done({code: code ?? signal, out: bytes, get text() { return bytes.toString().trim(); }, errors});
    });
    child.stdin.end(input);
  });
}

export const docker = (args, options) => run('docker', args, options);

// The same, where a failure is a failure of the test.
export async function must(args, options) {
  const ended = await docker(args, options);
  if (ended.code !== 0)
    throw new Error(`docker ${args.join(' ')}: ${ended.code}\n${ended.errors}${ended.text.slice(-2000)}`);
  return ended;
}

export async function inspect(name, format) {
  return JSON.parse((await must(['inspect', '--format', `{{json ${format}}}`, name])).text);
}

export async function until(condition, what, milliseconds = 30000) {
  for (const limit = Date.now() + milliseconds; Date.now() < limit; await sleep(50)) {
    const value = await condition();
    if (value) return value;
  }
  throw new Error(`it never came to this: ${what}`);
}

// Everything that a test makes has this label, and goes by it.
export class Labelled {
  constructor(label) { this.label = label; }

  get flags() { return ['--label', this.label]; }

  async removeAll() {
    const list = async (...args) => (await docker([...args, '-q', '--filter', `label=${this.label}`])).text
      .split('\n').filter(Boolean);
    const containers = await list('ps', '-a');
    if (containers.length) await docker(['rm', '-f', '-v', ...containers]);
    const networks = await list('network', 'ls');
    if (networks.length) await docker(['network', 'rm', ...networks]);
    const volumes = await list('volume', 'ls');
    if (volumes.length) await docker(['volume', 'rm', '-f', ...volumes]);
  }
}
