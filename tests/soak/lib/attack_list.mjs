// All attacks: {name, run(server, context)} gives the outcomes, and where they differ from most
// {args, fake: which server; prepare(server): what is there before; growth: MiB of memory that it
// may take; allow: statuses besides 4xx and 503; check(outcome): what is wrong with it}.
import {post as upload, jsonOf, request, sleep, until} from '../support.mjs';
import * as bytes from './attack_bytes.mjs';
import {SlowClient} from './slow.mjs';
import {shoot} from './shot.mjs';

const kEndless = 300e6;  // bytes
const kSlack = 64;       // MiB; what any attack may take
const kMaxUpload = 64;   // MiB; the server's default
// MiB; what /v1/inspect predicts for a grid of two voxels 2047 apart, which is lawful: 16 bytes for
// each row of pointels, and a fixed part. A grid above the budget is refused.
const kPredicted = 16 + 16 * 2049 ** 2 / 2 ** 20;
const kTwice = 'POST /v1/regularize HTTP/1.1\r\nHost: soak\r\n';

// Each of the requests several times, one after the other.
const shots = (name, makers, {times = 5, ...more} = {}) => ({name, ...more, run: async (server, context) => {
  const outcomes = [];
  for (let i = 0; i < times; ++i)
    for (const make of makers) outcomes.push(await shoot(server.address, make(context)));
  return outcomes;
}});

const once = (name, make, more) => shots(name, [make], {times: 1, ...more});
const crowd = (server, count, kind) =>
  Promise.all(Array.from({length: count}, () => new SlowClient(server.address, kind).ended));

async function bigResult(server, size) {
  const {headers} = await upload(server, '/v1/jobs', `big:${size} slow readers`);
  await until(async () => jsonOf(await request(server.url + headers.location)).state === 'succeeded');
  return `${headers.location}/result`;
}

async function smallResult(server) {
  const {headers} = await upload(server, '/v1/jobs?format=raw&dims=2x2x2', Buffer.alloc(8, 1));
  await until(async () => jsonOf(await request(server.url + headers.location)).state === 'succeeded');
  return `${headers.location}/result`;
}

const boundless = ({sent}) => sent >= kEndless ? 'all of it was taken' : '';

const slowHead = (target, length) =>
  `POST ${target} HTTP/1.1\r\nHost: soak\r\nContent-Length: ${length}\r\n\r\n`;

// Bodies just fast enough hold every place of the queue; what do others get meanwhile?
async function lawfulBodies(server, _, {seconds}) {
  const clients = Array.from({length: 18}, () => new SlowClient(server.address,
    {start: slowHead('/v1/regularize?format=raw&dims=2x2x2', 1e6), piece: Buffer.alloc(1100)}));
  await sleep(500);
  const outcomes = [];
  for (let i = 0; i < seconds; ++i) {
    outcomes.push(await shoot(server.address, bytes.rawRequest()));
    await sleep(1000);
  }
  for (const client of clients) client.close();
  return outcomes;
}

const slowAttacks = (seconds) => [
  {name: 'slowloris: 200 heads, a byte a second', args: ['--header-timeout', `${seconds}s`],
    run: (server) => crowd(server, 200, {start: 'GET /version HTTP/1.1\r\nHost: soak\r\nX-Slow: ', piece: 'x'})},
  {name: '200 slow bodies, a byte a second',
    run: (server) => crowd(server, 200, {start: slowHead('/v1/regularize?format=raw&dims=2x2x2', 1e6), piece: 'x'})},
  {name: '18 bodies at 1.1 KB/s; the answers are those of others', allow: [200],
    run: (server, context) => lawfulBodies(server, context, {seconds})},
  {name: '200 readers of 20 MB who read nothing', fake: true, args: ['--write-timeout', `${seconds}s`],
    prepare: (server) => bigResult(server, 20e6),
    run: (server, result) => crowd(server, 200,
      {start: `GET ${result} HTTP/1.1\r\nHost: soak\r\n\r\n`, piece: '\r\n', period: 250, reads: false})},
];

function manyBombs() {
  const bomb = bytes.gzipBombRequest();
  return {name: '16 gzip bombs at once, --upload-budget 128MiB', args: ['--upload-budget', '128MiB'],
    growth: 128 + kSlack,
    run: (server) => Promise.all(Array.from({length: 16}, () => shoot(server.address, bomb)))};
}

const packedAttacks = () => {
  const growth = kMaxUpload + kSlack;
  return [
    shots('gzip bomb, 256 MiB from 260 KB', [bytes.gzipBombRequest], {growth}),
    shots('zstd bomb, 1 GiB from 32 KB', [() => bytes.zstdBombRequest()], {growth}),
    shots('zstd bomb, window of 128 MiB', [() => bytes.zstdBombRequest(27)], {growth}),
    shots('zstd bomb, window of 2 GiB', [() => bytes.zstdBombRequest(31)], {growth}),
    manyBombs(),
  ];
};

