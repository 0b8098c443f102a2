// Networks that are slow or cut, and nginx with TLS in front.
import assert from 'node:assert/strict';
import {must, sleep, until} from '../lib/docker.mjs';
import {readGlb} from '../lib/glb.mjs';
import {image} from '../lib/images.mjs';



// Starts a conversion over a slow link, and waits until the server has done its job: the result, of
// 100 kB at least, is on its way.
async function convertSlowly(world, server, seconds, rate = '64kbit') {
  const grid = await world.sample();
  await server.slow(rate);
  const client = world.client(['--timeout', String(seconds), 'regularize', '-', '-o', '-'], {input: grid});
  await until(async () => (await server.log()).some(({event}) => event === 'job'), 'a job', seconds * 1000);
  const converted = {client, over: false};
  client.then(() => { converted.over = true; });
  return converted;
}

// The client got all of it.
async function checkWhole({client}) {
  const {code, out, errors} = await client;
  assert.equal(code, 0, `exit code ${code}: ${errors}`);
  assert.ok(readGlb(out).triangles > 1000);
}

export default [
  {
    name: 'network: 512 kbit/s, 5 % of the packets lost in each direction: slow, but all of it',
    fault: 'all packets lost',
    async run(world, broken) {
      const server = await world.server();
      const converted = await convertSlowly(world, server, broken ? 15 : 100, broken ? '64kbit' : '512kbit');
      if (broken) await server.cut();
      await checkWhole(converted);
    },
  },
  {
    name: 'network: cut for five seconds while a result comes: the client goes on',
    fault: 'it stays cut',
    async run(world, broken) {
      const server = await world.server();
      const converted = await convertSlowly(world, server, broken ? 15 : 100);
      await server.cut();
      assert.ok(!converted.over, 'cut in the middle');
      await sleep(5000);
      if (!broken) await server.mend();
      await checkWhole(converted);
    },
  },
  {
    name: 'network: the server leaves it for two seconds and comes back: the client goes on',
    fault: 'it does not come back',
    async run(world, broken) {
      const server = await world.server();
      const converted = await convertSlowly(world, server, broken ? 15 : 100);
      await must(['network', 'disconnect', world.id, server.name]);
      assert.ok(!converted.over, 'gone in the middle');
      await sleep(2000);
      if (!broken) await must(['network', 'connect', '--alias', 'server', world.id, server.name]);
      await checkWhole(converted);
    },
  },
  {
    name: 'nginx with TLS, as docker/README.md has it: jobs, events at once, large bodies, who asks',
    fault: 'a configuration that buffers, and takes 1 MB',
    async run(world, broken) {
      const proxy = world.name();
      await must(['create', '--name', proxy, '--network', world.id, '--network-alias', 'proxy', ...world.all.flags,
        image('nginx'), ...(broken ? ['bash', '-c',
          "sed -i 's/80m/1m/; s/proxy_buffering         off/proxy_buffering on/' /etc/nginx/nginx.conf; exec nginx -g 'daemon off;'"] : [])]);
      const server = await world.server({alias: 'rivage'});
      await must(['start', proxy]);
      const address = (await must(['inspect', '--format', `{{(index .NetworkSettings.Networks "${world.id}").IPAddress}}`, proxy])).text;
      await must(['rm', '-f', '-v', server.name]);
      const trusting = await world.server({alias: 'rivage', env: {RIVAGE_TRUSTED_PROXY: address}});
      await must(['restart', '--time', '1', proxy]);
      const certificate = (await must(['exec', proxy, 'cat', '/etc/nginx/tls/cert.pem'])).text;
      const found = await world.ask('proxied', {host: 'proxy', port: 8443, certificate});
      assert.equal(found.protocol, 'TLSv1.3');
      assert.equal(found.result, 'glTF');
      assert.equal(found.tooLarge, '/problems/too-large', 'the server\'s own words');
      assert.equal(found.large, 202, 'a body of 8 MB');
      assert.ok(found.eventsBeforeTheEnd > 1, `${found.eventsBeforeTheEnd} events before the end`);
      const asked = (await trusting.log()).filter(({event, route}) => event === 'request' && route === '/v1/jobs');
      assert.ok(asked.length && asked.every(({client}) => client === found.address), JSON.stringify(asked[0]));
    },
  },
];
