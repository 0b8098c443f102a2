// The schema itself: whole, without loose ends, and the one that is served.
import assert from 'node:assert/strict';
import {describe, test} from 'node:test';
import {resolve, schema, validate} from '../lib/schema.mjs';
import {useFakeServer} from '../lib/server.mjs';

function* references(value) {
  if (!value || typeof value !== 'object') return;
  for (const [name, inner] of Object.entries(value))
    if (name === '$ref' && typeof inner === 'string') yield inner;
    else yield* references(inner);
}

const operations = Object.entries(schema.paths).flatMap(([path, item]) =>
  Object.entries(item)
    .filter(([, operation]) => operation.responses)
    .map(([method, operation]) => ({path, method, ...operation}))
);

describe('document', () => {
  const server = useFakeServer();

  test('every reference leads somewhere, and everything is referred to', () => {
    const used = new Set(references(schema));
    for (const reference of used) resolve(reference);
    const idle = Object.entries(schema.components)
      .filter(([kind]) => kind !== 'securitySchemes')
      .flatMap(([kind, group]) => Object.keys(group).map((name) => `#/components/${kind}/${name}`))
      .filter((name) => !used.has(name));
    assert.deepEqual(
      idle,
      [
        '#/components/responses/Options',
        '#/components/schemas/EventProgress',
        '#/components/schemas/EventPreview',
      ],
      'only what the tests and the texts refer to'
    );
  });

  test('every schema compiles', () => {
    for (const name of Object.keys(schema.components.schemas))
      assert.throws(
        () => validate(`#/components/schemas/${name}`, Symbol.iterator, name),
        assert.AssertionError
      );
  });

  test('operations have ids of their own, and the parameters of their path', () => {
    const ids = operations.map(({operationId}) => operationId);
    assert.equal(new Set(ids).size, ids.length);
    for (const {path, parameters = []} of operations) {
      const inPath = parameters
        .map(({$ref, ...rest}) => ($ref ? resolve($ref).object : rest))
        .filter((one) => one.in === 'path');
      assert.deepEqual(
        inPath.map(({name}) => `{${name}}`),
        path.match(/\{\w+\}/g) ?? []
      );
    }
  });

  test('every answer with a problem is of the one type, and the refusals say when to come back', () => {
    for (const {responses} of operations)
      for (const [status, response] of Object.entries(responses)) {
        const {object} = response.$ref ? resolve(response.$ref) : {object: response};
        if (Number(status) >= 400) assert.ok(object.content['application/problem+json'], status);
        if (['429', '503', '507'].includes(status))
          assert.ok(object.headers['Retry-After'], status);
      }
  });

  test('the served document is the one in the sources', async () => {
    const answer = await server.get('/openapi.json');
    assert.match(answer.headers['content-type'], /^application\/json/);
    assert.deepEqual(answer.json, schema);
    const same = await server.get('/openapi.json', {
      headers: {'If-None-Match': answer.headers.etag},
    });
    assert.equal(same.status, 304);
  });

  test('the viewer: a page that may load nothing from elsewhere, with a tag', async () => {
    const page = await server.get('/');
    assert.match(page.headers['content-security-policy'], /default-src 'none'/);
    assert.equal(
      (await server.get('/', {headers: {'If-None-Match': page.headers.etag}})).status,
      304
    );
  });

  test('formats and options that /v1 lists are those of the schema', async () => {
    const {options} = (await server.get('/v1/options')).json;
    assert.deepEqual(
      options.map(({name}) => name).sort(),
      Object.keys(schema.components.schemas.Options.properties).sort()
    );
    const {input, output} = (await server.get('/v1/formats')).json;
    assert.ok(input.length >= 3 && output.length >= 2);
  });

  test('the version, and the same in the metrics', async () => {
    const {version} = (await server.get('/version')).json;
    assert.ok((await server.metrics()).includes(`version="${version}"`));
  });
});
