// Runs in the network of the test: posts jobs for some time, or says what became of them.
import http from 'node:http';
import {setTimeout as sleep} from 'node:timers/promises';

const {url, post, check, patience = 60000} = JSON.parse(process.env.ARGUMENT);

function ask(path, {method = 'GET', body} = {}) {
  return new Promise((done, fail) => {
    let answered = false;
    const broken = (error) => fail(Object.assign(error, {answered}));
    const headers = body ? {'Content-Type': 'application/octet-stream'} : {};
    const request = http.request(url + path, {method, headers, agent: false, timeout: 30000}, (answer) => {
      answered = true;
      const chunks = [];
      answer.on('data', (chunk) => chunks.push(chunk)).on('error', broken);
      answer.on('end', () => done({status: answer.statusCode, headers: answer.headers, body: Buffer.concat(chunks)}));
    });
    request.on('timeout', () => request.destroy(new Error('no answer in time'))).on('error', broken);
    request.end(body);
  });
}

// A grid that nobody has sent before.
function grid(size, seed) {
  const bytes = Buffer.alloc(size ** 3, 1);
  for (let i = 0, state = seed; i < 64; ++i) {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    bytes[state % bytes.length] = 0;
  }
  return bytes;
}

// Some loops that post one job after the other. Accepted ids; how many were refused, by status; posts
// without any answer, and answers that broke off.
async function load({milliseconds, size = 20, loops = 4, pause = 40}) {
  const found = {accepted: [], refused: {}, broken: 0, torn: 0};
  const limit = Date.now() + milliseconds;
  await Promise.all(Array.from({length: loops}, async (_, loop) => {
    for (let i = 0; Date.now() < limit; ++i, await sleep(pause)) {
      try {
        const answer = await ask(`/v1/jobs?format=raw&dims=${size}x${size}x${size}`,
          {method: 'POST', body: grid(size, (Date.now() * 31 + loop * 7919 + i) >>> 0)});
        if (answer.status === 202) found.accepted.push(answer.headers.location);
        else found.refused[answer.status] = (found.refused[answer.status] ?? 0) + 1;
      } catch (error) {
        ++found[error.answered ? 'torn' : 'broken'];
      }
    }
  }));
  return found;
}

// Waits until each has ended. @return how many are in which state, and what is wrong with a result
async function states(paths) {
  const found = {};
  const note = (what) => { found[what] = (found[what] ?? 0) + 1; };
  const limit = Date.now() + patience;
  for (const path of paths) {
    let answer = await ask(path);
    while (answer.status === 200 && ['queued', 'running'].includes(JSON.parse(answer.body).state) && Date.now() < limit) {
      await sleep(50);
      answer = await ask(path);
    }
    if (answer.status !== 200) { note(`status ${answer.status}`); continue; }
    const {state} = JSON.parse(answer.body);
    note(state);
    if (state !== 'succeeded') continue;
    const result = await ask(`${path}/result`);
    if (result.status !== 200 || result.body.toString('latin1', 0, 4) !== 'glTF') note('broken result');
  }
  return found;
}

console.log(JSON.stringify(post ? await load(post) : await states(check)));
