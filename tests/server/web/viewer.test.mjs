// The viewer page of the real server in headless Chromium: converts a sample, compares, shows a
// problem; no console error, no request to anywhere else. RIVAGE_BIN names the programs' folder.
import assert from 'node:assert/strict';
import {spawn} from 'node:child_process';
import {createHash} from 'node:crypto';
import {mkdtemp, rm, writeFile} from 'node:fs/promises';
import {createRequire} from 'node:module';
import test from 'node:test';
import {tmpdir} from 'node:os';
import {join} from 'node:path';
import {setTimeout as sleep} from 'node:timers/promises';

// The packages are those of tests/gltf, so that there is one lock file.
const require = createRequire(new URL('../../gltf/package.json', import.meta.url));
const {chromium} = require('playwright-core');
const bin = process.env.RIVAGE_BIN;
assert.ok(bin, 'RIVAGE_BIN names the folder of the programs');
const kArguments = ['--no-sandbox', '--use-gl=angle', '--use-angle=swiftshader',
  '--enable-unsafe-swiftshader', '--disable-background-networking'];
const kPatience = {timeout: 120000};

async function startServer(...flags) {
  const child = spawn(join(bin, 'rivage-server'),
    ['--listen', '127.0.0.1:0', '--admin-listen', 'off', ...flags],
    {stdio: ['ignore', 'pipe', 'ignore']});
  let said = '';
  child.stdout.on('data', (data) => { said += data; });
  for (let i = 0; i < 200; ++i) {
    const found = /listening on (http:\/\/\S+)/.exec(said);
    if (found) return {child, url: found[1]};
    await sleep(50);
  }
  child.kill('SIGKILL');
  throw new Error('the server did not start');
}

// A page that fails the test for every complaint of the browser and every foreign request.
async function openPage(browser, url, path) {
  const page = await browser.newPage({viewport: {width: 1200, height: 760}});
  const complaints = [];
  page.on('console', (message) => {
    if (message.type() === 'error') complaints.push(message.text());
  });
  page.on('pageerror', (error) => complaints.push(error.message));
  page.on('request', (request) => {
    if (!request.url().startsWith(url) && !request.url().startsWith('blob:'))
      complaints.push(`asked ${request.url()}`);
  });
  await page.goto(url + path, kPatience);
  return {page, complaints};
}

// Share of the view's pixels that are not the background.
async function coverage(page) {
  await page.evaluate(() => new Promise((resolve) => requestAnimationFrame(() => resolve())));
  const box = await page.locator('#view').boundingBox();
  const picture = (await page.screenshot({clip: box})).toString('base64');
  return page.evaluate(async (text) => {
    const image = new Image();
    image.src = `data:image/png;base64,${text}`;
    await image.decode();
    const small = new OffscreenCanvas(160, 120).getContext('2d');
    small.drawImage(image, 0, 0, 160, 120);
    const {data} = small.getImageData(0, 0, 160, 120);
    let filled = 0;
    for (let i = 0; i < data.length; i += 4) {
      const far = [0, 1, 2].some((channel) => Math.abs(data[i + channel] - data[channel]) > 12);
      if (far) ++filled;
    }
    return filled / (data.length / 4);
  }, picture);
}

test('viewer', async (t) => {
  const server = await startServer();
  const browser = await chromium.launch({
    executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium', args: kArguments,
  });
  t.after(async () => {
    await browser.close();
    server.child.kill('SIGTERM');
  });

  await t.test('a shared link converts its sample and shows the report', async () => {
    const {page, complaints} = await openPage(browser, server.url, '/?sample=island&shading=crease');
    await page.waitForSelector('#report table', kPatience);
    assert.match(await page.textContent('#report'), /64 x 68 x 40/);
    assert.match(await page.textContent('#curl'), /shading=crease/);
    assert.equal(await page.inputValue('#option-shading'), 'crease');
    assert.equal(await page.getAttribute('#download', 'download'), 'island.glb');
    const covered = await coverage(page);
    assert.ok(covered > 0.1 && covered < 0.9, `the model covers ${covered} of the view`);

    await page.click('#compare');
    await page.waitForSelector('#divider:not([hidden])', kPatience);
    if (process.env.RIVAGE_PICTURE) await page.screenshot({path: process.env.RIVAGE_PICTURE});
    await page.click('#wire');
    await page.click('#flat');
    assert.deepEqual(complaints, []);
    await page.close();
    const policy = (await fetch(server.url)).headers.get('Content-Security-Policy');
    assert.match(policy, /^default-src 'none'; script-src 'self' /);
  });

  await t.test('a broken file shows the problem of the server', async () => {
    const {page} = await openPage(browser, server.url, '/');
    await page.waitForSelector('#samples button', kPatience);
    await page.setInputFiles('#file',
      {name: 'broken.vox', mimeType: '', buffer: Buffer.from('VOX no')});
    await page.waitForSelector('#error:not([hidden])', kPatience);
    assert.match(await page.textContent('#error-title'), /grid/);
    assert.match(await page.textContent('#error-facts'), /problems/);
    await page.close();
  });

  await t.test('a server with API keys: the page asks for one, until it is right', async () => {
    const folder = await mkdtemp(join(tmpdir(), 'rivage-'));
    const hash = createHash('sha256').update('a key of the viewer').digest('hex');
    await writeFile(join(folder, 'keys'), `viewer sha256:${hash}\n`);
    const keyed = await startServer('--api-keys', join(folder, 'keys'));
    const {page} = await openPage(browser, keyed.url, '/');
    for (const key of ['a wrong key of the viewer', 'a key of the viewer']) {
      await page.waitForSelector('#key-dialog[open]', kPatience);
      await page.fill('#key', key);
      await page.press('#key', 'Enter');
    }
    await page.waitForSelector('#samples button', kPatience);
    await page.close();
    keyed.child.kill('SIGTERM');
    await rm(folder, {recursive: true});
  });

  await t.test('a value out of range is refused in the form', async () => {
    const {page, complaints} = await openPage(browser, server.url, '/?alpha=-1');
    await page.waitForSelector('#samples button', kPatience);
    assert.equal(await page.$eval('#option-alpha', (input) => input.checkValidity()), false);
    await page.click('#defaults');
    assert.equal(await page.inputValue('#option-alpha'), '');
    assert.doesNotMatch(page.url(), /alpha/);
    assert.deepEqual(complaints, []);
    await page.close();
  });
});
