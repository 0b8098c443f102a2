// Networks that are slow or cut, and nginx with TLS in front.
import assert from 'node:assert/strict';
import {must, sleep, until} from '../lib/docker.mjs';
import {image} from '../lib/images.mjs';



export default [
  {
    name: 'network: 100 ms late, 5 % of the packets lost: slow, but all of it',
    fault: 'all packets lost',
    async run(world, broken) {
      const server = await world.server();
      const grid = await world.sample();
      await server.network(broken ? 'loss 100%' : 'delay 100ms 20ms loss 5%');
      const {code, errors} = await world.client(['--timeout', broken ? '10' : '100', 'regularize', '-', '-o', '-'],
        {input: grid});
      assert.equal(code, 0, `exit code ${code}: ${errors}`);
    },
  },
  {
    name: 'network: cut for five seconds in the middle of a job: the client goes on',
    fault: 'it stays cut',
    async run(world, broken) {
      const server = await world.server();
      const grid = await world.sample();
      await server.network('delay 300ms');
      const client = world.client(['--timeout', broken ? '15' : '60', 'regularize', '-', '-o', '-'], {input: grid});
      await until(async () => (await server.log()).some(({event}) => event === 'request'), 'a request of the client');
      await server.network('loss 100%');
      await sleep(5000);
      if (!broken) await server.network();
      const {code, errors} = await client;
      assert.equal(code, 0, `exit code ${code}: ${errors}`);
    },
  },
  {
    name: 'network: the server leaves it for two seconds and comes back: the client goes on',
    fault: 'it does not come back',
    async run(world, broken) {
      const server = await world.server();
      const grid = await world.sample();
      await server.network('delay 300ms');
      const client = world.client(['--timeout', broken ? '15' : '60', 'regularize', '-', '-o', '-'], {input: grid});
      await until(async () => (await server.log()).some(({event}) => event === 'request'), 'a request of the client');
      await must(['network', 'disconnect', world.id, server.name]);
      await sleep(2000);
      if (!broken) await must(['network', 'connect', '--alias', 'server', world.id, server.name]);
      const {code, errors} = await client;
      assert.equal(code, 0, `exit code ${code}: ${errors}`);
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
