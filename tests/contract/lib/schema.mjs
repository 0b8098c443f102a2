// Compares every answer with proto/openapi.yaml, and remembers what has been seen.
import assert from 'node:assert/strict';
import {createHash} from 'node:crypto';
import {readFileSync} from 'node:fs';
import addFormats from 'ajv-formats';
import Ajv from 'ajv/dist/2020.js';

export const schema = JSON.parse(
  readFileSync(new URL('../../../proto/openapi.yaml', import.meta.url), 'utf8')
);

const ajv = new Ajv({strict: false, allErrors: true});
addFormats(ajv);
ajv.addSchema({$id: 'rivage', ...schema});

const kGeneral = [
  'content-type',
  'content-length',
  'connection',
  'keep-alive',
  'date',
  'transfer-encoding',
  'x-content-type-options',
  'x-request-id',
  'vary',
  'accept-ranges',
];
const kCors = [
  'access-control-allow-origin',
  'access-control-allow-methods',
  'access-control-allow-headers',
  'access-control-max-age',
  'access-control-expose-headers',
];
// What would show how the server is built.
const kInside =
  /\bstd::|what\(\)|terminate called|\.cpp\b|\.h:\d|0x[0-9a-f]{6,}|secret|\/(root|home|work|usr)\//;

const escaped = (text) => text.replaceAll('~', '~0').replaceAll('/', '~1');
const pointer = (...parts) => `#/${parts.map((part) => escaped(String(part))).join('/')}`;

// The object at a JSON pointer, and where it stands after all references.
export function resolve(at) {
  for (;;) {
    const object = at
      .slice(2)
      .split('/')
      .reduce((value, part) => value?.[part.replaceAll('~1', '/').replaceAll('~0', '~')], schema);
    assert.ok(object !== undefined, `the schema has no ${at}`);
    if (!object.$ref) return {object, at};
    at = object.$ref;
  }
}

const compiled = new Map();
export function validate(at, value, what) {
  if (!compiled.has(at)) compiled.set(at, ajv.compile({$ref: `rivage${at}`}));
  const check = compiled.get(at);
  if (check(value)) return;
  const errors = check.errors
    .slice(0, 6)
    .map(
      (error) => `${error.instancePath || '/'} ${error.message} ${JSON.stringify(error.params)}`
    );
  assert.fail(
    `${what}:\n  ${errors.join('\n  ')}\n  value: ${JSON.stringify(value)?.slice(0, 600)}`
  );
}

const segments = (path) => path.split('/');
function matches(pattern, path) {
  const [expected, given] = [segments(pattern), segments(path)];
  return (
    expected.length === given.length &&
    expected.every((part, i) => (part.startsWith('{') ? given[i] !== '' : part === given[i]))
  );
}

// The path of the schema that a request path belongs to.
export function routeOf(path, admin = false) {
  const plain = path.split('?')[0];
  return Object.keys(schema.paths).find(
    (pattern) => matches(pattern, plain) && Boolean(schema.paths[pattern].servers) === admin
  );
}

export const methodsOf = (route) =>
  Object.keys(schema.paths[route])
    .filter((name) => name !== 'servers')
    .map((name) => name.toUpperCase());

export const allowedOf = (route) =>
  new Set([...methodsOf(route), 'OPTIONS', ...(methodsOf(route).includes('GET') ? ['HEAD'] : [])]);

const kErrors = '#/components/responses/Error';
export const generalStatuses = schema.components.responses.Error['x-statuses'];

// Where the schema describes an answer.
function describe(method, route, status, path) {
  if (method === 'OPTIONS' && status === 204) return '#/components/responses/Options';
  const name = method === 'HEAD' ? 'get' : method.toLowerCase();
  const responses = route && schema.paths[route][name]?.responses;
  if (responses?.[status]) return pointer('paths', route, name, 'responses', status);
  const refusal = [401, 403, 429].includes(status) && path.startsWith('/v1/');
  if (refusal && !responses) return `#/components/responses/Error${status}`;
  assert.ok(generalStatuses.includes(status), `${method} ${path} has no status ${status}`);
  if (responses) assert.ok(status !== 405, `${method} ${path} is allowed`);
  return kErrors;
}

