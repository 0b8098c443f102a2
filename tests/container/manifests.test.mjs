// The files in docker/ against the schemas of those who read them, against each other, and against the
// server: RIVAGE_SERVER_PROGRAM names the program. Each check is also given a file with a mistake.
import assert from 'node:assert/strict';
import {spawnSync} from 'node:child_process';
import {mkdtempSync, rmSync} from 'node:fs';
import {tmpdir} from 'node:os';
import {join} from 'node:path';
import {describe, test} from 'node:test';
import {
  compose, composeMistakes, dockerfile, kubernetesMistakes, manifests, podOf, seconds, text,
} from './lib/manifests.mjs';

const program = process.env.RIVAGE_SERVER_PROGRAM;
assert.ok(program, 'RIVAGE_SERVER_PROGRAM names the program');

// What the server makes of an environment; a state folder is made where the test may.
function configuration(env) {
  const folder = mkdtempSync(join(tmpdir(), 'rivage-manifests-'));
  const changed = 'RIVAGE_STATE_DIR' in env ? {...env, RIVAGE_STATE_DIR: folder} : env;
  const {status, stdout, stderr} = spawnSync(program, ['--print-config'],
    {encoding: 'utf8', env: {PATH: process.env.PATH, ...changed}});
  rmSync(folder, {recursive: true});
  assert.equal(status, 0, stderr);
  return Object.fromEntries([...stdout.matchAll(/^([a-z-]+)="?([^"\n]*)"?$/gm)].map((m) => m.slice(1)));
}

describe('kubernetes', () => {
  test('every manifest is what Kubernetes takes', () =>
    assert.deepEqual(kubernetesMistakes(manifests()), []));

  const refused = {
    'a name that no type has': [/readynessProbe/, ({container}) => { container.readynessProbe = {}; }],
    'a name deep inside': [/readOnlyRootFileSystem/,
      ({container}) => { container.securityContext.readOnlyRootFileSystem = true; }],
    'a text for a number': [/'number'/, ({pod}) => { pod.spec.terminationGracePeriodSeconds = '40s'; }],
    'no name of a container': [/required property name/, ({container}) => { delete container.name; }],
    'a number for a text': [/'string'/, ({container}) => { container.env[0].value = 5; }],
  };
  for (const [what, [words, change]] of Object.entries(refused))
    test(`refused: ${what}`, () => {
      const objects = manifests();
      change(podOf(objects));
      assert.match(kubernetesMistakes(objects).join('\n'), words);
    });

  test('the selectors find the pods, and the names what they mean', () => {
    const objects = manifests();
    const {labels} = podOf(objects).pod.metadata;
    const found = [objects['deployment.yaml'].spec.selector.matchLabels,
      objects['disruption-budget.yaml'].spec.selector.matchLabels, objects['service.yaml'].spec.selector];
    for (const selector of found)
      for (const [name, value] of Object.entries(selector)) assert.equal(labels[name], value);
    const target = objects['autoscaler.yaml'].spec.scaleTargetRef;
    assert.equal(target.kind, objects['deployment.yaml'].kind);
    assert.equal(target.name, objects['deployment.yaml'].metadata.name);
  });

  test('ports are those of the image, probes ask routes of the admin port', () => {
    const objects = manifests();
    const {container} = podOf(objects);
    const ports = Object.fromEntries(container.ports.map((port) => [port.name, port.containerPort]));
    assert.deepEqual(Object.values(ports).sort(), dockerfile().ports);
    assert.equal(objects['service.yaml'].spec.ports[0].targetPort, 'http');
    const {paths} = JSON.parse(text('proto/openapi.yaml'));
    for (const probe of ['startupProbe', 'livenessProbe', 'readinessProbe']) {
      const {path, port} = container[probe].httpGet;
      assert.equal(port, 'admin');
      assert.deepEqual(paths[path]?.get.tags, ['admin'], path);
    }
  });

  test('the grace period is the drain and five seconds', () => {
    const {pod, env} = podOf(manifests());
    const {'drain-delay': delay, 'drain-timeout': timeout} = configuration(env);
    assert.equal(pod.spec.terminationGracePeriodSeconds, seconds(delay) + seconds(timeout) + 5);
  });

  test('the state folder of the image is a volume, and the user is the same', () => {
    const {pod, container} = podOf(manifests());
    const [mount] = container.volumeMounts;
    assert.equal(mount.mountPath, dockerfile().volume);
    assert.ok(pod.spec.volumes.some(({name}) => name === mount.name));
    const {runAsUser, runAsGroup} = pod.spec.securityContext;
    assert.deepEqual(dockerfile().users, Array(2).fill(`${runAsUser}:${runAsGroup}`));
  });
});

describe('compose', () => {
  test('the file is what the specification allows', () => assert.deepEqual(composeMistakes(compose()), []));

  for (const [what, change] of Object.entries({
    'a name that no service has': [/mem_limits/, (service) => { service.mem_limits = '1g'; }],
    'a list for a text': [/stop_grace_period/, (service) => { service.stop_grace_period = [35]; }],
  }))
    test(`refused: ${what}`, () => {
      const document = compose();
      change[1](document.services.rivage);
      assert.match(composeMistakes(document).join('\n'), change[0]);
    });

  test('it agrees with the image', () => {
    const {services: {rivage}} = compose();
    const image = dockerfile();
    assert.deepEqual(rivage.healthcheck.test, ['CMD', ...image.health]);
    assert.equal(rivage.ports[0].split(':').at(-1), String(image.ports[0]));
    assert.equal(rivage.volumes[0].split(':')[1], image.volume);
    assert.equal(rivage.user, image.users[0]);
    const {'drain-delay': delay, 'drain-timeout': timeout} = configuration(rivage.environment);
    assert.equal(seconds(rivage.stop_grace_period), seconds(delay) + seconds(timeout) + 5);
  });
});

describe('the image', () => {
  test('its settings are settings of the server', () => {
    const config = configuration(dockerfile().env);
    const [port, admin] = dockerfile().ports;
    assert.equal(config.listen, `0.0.0.0:${port}`);
    assert.equal(config['admin-listen'], `0.0.0.0:${admin}`);
    assert.equal(config['log-format'], 'json');
  });

  test('a setting that is none ends the server', () =>
    assert.throws(() => configuration({RIVAGE_DRAIN_TIMEOUTS: '30s'}), /is no setting/));

  test('programs start as such, and stop by SIGTERM', () => {
    const image = dockerfile();
    assert.deepEqual(image.entry, ['/usr/bin/rivage-server', '/usr/bin/rivage']);
    assert.deepEqual(image.stop, ['SIGTERM']);
    assert.equal(image.health[0], image.entry[0]);
  });
});

describe('nginx and the words', () => {
  test('nginx waits longer and takes more than the server', () => {
    const {deadline, 'max-upload': upload} = configuration({});
    const file = text('docker/nginx.conf');
    const value = (name) => new RegExp(`${name}\\s+(\\S+);`).exec(file)[1];
    assert.ok(seconds(value('proxy_read_timeout')) > seconds(deadline));
    assert.ok(Number.parseInt(value('client_max_body_size'), 10) * 2 ** 20 > Number(upload));
  });

  test('every setting that is named is one', () => {
    const {stdout} = spawnSync(program, ['--help'], {encoding: 'utf8'});
    for (const file of ['docker/README.md', 'docker/nginx.conf', 'docker/compose.yaml']) {
      for (const [name] of text(file).matchAll(/\bRIVAGE_[A-Z_]+/g)) assert.ok(stdout.includes(name), name);
    }
  });
});
