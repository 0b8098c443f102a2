// Restarts the whole server by SIGTERM while jobs and synchronous requests come in. Promises: it
// ends with 0, every job whose 202 arrived ends with its result, no answer breaks off.
import {
  Load, Server, checkFolder, checkJobs, expectedResult, main, makeFolder, post, random, removeFolder, sleep,
} from './support.mjs';

// Synchronous requests, each on a connection of its own, until it is stopped.
class Converters {
  constructor(getServer) {
    this.answered = 0;
    this.notTaken = 0;  // no byte of an answer: sent while nobody listened, or refused with 503
    this.problems = [];
    this.running = true;
    this.loops = [0, 1].map((i) => this.#convert(getServer, i));
  }

  async #convert(getServer, converter) {
    for (let i = 0; this.running; ++i) {
      const text = `hold:20 sync ${converter}-${i}`;
      try {
        const {status, body} = await post(getServer(), '/v1/regularize', text);
        if (status === 503) ++this.notTaken;
        else if (status === 200 && body.equals(expectedResult(text))) ++this.answered;
        else this.problems.push(`${text} answers ${status} ${body}`);
      } catch (error) {
        ++this.notTaken;
        if (error.answered) this.problems.push(`the answer to ${text} broke off: ${error.message}`);
      }
      await sleep(5);
    }
  }

  async stop() {
    this.running = false;
    await Promise.all(this.loops);
  }
}

export async function drive(build, times = 20) {
  const folder = makeFolder();
  const chance = random(2);
  let server = await new Server(build, folder).started();
  const load = new Load(() => server,
    {makeText: (name) => `hold:${Math.floor(100 * chance())} ${name}`, pause: 120});
  const converters = new Converters(() => server);
  const problems = [];
  let longest = 0;
  for (let i = 0; i < times; ++i) {
    await sleep(300 + 300 * chance());
    const since = performance.now();
    const code = await server.stop();
    longest = Math.max(longest, performance.now() - since);
    if (code !== 0) problems.push(`stop ${i} ends with ${code}:\n${server.log.slice(-500)}`);
    server = await new Server(build, folder, [], server.url.replace('http://', '')).started();
  }
  await Promise.all([load.stop(), converters.stop()]);
  const count = await checkJobs(server, load.accepted);
  problems.push(...count.problems, ...converters.problems);
  if (load.torn) problems.push(`${load.torn} answers broke off`);
  await server.stop();
  problems.push(...checkFolder(build, folder));
  removeFolder(folder);
  return {problems, figures: {
    'restarts': times, 'jobs accepted': load.accepted.size, 'succeeded': count.succeeded,
    'synchronous requests answered': converters.answered, 'not taken': converters.notTaken,
    'ms from SIGTERM to the end, most': longest.toFixed(0),
  }};
}

await main(import.meta.url, 'sigterm', drive);