function checkHeaders(response, at, headers, admin) {
  const documented = response.headers ?? {};
  for (const name of Object.keys(documented)) {
    const field = resolve(`${at}/headers/${escaped(name)}`);
    const value = headers[name.toLowerCase()];
    if (value === undefined) {
      assert.ok(!field.object.required, `the header field ${name}`);
      continue;
    }
    const number = field.object.schema.type === 'integer' && /^\d+$/.test(value);
    validate(`${field.at}/schema`, number ? Number(value) : value, name);
  }
  const known = [
    ...kGeneral,
    ...kCors,
    ...Object.keys(documented).map((name) => name.toLowerCase()),
  ];
  for (const name of Object.keys(headers))
    assert.ok(known.includes(name), `an undocumented header field: ${name}: ${headers[name]}`);
  if (admin) return;
  assert.match(headers['x-request-id'] ?? '', /^[A-Za-z0-9_-]{1,64}$/, 'X-Request-ID');
  assert.equal(headers['x-content-type-options'], 'nosniff');
}

function checkBody(response, at, answer, anyBody) {
  const type = (answer.headers['content-type'] ?? '').split(';')[0];
  assert.ok(response.content?.[type], `a documented type of content: ${JSON.stringify(type)}`);
  if (!type.endsWith('json') || anyBody) return;
  assert.ok(
    !kInside.test(answer.text) || type === 'application/json',
    `nothing of the inside: ${answer.text}`
  );
  validate(`${at}/content/${escaped(type)}/schema`, answer.json, 'the body');
  if (type === 'application/problem+json') assert.equal(answer.json.status, answer.status);
}

export const sha256 = (bytes) => `sha-256=:${createHash('sha256').update(bytes).digest('base64')}:`;

function checkDigests({headers, body, status}) {
  if (headers['content-digest']) assert.equal(headers['content-digest'], sha256(body));
  if (headers['repr-digest'] && status === 200) assert.equal(headers['repr-digest'], sha256(body));
}

const seen = new Set();
const problems = new Set();
export const coverage = {seen, problems};

// Fails if the head of an answer is not one that the schema describes: of a stream, which may not end.
// Gives the schema's entry for it.
export function checkHead(method, target, answer, admin = false) {
  const path = target.split('?')[0];
  const route = routeOf(path, admin);
  const at = describe(method, route, answer.status, path);
  const response = resolve(at);
  checkHeaders(response.object, response.at, answer.headers, admin);
  if (answer.status === 405)
    assert.deepEqual(new Set((answer.headers.allow ?? '').split(', ')), allowedOf(route), 'Allow');
  if ([429, 503, 507].includes(answer.status))
    assert.match(answer.headers['retry-after'] ?? '', /^[1-9]\d*$/, 'Retry-After');
  seen.add(`${method} ${route ?? '*'} ${answer.status}`);
  if (at === kErrors) seen.add(`any ${answer.status}`);
  return response;
}

// Fails if an answer is not one that the schema describes.
// admin: it came from the admin port; anyBody: the engine is a fake one and writes what it likes;
// asset: a file of the viewer, which the schema does not list.
export function checkAnswer(
  method,
  target,
  answer,
  {admin = false, anyBody = false, asset = false} = {}
) {
  if (asset && answer.status < 400) return;
  const response = checkHead(method, target, answer, admin);
  const empty = method === 'HEAD' || answer.status === 204 || answer.status === 304;
  if (empty) assert.equal(answer.body.length, 0, 'no body');
  else checkBody(response.object, response.at, answer, anyBody);
  if (method !== 'HEAD') checkDigests(answer);
  if (!empty && answer.problem) problems.add(answer.problem);
}
