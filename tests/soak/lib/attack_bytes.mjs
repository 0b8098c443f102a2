// What attackers send: requests, packed bodies, forms, and tiny grids that claim to be huge.
import {gzipBomb, zstdBomb} from '../../contract/lib/grids.mjs';
import {requestBytes} from '../../contract/lib/http.mjs';
import {kMiB} from './measure.mjs';

const kRaw = '/v1/regularize?format=raw&dims=2x2x2';

export const get = (target, headers) => requestBytes('GET', target, {headers, close: false});
export const post = (target, options) => requestBytes('POST', target, {close: false, ...options});

// The head of a request, and then whatever it is followed by.
export function* follow(head, pieces) {
  yield Buffer.from(head, 'latin1');
  yield* pieces;
}

// `bytes` bytes of the same text.
export function* endless(text, bytes) {
  const block = Buffer.from(text.repeat(Math.ceil(kMiB / text.length)));
  for (let sent = 0; sent < bytes; sent += block.length) yield block;
}

export const chunkedHead = (target, type = 'application/octet-stream') => `POST ${target} HTTP/1.1\r\n` +
  `Host: soak\r\nContent-Type: ${type}\r\nTransfer-Encoding: chunked\r\n\r\n`;

// The same pieces as chunks of a body.
export function* chunks(pieces) {
  for (const piece of pieces) {
    yield Buffer.from(`${piece.length.toString(16)}\r\n`);
    yield piece;
    yield Buffer.from('\r\n');
  }
  yield Buffer.from('0\r\n\r\n');
}

const packed = (encoding, body) =>
  post('/v1/regularize', {body, headers: {'Content-Type': 'application/octet-stream', 'Content-Encoding': encoding}});

export const gzipBombRequest = () => packed('gzip', gzipBomb(256 * kMiB));

// window: power of two that the frame asks for, from 10 on
export function zstdBombRequest(window) {
  const frame = zstdBomb(1024 * kMiB);
  if (window) frame[5] = (window - 10) << 3;
  return packed('zstd', frame);
}

const kForm = 'multipart/form-data; boundary=frontier';
const part = (head) => Buffer.from(`--frontier\r\nContent-Disposition: form-data; ${head}\r\n\r\n`);

export const formRequest = (body) => post('/v1/regularize', {body, headers: {'Content-Type': kForm}});

export const deepOptions = (depth) => formRequest(Buffer.concat([
  part('name="options"'), Buffer.from('{"labels":'.padEnd(10 + depth, '[')), Buffer.from('\r\n'),
  part('name="grid"'), Buffer.from('x\r\n--frontier--\r\n')]));

export const manyParts = (count) =>
  formRequest(Buffer.concat([Buffer.from(''), ...Array(count).fill(Buffer.concat([part('name="grid"'), Buffer.from('x\r\n')]))]));

export const endlessPart = (bytes) => follow(chunkedHead('/v1/regularize', kForm), chunks(
  follow('--frontier\r\nContent-Disposition: form-data; name="grid"; filename="', endless('a', bytes))));

export const openPart = () => formRequest(Buffer.concat([part('name="grid"'), Buffer.alloc(1000)]));

export const rawRequest = (headers) => post(kRaw, {body: Buffer.alloc(8, 1), headers});

// Tiny grids of 2048 x 2048 x 2048 voxels, or so they say.
const int = (...numbers) => Buffer.from(new Int32Array(numbers).buffer);
const text = (string) => Buffer.concat([int(string.length), Buffer.from(string)]);
const dict = (...pairs) => Buffer.concat([int(pairs.length), ...pairs.flat().map(text)]);
const chunk = (id, ...content) => {
  const bytes = Buffer.concat(content);
  return Buffer.concat([Buffer.from(id), int(bytes.length, 0), bytes]);
};
const vox = (...list) => {
  const children = Buffer.concat(list);
  return Buffer.concat([Buffer.from('VOX '), int(150), Buffer.from('MAIN'), int(0, children.length), children]);
};
const convert = (body, query = '') =>
  post(`/v1/regularize${query}`, {body, headers: {'Content-Type': 'application/octet-stream'}});

// Two voxels in the corners of a model, whose count may be a lie.
export const hugeVox = (count = 2) => convert(vox(chunk('SIZE', int(2048, 2048, 2048)),
  chunk('XYZI', int(count), Buffer.from([0, 0, 0, 1, 255, 255, 255, 1]))));

// One voxel shown at two places that are `apart` voxels from each other along each axis.
export function distantVox(apart) {
  const shape = (id, move) => [
    chunk('nTRN', int(id), dict(), int(id + 1, -1, -1, 1), dict(['_t', `${move} ${move} ${move}`])),
    chunk('nSHP', int(id + 1), dict(), int(1, 0), dict())];
  return convert(vox(chunk('SIZE', int(1, 1, 1)), chunk('XYZI', int(1), Buffer.from([0, 0, 0, 1])),
    chunk('nTRN', int(0), dict(), int(1, -1, -1, 1), dict()),
    chunk('nGRP', int(1), dict(), int(2, 2, 4)), ...shape(2, 0), ...shape(4, apart)));
}

export function hugeNpy() {
  const header = "{'descr': '|u1', 'fortran_order': False, 'shape': (2048, 2048, 2048), }".padEnd(117) + '\n';
  return convert(Buffer.concat([Buffer.from('\x93NUMPY\x01\x00v\x00', 'latin1'), Buffer.from(header), Buffer.alloc(8, 1)]));
}

export const hugeRaw = () => convert(Buffer.alloc(8, 1), '?format=raw&dims=2048x2048x2048');

const kLong = 'a'.repeat(5000);
export const kPaths = ['/../../etc/passwd', '/%2e%2e/%2e%2e/etc/passwd', '/..%2f..%2fetc%2fpasswd',
  '/v1/samples/%2e%2e', '/v1/samples/..%2f..%2fetc%2fpasswd', '/v1/samples/sphere%00.vox', '/v1/jobs/%00',
  '/%00', '//etc/passwd', '//version', '/..\\..\\etc\\passwd', '/v1\\limits', '/%5c%2e%2e', '/./version',
  '/%c0%ae%c0%ae/etc/passwd', '/%', '/%zz', `/v1/jobs/${kLong}`, '*', 'version', 'http://127.0.0.1/etc/passwd',
  'http://127.0.0.1/../etc/passwd', 'file:///etc/passwd'];
