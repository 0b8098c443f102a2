// Draws a GLB with three.js in headless Chromium. The page comes from a server on 127.0.0.1 that
// lives as long as the drawing; a request to anywhere else is refused and reported.
import {readFileSync} from 'node:fs';
import {createServer} from 'node:http';
import {createRequire} from 'node:module';
import {dirname, join} from 'node:path';
import {fileURLToPath} from 'node:url';

// The packages are those of tests/gltf, so that there is one lock file.
const require = createRequire(new URL('../gltf/package.json', import.meta.url));
const {buildSync} = require('esbuild');
const {chromium} = require('playwright-core');

const here = dirname(fileURLToPath(import.meta.url));
const packages = join(here, '..', 'gltf', 'node_modules');
const decoder = join(packages, 'three', 'examples', 'jsm', 'libs', 'draco', 'gltf');

export const kDefaults = {angle: 35, elevation: 30, zoom: 1, width: 900, height: 700, wire: false};

const kArguments = [
  '--no-sandbox', '--disable-gpu', '--use-gl=angle', '--use-angle=swiftshader',
  '--enable-unsafe-swiftshader', '--disable-quic', '--no-first-run',
  '--disable-background-networking', '--disable-component-update', '--disable-sync',
];

function pageScript() {
  const bundle = buildSync({
    entryPoints: [join(here, 'page.mjs')],
    bundle: true,
    write: false,
    format: 'iife',
    nodePaths: [packages],
    define: {'import.meta.url': 'location.href'},
    logLevel: 'error',
  });
  return bundle.outputFiles[0].text;
}

const kPage =
    '<!doctype html><style>*{margin:0}</style><script src="/page.js" defer></script>';

function serve(model) {
  const routes = {
    '/': ['text/html', kPage],
    '/page.js': ['text/javascript', pageScript()],
    '/model.glb': ['model/gltf-binary', model],
    '/favicon.ico': ['image/x-icon', ''],
  };
  for (const name of ['draco_wasm_wrapper.js', 'draco_decoder.wasm', 'draco_decoder.js'])
    routes[`/draco/${name}`] = [
      name.endsWith('.wasm') ? 'application/wasm' : 'text/javascript',
      readFileSync(join(decoder, name)),
    ];
  const server = createServer((request, response) => {
    const route = routes[request.url];
    response.writeHead(route ? 200 : 404, {'Content-Type': route?.[0] ?? 'text/plain'});
    response.end(route?.[1] ?? 'not found');
  });
  return new Promise((done) => server.listen(0, '127.0.0.1', () => done(server)));
}

async function draw(page, origin, options) {
  const outside = [];
  const complaints = [];
  await page.route('**/*', (route) => {
    const url = route.request().url();
    if (url.startsWith(origin) || url.startsWith('blob:') || url.startsWith('data:'))
      return route.continue();
    outside.push(url);
    return route.abort();
  });
  page.on('pageerror', (error) => complaints.push(error.message));
  page.on('console', (message) => message.type() === 'error' && complaints.push(message.text()));
  await page.goto(origin);
  const found = await page.evaluate((o) => window.render(o), options);
  const png = await page.locator('canvas').screenshot({type: 'png'});
  return {...found, png, outside, complaints};
}

/**
 * Loads and draws a GLB.
 * @param model    its bytes
 * @param options  {angle, elevation (degrees), zoom, width, height (pixels), wire}
 * @returns {png, parts, extras, picture: {coverage, colors}, outside, complaints}
 */
export async function renderModel(model, options = {}) {
  const settings = {...kDefaults, ...options};
  const server = await serve(model);
  const browser = await chromium.launch({
    executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium',
    args: kArguments,
  });
  try {
    const page = await browser.newPage({
      viewport: {width: settings.width, height: settings.height},
    });
    return await draw(page, `http://127.0.0.1:${server.address().port}/`, settings);
  } finally {
    await browser.close();
    server.close();
  }
}
