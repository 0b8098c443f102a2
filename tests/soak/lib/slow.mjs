// Clients that take their time over a request, or over its answer.
import net from 'node:net';
import {setTimeout as sleep} from 'node:timers/promises';
import {fieldOf} from './wire.mjs';

// Sends a beginning at once and then a piece again and again; reads what comes, or nothing at all.
// `ended` gives {status, problem, ms}: of the answer, or 'cut' without one.
export class SlowClient {
  constructor(address, {start, piece, period = 1000, reads = true}) {
    this.began = performance.now();
    this.received = '';
    this.socket = net.connect(address);
    this.socket.write(start);
    const drip = setInterval(() => this.socket.write(piece), period);
    if (reads) this.socket.on('data', (data) => this.#take(data));
    else this.socket.pause();
    this.socket.on('error', () => {});  // 'close' follows
    this.ended = new Promise((done) => this.socket.on('close', () => {
      clearInterval(drip);
      done({...outcomeOf(this.received), ms: (this.answeredAt ?? performance.now()) - this.began});
    }));
  }

  #take(data) {
    this.answeredAt ??= performance.now();
    if (this.received.length < 4096) this.received += data.toString('latin1');
  }

  close() { this.socket.destroy(); }
}

// What the first bytes of an answer say.
export function outcomeOf(text) {
  if (!text) return {status: 'cut', head: ''};
  const [head, body = ''] = text.split('\r\n\r\n', 2);
  return {
    status: Number(head.slice(9, 12)), head,
    problem: /"type": *"\/problems\/([^"]*)/.exec(body)?.[1],
    silent: [429, 503, 507].includes(Number(head.slice(9, 12))) && !fieldOf(head, 'retry-after'),
  };
}

// Keeps slow clients of several kinds open, and opens another wherever one ends.
export class SlowCrowd {
  // kinds: list of [how many, what SlowClient takes]
  constructor(address, kinds) {
    this.clients = new Set();
    this.running = true;
    this.ends = new Map();  // status -> how many ended so
    this.loops = kinds.flatMap(([count, kind]) =>
      Array.from({length: count}, () => this.#keepOne(address, kind)));
  }

  async #keepOne(address, kind) {
    while (this.running) {
      const client = new SlowClient(address, kind);
      this.clients.add(client);
      const {status} = await client.ended;
      this.clients.delete(client);
      if (!this.running) return;
      this.ends.set(status, (this.ends.get(status) ?? 0) + 1);
      await sleep(100);
    }
  }

  async stop() {
    this.running = false;
    for (const client of this.clients) client.close();
    await Promise.all(this.loops);
  }
}
