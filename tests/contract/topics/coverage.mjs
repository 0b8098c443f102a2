// What the topics before have seen: every status of every operation, and every type of problem.
import assert from 'node:assert/strict';
import {describe, test} from 'node:test';
import {coverage, generalStatuses, methodsOf, schema} from '../lib/schema.mjs';

const isRoot = process.getuid() === 0;

// What no test can bring about from outside, and why.
const kUnseen = {
  'POST /v1/inspect 409': 'an inspection is no job that another request could cancel',
  'GET /livez 503': 'a stuck loop or worker needs a broken program; tests/server/http has it',
  'GET /startupz 503': 'the port answers for a moment only before the start has ended',
};
const kUnseenProblems = {
  'not-converged': 'no solver gives up on what a client can send in the time of a test',
  'output-too-large': 'needs more than 2^32 vertices or a file of 4 GiB',
};
// Without root there is no full disk.
const kRootOnly = (name) => !isRoot && (name.endsWith(' 507') || name === 'storage-full');

const unless = (exceptions) => (name) => !exceptions[name] && !kRootOnly(name);

describe('coverage', () => {
  test('every documented status of every operation has been seen', () => {
    const documented = Object.keys(schema.paths).flatMap((route) =>
      methodsOf(route).flatMap((method) =>
        Object.keys(schema.paths[route][method.toLowerCase()].responses)
          .filter((status) => status !== 'default')
          .map((status) => `${method} ${route} ${status}`)
      )
    );
    assert.deepEqual(
      documented.filter((name) => !coverage.seen.has(name)).filter(unless(kUnseen)),
      []
    );
  });

  test('every status that any request may get has been seen', () =>
    assert.deepEqual(
      generalStatuses.filter((status) => !coverage.seen.has(`any ${status}`)),
      []
    ));

  test('every type of problem has been seen', () => {
    const types = schema.components.schemas.Problem.properties.type.enum.map((type) =>
      type.split('/').pop()
    );
    assert.deepEqual(
      types.filter((type) => !coverage.problems.has(type)).filter(unless(kUnseenProblems)),
      []
    );
  });

  test('no exception is out of date', () => {
    for (const name of Object.keys(kUnseen)) assert.ok(!coverage.seen.has(name), name);
    for (const name of Object.keys(kUnseenProblems)) assert.ok(!coverage.problems.has(name), name);
  });
});
