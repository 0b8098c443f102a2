// One hostile request, whose sender does not stop when it is answered.
import {once} from 'node:events';
import net from 'node:net';
import {setImmediate as pause, setTimeout as sleep} from 'node:timers/promises';
import {fieldOf} from './wire.mjs';
import {outcomeOf} from './slow.mjs';

const kPatience = 60000;  // milliseconds for an answer
const kPiece = 64 << 10;  // bytes
const kKeep = 64 << 10;   // bytes of an answer

// Whether an answer is there as a whole.
function isWhole(received) {
  const end = received.indexOf('\r\n\r\n');
  return end >= 0 && received.length - end - 4 >= Number(fieldOf(received.slice(0, end), 'content-length') ?? 0);
}

// In pieces, so that an answer can come between them.
function* sliced(bytes) {
  for (let at = 0; at < bytes.length; at += kPiece) yield bytes.subarray(at, at + kPiece);
}

const drained = (socket) => new Promise((done) => socket.once('drain', done));

async function sendAll(socket, pieces) {
  const end = new AbortController();
  const closed = once(socket, 'close', {signal: end.signal}).catch(() => {});
  let sent = 0;
  for (const piece of pieces) {
    if (socket.destroyed) break;
    sent += piece.length;
    if (!socket.write(piece)) await Promise.race([drained(socket), closed]);
    await pause();  // an answer that has come is read before the next bytes
  }
  end.abort();
  return sent;
}

// pieces: bytes, or an iterable of bytes; sent to their end, or until the server closes.
// @return {status or 'cut', problem, head, body, ms: to the answer or the cut, sent: bytes}
export async function shoot(address, pieces) {
  const since = performance.now();
  let received = '';
  let at;
  let end;
  const over = new Promise((done) => { end = done; });
  const socket = net.connect(address);
  socket.on('error', () => {});  // 'close' follows
  socket.on('close', () => end());
  socket.on('data', (data) => {
    if (received.length < kKeep) received += data.toString('latin1');
    if (!isWhole(received) && received.length < kKeep) return;
    at ??= performance.now();
    end();
  });
  const sending = sendAll(socket, Buffer.isBuffer(pieces) ? sliced(pieces) : pieces);
  const patience = new AbortController();
  const lost = sleep(kPatience, 'no answer', {signal: patience.signal}).catch(() => {});
  const verdict = await Promise.race([over, lost]);
  at ??= performance.now();
  const sent = await Promise.race([sending, lost]);
  patience.abort();
  socket.destroy();
  const outcome = outcomeOf(received);
  return {...outcome, status: verdict ?? outcome.status, received, ms: at - since, sent};
}
