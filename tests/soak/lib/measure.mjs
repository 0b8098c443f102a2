// Memory and processor time of processes, and sorted figures.
import {readFileSync} from 'node:fs';

export const kMiB = 1 << 20;

// Seeded numbers in [0, 1): the same run again has the same load.
export function random(seed) {
  let state = seed >>> 0;
  return () => {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    return state / 2 ** 32;
  };
}

function statusField(pid, name) {
  try {
    const text = readFileSync(`/proc/${pid}/status`, 'latin1');
    return 1024 * Number(new RegExp(`^${name}:\\s*(\\d+) kB`, 'm').exec(text)?.[1] ?? 0);
  } catch {
    return 0;  // it has ended
  }
}

// Bytes of memory in use, and the most there ever were.
export const rssOf = (pid) => statusField(pid, 'VmRSS');
export const peakOf = (pid) => statusField(pid, 'VmHWM');

// Seconds of processor time of a process.
export function secondsOf(pid) {
  try {
    const fields = readFileSync(`/proc/${pid}/stat`, 'latin1').split(') ')[1].split(' ');
    return (Number(fields[11]) + Number(fields[12])) / 100;
  } catch {
    return 0;
  }
}

// Seconds of processor time that all processes of the machine have used.
export function secondsOfAll() {
  const fields = readFileSync('/proc/stat', 'latin1').split('\n')[0].split(/\s+/).slice(1).map(Number);
  const [user, nice, system, , , irq, softirq, steal] = fields;
  return (user + nice + system + irq + softirq + steal) / 100;
}

// {count, p50, p99, max} of numbers.
export function summary(numbers) {
  const sorted = Float64Array.from(numbers).sort();
  const at = (share) => sorted.length ? sorted[Math.min(sorted.length - 1, Math.floor(share * sorted.length))] : 0;
  return {count: sorted.length, p50: at(0.5), p99: at(0.99), max: at(1)};
}

// A table in Markdown. rows: lists of cells
export const table = (head, rows) =>
  [head, head.map(() => '---'), ...rows].map((row) => `| ${row.join(' | ')} |`).join('\n');

export const ms = (number) => number < 10 ? number.toFixed(1) : number.toFixed(0);
export const mib = (bytes) => (bytes / kMiB).toFixed(1);
