// A connection that costs little: one request at a time, as bytes; of the answer it keeps the head
// and counts the body.
import net from 'node:net';

const kEndOfHead = Buffer.from('\r\n\r\n');

export const fieldOf = (head, name) =>
  new RegExp(`\r\n${name}: *([^\r]*)`, 'i').exec(head)?.[1];

export class Wire {
  #head = null;   // text of the head, once it is whole
  #chunks = [];   // of the head
  #left = 0;      // bytes of the body that are still to come
  #done = null;
  #fail = null;

  constructor(address) {
    this.open = true;
    this.socket = net.connect(address);
    this.socket.setNoDelay(true);
    this.socket.on('data', (data) => this.#take(data));
    this.socket.on('error', (error) => this.#end(error));
    this.socket.on('close', () => this.#end(new Error('closed before the end of the answer')));
  }

  // @return {status, head} of the answer
  ask(bytes) {
    return new Promise((done, fail) => {
      [this.#done, this.#fail] = [done, fail];
      this.socket.write(bytes);
    });
  }

  close() {
    this.open = false;
    this.socket.destroy();
  }

  #end(error) {
    this.open = false;
    this.#fail?.(error);
    this.#done = this.#fail = null;
  }

  #take(data) {
    if (this.#head === null) {
      this.#chunks.push(data);
      const all = this.#chunks.length > 1 ? Buffer.concat(this.#chunks) : data;
      const end = all.indexOf(kEndOfHead);
      if (end < 0) return;
      this.#chunks = [];
      this.#head = all.toString('latin1', 0, end);
      if (this.#head.startsWith('HTTP/1.1 1')) this.#head = null;
      else this.#left = Number(fieldOf(this.#head, 'content-length') ?? 0);
      data = all.subarray(end + kEndOfHead.length);
      if (this.#head === null) return data.length ? this.#take(data) : undefined;
    }
    this.#left -= data.length;
    if (this.#left <= 0) this.#finish();
  }

  #finish() {
    const head = this.#head;
    const done = this.#done;
    this.#head = this.#done = this.#fail = null;
    if (/\r\nconnection: *close/i.test(head)) this.close();
    done?.({status: Number(head.slice(9, 12)), head});
  }
}
