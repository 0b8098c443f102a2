// The program that makes load and measures, a process of its own: see load_process.mjs.
import {readFileSync} from 'node:fs';
import os from 'node:os';
import {monitorEventLoopDelay} from 'node:perf_hooks';
import {peakOf, random, rssOf, summary} from './measure.mjs';
import {Wire, fieldOf} from './wire.mjs';

let counter = 0;  // makes requests distinct, over all runs

// Head and body of the next request. What varies is the option alpha, by one part in 1e6.
function nextRequest({method, target, vary, body}) {
  const path = vary ? `${target}&alpha=${(0.5 + 1e-6 * ++counter).toFixed(7)}` : target;
  const length = body ? `Content-Type: application/octet-stream\r\nContent-Length: ${body.length}\r\n` : '';
  const head = Buffer.from(`${method} ${path} HTTP/1.1\r\nHost: soak\r\n${length}\r\n`);
  return body ? Buffer.concat([head, body]) : head;
}

class Run {
  constructor(spec) {
    this.spec = spec;
    this.idle = [];
    this.count = {sent: 0, ok: 0, refused: 0, other: 0, broken: 0, cached: 0, silent: 0};
    this.okMs = [];
    this.refusedMs = [];     // from the sending of the request
    this.refusedDueMs = [];  // from when it was due: with what the generator was late
    this.lateMs = [];
    this.underWay = new Set();
    this.over = false;
    this.began = performance.now();
  }

  send(due) {
    const one = this.#send(due).finally(() => this.underWay.delete(one));
    this.underWay.add(one);
    return one;
  }

  async #send(due) {
    const bytes = nextRequest(this.spec);
    let wire = this.idle.pop();
    while (wire && !wire.open) wire = this.idle.pop();
    const sentAt = performance.now();
    wire ??= new Wire(this.spec.address);
    this.lateMs.push(sentAt - due);
    ++this.count.sent;
    try {
      const answer = await wire.ask(bytes);
      this.#note(answer, performance.now(), sentAt, due);
      if (wire.open) this.idle.push(wire);
    } catch (error) {
      ++this.count.broken;
      this.lastError = error.message;
    }
  }

  #note({status, head}, now, sentAt, due) {
    if (status === 200) {
      if (!this.over) ++this.count.ok;
      this.okMs.push(now - sentAt);
      if (/\r\ncache-status: rivage; hit/i.test(head)) ++this.count.cached;
    } else if (status === 503) {
      ++this.count.refused;
      this.refusedMs.push(now - sentAt);
      this.refusedDueMs.push(now - due);
      if (!fieldOf(head, 'retry-after')) ++this.count.silent;
    } else {
      ++this.count.other;
      this.lastError = head.slice(0, 200);
    }
  }

  // As many at a time as there are clients.
  async closed(clients, most = Infinity) {
    await Promise.all(Array.from({length: clients}, async () => {
      while (!this.over && this.count.sent < most) await this.send(performance.now());
    }));
    if (!this.over) this.stop();
  }

  // At times that do not depend on the answers: a Poisson process, or a steady beat.
  async open(rate, steady) {
    const chance = random(7);
    for (let due = this.began; !this.over;) {
      const now = performance.now();
      while (due <= now) {
        this.send(due);
        due += (steady ? 1 : -Math.log(1 - chance())) * 1000 / rate;
      }
      await new Promise((done) => setTimeout(done, due - now));
    }
  }

  stop() {
    this.over = true;
    this.seconds = (performance.now() - this.began) / 1000;
  }
}

let current = null;

async function run(spec) {
  const delays = monitorEventLoopDelay({resolution: 1});
  delays.enable();
  const cpu = process.cpuUsage();
  current = new Run(spec);
  let peak = 0;
  const watch = spec.watch && setInterval(() => { peak = Math.max(peak, rssOf(spec.watch)); }, 20);
  const end = spec.seconds && setTimeout(() => current.stop(), 1000 * spec.seconds);
  await (spec.clients ? current.closed(spec.clients, spec.most) : current.open(spec.rate, spec.steady));
  const {user, system} = process.cpuUsage(cpu);
  await Promise.race([Promise.all(current.underWay), new Promise((done) => setTimeout(done, 30000))]);
  clearInterval(watch);
  clearTimeout(end);
  for (const wire of current.idle) wire.close();
  const {count, seconds, lastError} = current;
  return {
    ...count, seconds, lastError, pending: current.underWay.size, goodput: count.ok / seconds,
    okMs: summary(current.okMs), refusedMs: summary(current.refusedMs),
    refusedDueMs: summary(current.refusedDueMs), lateMs: summary(current.lateMs),
    loopMs: delays.percentile(99) / 1e6, cpu: (user + system) / 1e6 / seconds,
    peak: spec.watch && Math.max(peak, peakOf(spec.watch)),
  };
}

// A measuring process that waits for a processor measures itself. Only root may; else as it is.
try {
  os.setPriority(-15);
} catch {
  // goes on with the usual priority; the lateness tells
}
process.on('disconnect', () => process.exit());
process.on('message', async (message) => {
  if (message === 'stop') return current?.stop();
  process.send(await run({...message, body: message.bodyFile && readFileSync(message.bodyFile)}));
});
