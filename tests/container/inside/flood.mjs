// Runs in the network of the test: asks for as much memory as the server lets anybody have, all at
// once: conversions just below the limit on all workers, and the largest uploads beside them.
import http from 'node:http';
import {setTimeout as sleep} from 'node:timers/promises';

const {url, seconds} = JSON.parse(process.env.ARGUMENT);
const found = {statuses: {}, states: {}, problems: []};
const note = (into, what) => { found[into][what] = (found[into][what] ?? 0) + 1; };

function ask(path, {method = 'GET', body, slowly} = {}) {
  return new Promise((done, fail) => {
    const headers = body ? {'Content-Length': body.length} : {};
    const request = http.request(url + path, {method, headers, agent: false}, (answer) => {
      const chunks = [];
      answer.on('data', (chunk) => chunks.push(chunk)).on('error', fail);
      answer.on('end', () => done({status: answer.statusCode, headers: answer.headers, body: Buffer.concat(chunks)}));
    });
    request.on('error', fail);
    if (!slowly) return request.end(body);
    request.write(body.subarray(0, body.length - 1));
    setTimeout(() => request.end(body.subarray(body.length - 1)), slowly);
  });
}

// Hills without plains, of `size` squared columns, and how many surfels they have.
function hills(size, seed) {
  const height = 12;
  const grid = Buffer.alloc(size * size * height);
  const heights = new Uint8Array(size * size);
  for (let i = 0, state = seed; i < heights.length; ++i) {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    heights[i] = 1 + (state >>> 28) % height;
    for (let z = 0; z < heights[i]; ++z) grid[z * size * size + i] = 1 + z % 3;
  }
  return grid;
}
const query = (size) => `/v1/jobs?format=raw&dims=${size}x${size}x12`;

async function ended(path) {
  for (;; await sleep(100)) {
    const job = JSON.parse((await ask(path)).body);
    if (!['queued', 'running'].includes(job.state)) return job;
  }
}
async function convert(size, seed) {
  const answer = await ask(query(size), {method: 'POST', body: hills(size, seed)});
  note('statuses', answer.status);
  if (answer.status !== 202) return {state: 'refused'};
  return ended(answer.headers.location);
}

// What is above the limit is refused before it starts, and says so; the largest that is not.
found.refusal = (await convert(1200, 1)).error;
let low = 10;
for (let high = 1200; high - low > 4;) {
  const middle = low + high >> 1;
  const {body} = await ask(query(middle).replace('jobs', 'inspect'), {method: 'POST', body: hills(middle, 2)});
  JSON.parse(body).predicted_memory <= found.refusal.limit ? low = middle : high = middle;
}
found.size = low;

const limit = Date.now() + seconds * 1000;
const large = Buffer.alloc((64 << 20) - 1000, 1);
await Promise.all([
  ...[1, 2, 3, 4].map(async (loop) => {
    for (let i = 0; Date.now() < limit; ++i) {
      const job = await convert(low, 100 * loop + i);
      note('states', job.state);
      if (job.state === 'failed') found.problems.push(job.error.type);
      if (job.state === 'refused') await sleep(200);
    }
  }),
  ...[1, 2, 3, 4].map(async () => {
    while (Date.now() < limit) {
      const {status} = await ask('/v1/jobs?format=raw&dims=4x4x4', {method: 'POST', body: large, slowly: 3000})
        .catch(() => ({status: 'broken'}));
      note('statuses', status);
      await sleep(200);
    }
  }),
]);
console.log(JSON.stringify(found));
