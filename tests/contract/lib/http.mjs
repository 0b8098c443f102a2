// One connection to a server: sends whatever bytes it is told to, and accepts no sloppy answer.
import assert from 'node:assert/strict';
import net from 'node:net';

const kPatience = 20000; // milliseconds; far above every wait that a test asks for
const kSingle = [
  'content-length',
  'content-type',
  'transfer-encoding',
  'etag',
  'location',
  'x-request-id',
  'retry-after',
  'connection',
  'www-authenticate',
  'repr-digest',
  'content-digest',
];

export class Connection {
  #buffer = Buffer.alloc(0);
  #ended = false;
  #error = null;
  #wake = () => {};

  constructor(socket) {
    this.socket = socket;
    socket.setNoDelay(true);
    socket.on('data', (data) => {
      this.#buffer = Buffer.concat([this.#buffer, data]);
      this.#wake();
    });
    socket.on('end', () => this.#finish(null));
    socket.on('error', (error) => this.#finish(error));
    socket.on('close', () => this.#finish(null));
  }

  // address: {host, port} or {path}
  static async open(address) {
    const socket = net.connect(address);
    await new Promise((resolve, reject) => {
      socket.once('connect', resolve);
      socket.once('error', reject);
    });
    return new Connection(socket);
  }

  #finish(error) {
    this.#ended = true;
    this.#error ??= error;
    this.#wake();
  }

  send(bytes) {
    if (!this.socket.destroyed)
      this.socket.write(typeof bytes === 'string' ? Buffer.from(bytes, 'latin1') : bytes);
    return this;
  }

  // The bytes come, or the connection ends, or patience does.
  async #until(there, what, patience = kPatience) {
    const limit = Date.now() + patience;
    while (!there()) {
      if (this.#ended)
        throw new Error(
          `the connection ended before ${what}` +
            `${this.#error ? ` (${this.#error.code})` : ''}; so far: ${this.#shown()}`
        );
      const left = limit - Date.now();
      if (left <= 0) throw new Error(`no ${what} within ${patience} ms; so far: ${this.#shown()}`);
      await new Promise((resolve) => {
        const timer = setTimeout(resolve, left);
        this.#wake = () => {
          clearTimeout(timer);
          resolve();
        };
      });
    }
  }

  #shown() {
    return JSON.stringify(this.#buffer.subarray(0, 200).toString('latin1'));
  }

  async take(count, what = `${count} bytes`) {
    await this.#until(() => this.#buffer.length >= count, what);
    const taken = this.#buffer.subarray(0, count);
    this.#buffer = this.#buffer.subarray(count);
    return taken;
  }

  async takeLine(what) {
    await this.#until(() => this.#buffer.includes('\r\n'), what);
    const line = (await this.take(this.#buffer.indexOf('\r\n') + 2)).toString('latin1');
    return line.slice(0, -2);
  }

  // All up to the end of the connection.
  async rest() {
    await this.#until(() => this.#ended, 'end of the connection');
    const all = this.#buffer;
    this.#buffer = Buffer.alloc(0);
    return all;
  }

  // Resolves when the server has closed; what it sent besides is an error.
  async closed() {
    const rest = await this.rest();
    assert.equal(rest.length, 0, `bytes after the answer: ${rest.subarray(0, 200)}`);
  }

  get pending() {
    return this.#buffer.length;
  }
  get ended() {
    return this.#ended;
  }

  // Status line and header fields of what comes next, which may be a 1xx answer.
  async anyHead() {
    const line = await this.takeLine('status line');
    const match = /^HTTP\/1\.1 ([1-5]\d\d) [ -~]*$/.exec(line);
    assert.ok(match, `a status line: ${JSON.stringify(line)}`);
    return {status: Number(match[1]), headers: await this.#headers(), informational: []};
  }

  // The same of the next final answer, with the 1xx answers before it.
  async head() {
    const informational = [];
    for (;;) {
      const head = await this.anyHead();
      if (head.status >= 200) return {...head, informational};
      informational.push(head.status);
    }
  }

  async #headers() {
    const headers = {};
    for (let line; (line = await this.takeLine('header fields')) !== '';) {
      const match = /^([!#$%&'*+.^_`|~0-9A-Za-z-]+): ?([\t -~]*)$/.exec(line);
      assert.ok(match, `a header field: ${JSON.stringify(line)}`);
      const name = match[1].toLowerCase();
      assert.ok(!(name in headers && kSingle.includes(name)), `${name} only once`);
      headers[name] = name in headers ? `${headers[name]}, ${match[2]}` : match[2];
    }
    const length = headers['content-length'];
    assert.ok(length === undefined || /^\d+$/.test(length), `a length: ${length}`);
    assert.ok(length === undefined || !headers['transfer-encoding'], 'one framing');
    return headers;
  }

  // The pieces of the body that belongs to a head.
  async *pieces({status, headers}, method) {
    if (method === 'HEAD' || status === 204 || status === 304) return;
    if (headers['transfer-encoding'] !== undefined) {
      assert.equal(headers['transfer-encoding'], 'chunked');
      yield* this.#chunks();
    } else if (headers['content-length'] !== undefined) {
      yield await this.take(Number(headers['content-length']), 'the whole body');
    } else {
      assert.equal(headers.connection, 'close', 'a body without length ends with the connection');
      yield await this.rest();
    }
  }

  async *#chunks() {
    for (;;) {
      const size = await this.takeLine('size of a chunk');
      assert.match(size, /^[0-9a-fA-F]{1,8}$/);
      const length = parseInt(size, 16);
      if (length) yield await this.take(length, 'chunk');
      assert.equal(await this.takeLine('end of a chunk'), '');
      if (!length) return;
    }
  }

  async answer(method = 'GET') {
    const head = await this.head();
    const pieces = [];
    for await (const piece of this.pieces(head, method)) pieces.push(Buffer.from(piece));
    return new Answer(head, Buffer.concat(pieces));
  }

  close() {
    this.socket.destroy();
  }
}

export class Answer {
  constructor({status, headers, informational}, body) {
    Object.assign(this, {status, headers, informational, body});
  }
  get text() {
    return this.body.toString();
  }
  get json() {
    return JSON.parse(this.text);
  }
  // The last part of the type of a problem.
  get problem() {
    const type = this.headers['content-type'] ?? '';
    return type.startsWith('application/problem+json')
      ? this.json.type.split('/').pop()
      : undefined;
  }
}

// The bytes of a request. `headers` may be an object or a list of pairs, for duplicates.
export function requestBytes(method, target, {headers = {}, body, chunked, close = true} = {}) {
  const given = Array.isArray(headers) ? headers : Object.entries(headers);
  const has = (name) => given.some(([other]) => other.toLowerCase() === name);
  const lines = [`${method} ${target} HTTP/1.1`];
  if (!has('host')) lines.push('Host: test');
  if (close && !has('connection')) lines.push('Connection: close');
  for (const [name, value] of given) if (value !== undefined) lines.push(`${name}: ${value}`);
  const bytes = body === undefined ? Buffer.alloc(0) : Buffer.from(body);
  const length = body !== undefined || ['POST', 'PUT', 'PATCH'].includes(method);
  if (chunked) lines.push('Transfer-Encoding: chunked');
  else if (length && !has('content-length')) lines.push(`Content-Length: ${bytes.length}`);
  const head = Buffer.from(`${lines.join('\r\n')}\r\n\r\n`, 'latin1');
  if (!chunked) return Buffer.concat([head, bytes]);
  const size = Buffer.from(`${bytes.length.toString(16)}\r\n`);
  const chunk = bytes.length ? [size, bytes, Buffer.from('\r\n')] : [];
  return Buffer.concat([head, ...chunk, Buffer.from('0\r\n\r\n')]);
}
