// Finds the knee of the real server for the sample island with 1 and with 2 workers, with nothing
// from the cache, and puts the curve around it into RESULTS.md. Usage: knee.mjs BUILD [--out FILE]
// [--slo p99=500ms] [--window 5] [--keep] [WORKERS...]; --keep leaves RESULTS.md alone.
import {execFileSync, spawn} from 'node:child_process';
import {existsSync, mkdtempSync, readFileSync, rmSync, writeFileSync} from 'node:fs';
import {cpus, tmpdir} from 'node:os';
import {dirname, join} from 'node:path';
import {fileURLToPath} from 'node:url';
import {parseArgs} from 'node:util';

const kFolder = dirname(fileURLToPath(import.meta.url));
const kBegin = '<!-- knee: begin -->';
const kEnd = '<!-- knee: end -->';

const {values: options, positionals: [build, ...workerCounts]} = parseArgs({
  allowPositionals: true,
  options: {out: {type: 'string', default: join(kFolder, 'RESULTS.md')},
    slo: {type: 'string', default: 'p99=500ms'}, window: {type: 'string', default: '5'},
    keep: {type: 'boolean'}},
});

// Ends when the server listens; rejects if it ends before.
async function startServer(folder, workers) {
  const socket = join(folder, 'socket');
  const server = spawn(join(build, 'bin/rivage-server'), ['--listen', `unix:${socket}`,
    '--admin-listen', 'off', '--workers', String(workers), '--threads-per-job', '1'],
  {stdio: ['ignore', 'ignore', 'pipe']});
  let words = '';
  server.stderr.on('data', (text) => { words += text; });
  for (let i = 0; i < 200 && !existsSync(socket); ++i) {
    if (server.exitCode !== null) throw new Error(`the server ended: ${words}`);
    await new Promise((resolve) => { setTimeout(resolve, 50); });
  }
  return {server, socket};
}

// The search, with its words on our stderr. @return what it found
function search(socket) {
  return new Promise((resolve, reject) => {
    const load = spawn(join(build, 'bin/rivage-load'), ['search', '--server', `unix:${socket}`,
      '--slo', options.slo, '--window', options.window, '--json'],
    {stdio: ['ignore', 'pipe', 'inherit']});
    let text = '';
    load.stdout.on('data', (piece) => { text += piece; });
    load.on('close', (code) => {
      if (code === 0 || code === 3) resolve({code, ...JSON.parse(text)});
      else reject(new Error(`the search ended with ${code}`));
    });
  });
}

async function measure(workers) {
  const folder = mkdtempSync(join(tmpdir(), 'rivage-knee-'));
  const {server, socket} = await startServer(folder, workers);
  try {
    return await search(socket);
  } finally {
    const ended = new Promise((resolve) => { server.once('close', resolve); });
    server.kill('SIGTERM');
    await ended;
    rmSync(folder, {recursive: true});
  }
}

function section(workers, found) {
  const late = found.code === 3 ? '\n**The generator was late at the knee: not a valid figure.**\n' : '';
  return `### ${workers} ${workers === 1 ? 'worker' : 'workers'}\n\n` +
    `Closed loop with 4 in flight: ${found.closed_loop_per_s.toFixed(1)}/s.\n${late}\n${found.markdown}`;
}

function write(text) {
  const old = existsSync(options.out) ? readFileSync(options.out, 'utf8') : '# Results\n';
  const begin = old.indexOf(kBegin);
  const block = `${kBegin}\n${text}${kEnd}\n`;
  const whole = begin < 0 ? `${old.trimEnd()}\n\n${block}`
    : old.slice(0, begin) + block + old.slice(old.indexOf(kEnd) + kEnd.length + 1);
  writeFileSync(options.out, whole);
}

const sections = [];
let environment;
for (const workers of workerCounts.length ? workerCounts.map(Number) : [1, 2]) {
  process.stderr.write(`== ${workers} worker(s)\n`);
  const found = await measure(workers);
  environment = found.environment;
  sections.push(section(workers, found));
}
const commit = execFileSync('git', ['-C', kFolder, 'rev-parse', '--short', 'HEAD'], {encoding: 'utf8'});
const text = '## The knee: the island in one request, nothing from the cache\n\n' +
  `\`./dev bench knee\`, commit ${commit.trim()}, ${environment.time.slice(0, 10)}: ${environment.cpu}, ` +
  `${cpus().length} cores shared with the generator (one thread, nice ${environment.nice}), ` +
  `${environment.kernel}; load average before the last search ${environment.load_average.split(' ')[0]}. ` +
  'Constant rate; one thread a job. Rates are judged by three windows of ' +
  `${options.window} s that agree within 10 %, the curve has ten. Latency from the planned send.\n\n${sections.join('\n')}`;
process.stdout.write(`${text}`);
if (!options.keep) write(text);