const framingAttacks = () => [
  once('1,000,000 header fields', () =>
    bytes.follow('GET /version HTTP/1.1\r\nHost: soak\r\n', bytes.endless('X-A: 1\r\n', 8e6))),
  shots('Content-Length and Transfer-Encoding', [() => Buffer.from(
    `${kTwice}Content-Length: 5\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n\r\n`)]),
  shots('two lengths', [['5', '6'], ['5', '5'], ['5, 6'], ['+5'], ['0x5'], ['-1'], ['5 5']].map((lengths) => () =>
    Buffer.from(`${kTwice}${lengths.map((length) => `Content-Length: ${length}\r\n`).join('')}\r\nhello`))),
  shots('chunk size -2, and others', ['-2', '10000000000000000', 'x', '', ' 2', '+2', '0x2'].map((size) => () =>
    Buffer.from(`${bytes.chunkedHead('/v1/regularize')}${size}\r\nab\r\n0\r\n\r\n`))),
  once('chunk size 2^64 - 2', () =>
    Buffer.from(`${bytes.chunkedHead('/v1/regularize')}FFFFFFFFFFFFFFFE\r\nab\r\n0\r\n\r\n`)),
  ...[
    ['request line', () => bytes.follow('GET /', bytes.endless('a', kEndless))],
    ['header line', () => bytes.follow('GET / HTTP/1.1\r\nHost: soak\r\nX-A: ', bytes.endless('a', kEndless))],
    ['line of a chunk size', () =>
      bytes.follow(`${bytes.chunkedHead('/v1/regularize')}1;`, bytes.endless('a', kEndless))],
    ['trailers', () => bytes.follow(`${bytes.chunkedHead('/v1/regularize')}1\r\na\r\n0\r\n`,
      bytes.endless('X-A: 1\r\n', kEndless))],
  ].map(([what, make]) => once(`endless ${what}`, make, {check: boundless})),
  once('endless body in chunks', () =>
    bytes.follow(bytes.chunkedHead('/v1/regularize'), bytes.chunks(bytes.endless('a', kEndless))),
  {check: boundless, growth: kMaxUpload + kSlack}),
];

// A header of the answer that the client has made up.
const injected = ({head}) => /^set-cookie|^x-evil/im.test(head) ? 'it has a header of the attacker' : '';

const fieldAttacks = () => [
  shots('2,000 ranges', [(result) => bytes.get(result, {Range: `bytes=${Array(2000).fill('0-').join(',')}`}),
    (result) => bytes.get(result, {Range: `bytes=${Array.from({length: 2000}, (_, i) => `${i}-${i}`).join(',')}`})],
  {prepare: smallResult}),
  shots('CR or LF in a header value', ['a\nX-Evil: 1', 'a\rX-Evil: 1', 'a\0b', 'a\r\n\tX-Evil: 1'].map((value) => () =>
    bytes.get('/version', {'X-Request-ID': value})), {check: injected}),
  shots('CRLF in percent-coding', [
    () => bytes.get('/v1/jobs?state=a%0d%0aX-Evil:%201'), () => bytes.get('/v1/jobs/a%0d%0aX-Evil:%201'),
    () => bytes.get('/%0d%0aSet-Cookie:%20a=b')], {check: injected}),
  shots('options of 65,000 nested lists', [() => bytes.deepOptions(65000)]),
  shots('options of 200,000 nested lists', [() => bytes.deepOptions(200000)]),
  shots('form of 100,000 parts', [() => bytes.manyParts(100000)]),
  once('form with a part header of 100 MB', () => bytes.endlessPart(100e6)),
  shots('form with a part without end', [bytes.openPart]),
];

const stolen = ({received}) => /root:.*:0:0:/.test(received) ? 'it shows a file of the machine' : '';

const targetAttacks = () => [
  shots('paths that lead elsewhere', bytes.kPaths.map((path) => () => bytes.get(path)), {times: 1, check: stolen}),
  shots('.vox of 2048^3 with two voxels', [() => bytes.hugeVox()], {allow: [200]}),
  shots('.vox that claims 2^31 - 1 voxels', [() => bytes.hugeVox(0x7fffffff)]),
  shots('.vox: one voxel at two places, 2047 apart', [() => bytes.distantVox(2047)],
    {allow: [200], growth: kPredicted}),
  shots('.vox: one voxel at two places, 10^9 apart', [() => bytes.distantVox(1e9)]),
  shots('.npy of 2048^3 with 8 bytes', [bytes.hugeNpy]),
  shots('raw grid of 2048^3 with 8 bytes', [bytes.hugeRaw]),
];

// seconds: the limits of slow clients, where the server lets them be set
export const attacks = (seconds) => [...slowAttacks(seconds), ...packedAttacks(), ...framingAttacks(),
  ...fieldAttacks(), ...targetAttacks()].map((attack) => ({growth: kSlack, allow: [], ...attack}));
