// Reads a stream of server-sent events.
import assert from 'node:assert/strict';
import {requestBytes} from './http.mjs';
import {checkHead} from './schema.mjs';

const kPatience = 20000;

// Splits the text of a stream into what its blocks say: {id, event, data} , {retry} or {comment}.
function readBlock(block) {
  const event = {};
  for (const line of block.split('\n')) {
    const match = /^(id|event|data|retry)?: ?(.*)$/.exec(line);
    assert.ok(match, `a line of a stream: ${JSON.stringify(line)}`);
    const name = match[1] ?? 'comment';
    assert.ok(!(name in event), `${name} once an event`);
    event[name] = match[2];
  }
  if (event.data !== undefined) event.data = JSON.parse(event.data);
  if (event.id !== undefined) {
    assert.match(event.id, /^\d+$/);
    event.id = Number(event.id);
  }
  return event;
}

export class EventStream {
  #text = '';
  #pieces;

  // Opens the stream of a job. `head` is the head of the answer, 200 or not.
  static async open(server, path, {headers = {}, query = ''} = {}) {
    const stream = new EventStream();
    stream.connection = await server.connect();
    stream.connection.send(
      requestBytes('GET', `${path}/events${query}`, {
        headers: {Accept: 'text/event-stream', ...headers},
      })
    );
    stream.head = await stream.connection.head();
    checkHead('GET', `${path}/events${query}`, stream.head);
    stream.#pieces = stream.connection.pieces(stream.head, 'GET');
    return stream;
  }

  // The next block, or undefined at the end of the stream.
  async nextBlock() {
    while (!this.#text.includes('\n\n')) {
      const {value, done} = await this.#pieces.next();
      if (done) {
        assert.equal(this.#text, '', 'the stream ends with an event');
        return undefined;
      }
      this.#text += value.toString().replaceAll('\r\n', '\n');
    }
    const at = this.#text.indexOf('\n\n');
    const block = this.#text.slice(0, at);
    this.#text = this.#text.slice(at + 2);
    return readBlock(block);
  }

  // The next event of a kind, or of any; undefined at the end. Heartbeats do not make it wait on.
  async next(kind) {
    const limit = Date.now() + kPatience;
    for (let block; (block = await this.nextBlock());) {
      if (block.event !== undefined && (!kind || block.event === kind)) return block;
      assert.ok(Date.now() < limit, `an event ${kind ?? ''} within ${kPatience} ms`);
    }
    return undefined;
  }

  // All events up to the end of the stream.
  async all() {
    const events = [];
    for (let event; (event = await this.next());) events.push(event);
    return events;
  }

  close() {
    this.connection.close();
  }
}
