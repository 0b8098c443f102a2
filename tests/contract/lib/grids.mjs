// Bodies of requests: grids, forms, and packed forms of both.
import {deflateSync, gzipSync} from 'node:zlib';

// A cube of 2x2x2 voxels for the real server, and its query.
export const cube = Buffer.alloc(8, 1);
export const cubeQuery = '?format=raw&dims=2x2x2&compression=none';
// Two labels side by side.
export const pair = Buffer.from([1, 2]);
export const pairQuery = '?format=raw&dims=2x1x1&compression=none';

export const kBytes = {'Content-Type': 'application/octet-stream'};

let counter = 0;
// A grid for the fake engine that nobody has sent before, so that nothing is answered from a cache.
export const fresh = (kind = 'ok') => `${kind}-${process.pid}-${++counter}`;

// A form. parts: lists of [name, content, {filename, type}].
export function form(parts, {boundary = 'frontier', end = true} = {}) {
  const pieces = parts.map(([name, content, {filename, type, raw} = {}]) =>
    Buffer.concat([
      Buffer.from(
        `--${boundary}\r\n${
          raw ??
          `Content-Disposition: form-data; name="${name}"` +
            (filename === undefined ? '' : `; filename="${filename}"`)
        }\r\n` +
          (type ? `Content-Type: ${type}\r\n` : '') +
          '\r\n',
        'latin1'
      ),
      Buffer.from(content),
      Buffer.from('\r\n'),
    ])
  );
  return {
    body: Buffer.concat([...pieces, Buffer.from(end ? `--${boundary}--\r\n` : '')]),
    headers: {'Content-Type': `multipart/form-data; boundary=${boundary}`},
  };
}

export const gzip = (bytes) => gzipSync(Buffer.from(bytes));
export const deflate = (bytes) => deflateSync(Buffer.from(bytes));

const kRaw = 0;
const kRle = 1;

function zstdBlock(type, size, content, last) {
  const header = Buffer.alloc(3);
  header.writeUIntLE((size << 3) | (type << 1) | (last ? 1 : 0), 0, 3);
  return Buffer.concat([header, content]);
}

// A Zstandard frame (RFC 8878) without a content size, made by hand: node 20 has no zstd.
function zstdFrame(blocks) {
  const magic = Buffer.from([0x28, 0xb5, 0x2f, 0xfd]);
  const descriptor = Buffer.from([0x00, 0x38]); // no flags; a window of 2^17 bytes
  return Buffer.concat([magic, descriptor, ...blocks]);
}

export const zstd = (bytes) => zstdFrame([zstdBlock(kRaw, bytes.length, Buffer.from(bytes), true)]);

// A frame that inflates to `size` equal bytes; 4 bytes for each 128 KiB.
export function zstdBomb(size, byte = 0x6f) {
  const block = 128 << 10;
  const blocks = [];
  for (let left = size; left > 0; left -= block)
    blocks.push(zstdBlock(kRle, Math.min(block, left), Buffer.from([byte]), left <= block));
  return zstdFrame(blocks);
}

export const gzipBomb = (size) => gzipSync(Buffer.alloc(size, 'o'), {level: 9});
