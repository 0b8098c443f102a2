// Runs in the network of the test: brings about every type of problem, over real sockets.
import {Connection, requestBytes} from './tests/contract/lib/http.mjs';
import {setTimeout as sleep} from 'node:timers/promises';

const {host, tiny, keyed, keys, part} = JSON.parse(process.env.ARGUMENT);
const seen = {};

async function raw(bytes, at = host, method = 'GET') {
  const connection = await Connection.open({host: at, port: 8080});
  connection.send(bytes);
  const answer = await connection.answer(method);
  connection.close();
  return note(answer);
}

function note(answer) {
  if (answer.status >= 400) {
    const problem = JSON.parse(answer.body.toString());
    seen[problem.type.split('/').pop()] = {status: answer.status, ...problem};
  }
  return answer;
}

const ask = (method, target, {body, headers = {}, at = host} = {}) =>
  raw(requestBytes(method, target, {body, headers: Object.entries(headers)}), at, method);
const post = (query, body, options) => ask('POST', `/v1/jobs${query}`, {body, ...options});
const jsonOf = (answer) => JSON.parse(answer.body.toString());
const raws = (size) => `?format=raw&dims=${size}x${size}x${size}&compression=none`;

// Voxels that touch no other: as many surfels as there can be, and a job of some seconds.
function checkered(size, seed) {
  const grid = Buffer.alloc(size ** 3);
  for (let i = 0; i < grid.length; ++i)
    grid[i] = (i + Math.floor(i / size) + Math.floor(i / size / size)) % 2;
  grid[0] = 1 + seed % 200;
  return grid;
}
const cube = Buffer.alloc(8, 1);

async function submitted(query, body, options) {
  const answer = await post(query, body, options);
  if (answer.status !== 202) throw new Error(`${query}: ${answer.status} ${answer.body}`);
  return answer.headers.location;
}
async function ended(path, at = host) {
  for (;;) {
    const answer = await ask('GET', path, {at});
    if (!['queued', 'running'].includes(jsonOf(answer).state)) return answer;
    await sleep(20);
  }
}
// A job that is to fail, if it is accepted at all.
async function failed(query, body, at = host) {
  const {status, headers} = await post(query, body, {at});
  if (status !== 202) return;
  await ended(headers.location, at);
  await ask('GET', `${headers.location}/result`, {at});
}

const parts = {
  async grids() {
    await failed('?format=vox', Buffer.from('VOX no'));
    await failed('', Buffer.from('what is this'));
    await failed(raws(2), Buffer.alloc(8));
    await failed('?format=raw&dims=3x2x2', Buffer.from([1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12]));
    await post('', Buffer.alloc(1 << 21));
    await failed(raws(80), checkered(80, 1), tiny);
  },
  async requests() {
    await post('?colour=red', cube);
    await post('?alpha=much', cube);
    await post('', Buffer.alloc(0));
    await ask('GET', '/v1/nothing');
    await ask('PUT', '/v1/jobs');
    await post(raws(2), cube, {headers: {'Content-Encoding': 'br'}});
    await post(raws(2), cube, {headers: {'Content-Digest': `sha-256=:${Buffer.alloc(32).toString('base64')}:`}});
    await ask('GET', '/version', {headers: {Expect: 'a miracle'}});
    await raw(`GET /${'x'.repeat(10000)} HTTP/1.1\r\nHost: x\r\n\r\n`);
    await raw(`GET / HTTP/1.1\r\nHost: x\r\nX-Long: ${'y'.repeat(20000)}\r\n\r\n`);
    await raw('GET / HTTP/1.1\r\nHost: x\r\nX-');
  },
  async results() {
    const path = await submitted(raws(2), cube);
    await ended(path);
    await ask('GET', `${path}/result`, {headers: {Range: 'bytes=99999999-'}});
    await sleep(2500);
    await ask('GET', path);
  },
  async idempotency() {
    const key = {'Idempotency-Key': '"one"'};
    await post(raws(2), cube, {headers: key});
    await post(raws(2), Buffer.alloc(8, 2), {headers: key});
    // The second may overtake the first between its 100 and its first byte: then with another key.
    for (let i = 0; i < 20 && !seen['idempotency-in-progress']; ++i) {
      const name = {'Idempotency-Key': `"two-${i}"`};
      const connection = await Connection.open({host, port: 8080});
      connection.send(requestBytes('POST', `/v1/jobs${raws(2)}`,
        {headers: {...name, 'Content-Length': '8', Expect: '100-continue'}}));
      await connection.anyHead();
      connection.send(cube.subarray(0, 5));
      await post(raws(2), cube, {headers: name});
      connection.close();
    }
  },
  async load() {
    const long = await Promise.all([1, 2].map((seed) => submitted(raws(64), checkered(64, seed))));
    await post(raws(64), checkered(64, 3));
    await ask('DELETE', long[1]);
    await ask('GET', `${long[1]}/result`);
    await ask('DELETE', long[0]);
    await failed(`${raws(64)}&deadline_ms=1`, checkered(64, 4));
  },
  async keys() {
    await ask('GET', '/v1/jobs', {at: keyed});
    const as = (name) => ({at: keyed, headers: {Authorization: `Bearer ${keys[name]}`}});
    await ask('GET', '/v1/jobs', as('off'));
    for (let i = 0; i < 3; ++i) await ask('GET', '/v1/jobs', as('few'));
  },
  async storage() {
    for (let i = 0, status = 202; i < 30 && status === 202; ++i)
      ({status} = await post(raws(60), Buffer.alloc(60 ** 3, 1 + i), {at: tiny}));
  },
  // The driver kills the server twice while this grid runs; or stops it while another does.
  async long() { seen.path = await submitted(raws(80), checkered(80, 77)); },
  async poison() { await post(raws(80), checkered(80, 77)); },
  async draining() {
    for (let i = 0; i < 200 && !seen.draining; ++i, await sleep(20))
      await post(raws(2), cube).catch(() => {});
  },
  async catalogue() {
    const {components} = jsonOf(await ask('GET', '/openapi.json'));
    seen.types = components.schemas.Problem.properties.type.enum.map((type) => type.split('/').pop());
  },
};

for (const name of part) await parts[name]();
console.log(JSON.stringify(seen));
