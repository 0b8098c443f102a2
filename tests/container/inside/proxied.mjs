// Runs in the network of the test: asks a server behind a proxy with TLS.
import https from 'node:https';
import {networkInterfaces} from 'node:os';

const {host, port, certificate} = JSON.parse(process.env.ARGUMENT);
const found = {address: Object.values(networkInterfaces()).flat().find(({internal}) => !internal).address};

function open(path, {method = 'GET', headers = {}, body} = {}) {
  return new Promise((done, fail) => {
    const request = https.request({host, port, path, method, ca: certificate, agent: false,
      headers: {...headers, ...(body ? {'Content-Length': body.length} : {})}}, done);
    request.on('error', fail);
    request.end(body);
  });
}

async function ask(path, options) {
  const answer = await open(path, options);
  found.protocol = answer.socket.getProtocol();
  const chunks = [];
  for await (const chunk of answer) chunks.push(chunk);
  return {status: answer.statusCode, headers: answer.headers, body: Buffer.concat(chunks)};
}

// The time at which each event comes, up to the end of the job.
async function events(path) {
  const times = [];
  for await (const chunk of await open(path))
    for (const line of chunk.toString().split('\n')) if (line.startsWith('event:')) times.push(Date.now());
  return times;
}

// Voxels that touch no other: a job of some seconds.
const size = 56;
const checkered = Buffer.alloc(size ** 3);
for (let i = 0; i < checkered.length; ++i)
  checkered[i] = (i + Math.floor(i / size) + Math.floor(i / size / size)) % 2;

const job = await ask(`/v1/jobs?format=raw&dims=${size}x${size}x${size}`, {method: 'POST', body: checkered});
const path = job.headers.location;
const times = await events(`${path}/events`);
const last = times.at(-1);
found.eventsBeforeTheEnd = times.filter((time) => last - time > 300).length;
found.result = (await ask(`${path}/result`)).body.toString('latin1', 0, 4);
found.large = (await ask('/v1/jobs?format=raw&dims=200x200x200', {method: 'POST', body: Buffer.alloc(200 ** 3, 1)})).status;
const tooLarge = await ask('/v1/jobs', {method: 'POST', body: Buffer.alloc(70 << 20)}).catch((error) => ({body: `{"type": "${error.code}"}`}));
found.tooLarge = tooLarge.headers?.['content-type'] === 'application/problem+json'
  ? JSON.parse(tooLarge.body).type : tooLarge.body.toString().slice(0, 200);
console.log(JSON.stringify(found));
