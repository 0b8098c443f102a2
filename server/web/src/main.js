// The page: choose a grid, set options, convert, look at the result.
import {OptionsForm} from './form.js';
import {clientCommand, curlCommand, pageLink, query} from './link.js';
import {bytesText, showReport, timings} from './report.js';
import {View} from './view.js';

const at = (id) => document.getElementById(id);
const state = {grid: null, running: null, url: null, sent: null, voxelsOf: null};
let view = null;
let form = null;

// A failure that the page can explain: the fields of application/problem+json.
class Problem extends Error {
    constructor(facts) {
        super(facts.detail ?? facts.title);
        this.facts = facts;
    }
}

// What a server with API keys wants to see; kept until this tab is closed.
const kKeyName = 'rivage-key';
let asked = null;

// Asks once, however many requests want to know; an empty answer is none.
function askForKey() {
    asked ??= new Promise((resolve) => {
        const dialog = at('key-dialog');
        dialog.addEventListener('close', () => {
            sessionStorage.setItem(kKeyName, at('key').value.trim());
            resolve();
        }, {once: true});
        dialog.showModal();
    }).finally(() => { asked = null; });
    return asked;
}

async function send(path, init = {}) {
    const key = sessionStorage.getItem(kKeyName);
    const headers = key ? {...init.headers, 'X-API-Key': key} : init.headers;
    const response = await fetch(path, {...init, headers});
    if (response.status !== 401) return response;
    if (sessionStorage.getItem(kKeyName) === key) await askForKey();
    return sessionStorage.getItem(kKeyName) ? send(path, init) : response;
}

async function request(path, init) {
    let response;
    try {
        response = await send(path, init);
    } catch (error) {
        if (error.name === 'AbortError') throw error;
        throw new Problem({title: 'The server cannot be reached', detail: error.message});
    }
    if (response.ok) return response;
    const problem = await response.json().catch(() => ({}));
    const wait = response.headers.get('Retry-After');
    throw new Problem({title: `The server answered ${response.status}`, ...problem,
        ...(wait ? {retry_after: `${wait} s`} : {})});
}

function showError(error) {
    const facts = error.facts ?? {title: 'The page failed', detail: error.message};
    at('error').hidden = false;
    at('error-title').textContent = facts.title ?? 'The conversion failed';
    at('error-detail').textContent = facts.detail ?? '';
    const shown = ['field', 'limit', 'actual', 'setting', 'retry_after', 'type'];
    at('error-facts').replaceChildren(...shown.filter((key) => facts[key] !== undefined)
        .flatMap((key) => {
            const name = document.createElement('dt');
            const value = document.createElement('dd');
            name.textContent = key.replaceAll('_', ' ');
            value.textContent = facts[key];
            return [name, value];
        }));
    at('error').scrollIntoView({block: 'nearest'});
}

// Runs one task at a time, with the busy bar shown; a new task ends the one before.
async function busy(text, task) {
    state.running?.abort();
    const controller = new AbortController();
    state.running = controller;
    at('error').hidden = true;
    at('busy').hidden = false;
    const since = performance.now();
    const tick = () => {
        at('busy-text').textContent = `${text} ${((performance.now() - since) / 1000).toFixed(1)} s`;
    };
    tick();
    const timer = setInterval(tick, 100);
    try {
        return await task(controller.signal);
    } catch (error) {
        if (error.name !== 'AbortError') showError(error);
    } finally {
        clearInterval(timer);
        if (state.running === controller) {
            state.running = null;
            at('busy').hidden = true;
        }
    }
}

function showCommands() {
    const values = form?.values() ?? new Map();
    at('curl').textContent = curlCommand(state.grid, values);
    at('cli').textContent = clientCommand(state.grid, values);
    history.replaceState(null, '', pageLink(state.grid, values));
}

function useGrid(name, bytes, sample) {
    state.grid = {name, bytes, sample};
    at('grid-name').textContent = `${name}, ${bytesText(bytes.byteLength)}`;
    at('convert').disabled = false;
    showCommands();
}

async function post(values, signal) {
    return request(`/v1/regularize${query(values)}`, {
        method: 'POST',
        body: state.grid.bytes,
        headers: {
            'Content-Type': 'application/octet-stream',
            'Content-Disposition': `attachment; filename="${state.grid.name.replace(/[^\w.-]/g, '_')}"`,
        },
        signal,
    });
}

// The report of the job with its times; the one in the model has none.
async function reportOf(response, gltf) {
    const id = response.headers.get('Rivage-Job');
    const job = id && await send(`/v1/jobs/${encodeURIComponent(id)}`)
        .then((answer) => answer.ok ? answer.json() : null).catch(() => null);
    return job?.report ?? gltf?.parser.json.asset.extras?.rivage ?? null;
}

function showDownload(bytes, extension, type) {
    if (state.url) URL.revokeObjectURL(state.url);
    state.url = URL.createObjectURL(new Blob([bytes], {type}));
    const link = at('download');
    link.href = state.url;
    link.download = state.grid.name.replace(/\.[^.]*$/, '') + `.${extension}`;
    link.textContent = `Download ${link.download}`;
    at('size').textContent = bytesText(bytes.byteLength);
    at('result').hidden = false;
}

function showModel(gltf, values) {
    const first = !view.surface.userData.model || state.sent?.grid !== state.grid;
    view.place(view.surface, gltf.scene, values.get('up') === 'z');
    at('empty').hidden = true;
    at('tools').hidden = false;
    const same = state.voxelsOf === voxelKey(values);
    if (at('compare').getAttribute('aria-pressed') === 'true' && !same) toggleCompare(false);
    if (first) view.frame();
}

async function convert() {
    if (!state.grid || !form?.valid()) return;
    const values = form.values();
    await busy('Converting', async (signal) => {
        const response = await post(values, signal);
        const bytes = await response.arrayBuffer();
        const type = response.headers.get('Content-Type');
        const isModel = type?.startsWith('model/gltf-binary');
        const gltf = isModel && view ? await view.decode(bytes) : null;
        if (gltf) showModel(gltf, values);
        showDownload(bytes, values.get('output') ?? 'glb', type);
        const report = await reportOf(response, gltf);
        if (report) showReport(at('report'), report, timings(response.headers.get('Server-Timing')));
        state.sent = {grid: state.grid, values};
    });
}

// The same conversion with a data weight so large that no vertex moves: the voxels themselves.
function voxelValues(values) {
    const kept = new Map();
    for (const [name, value] of values) {
        const group = form.inputs.get(name)?.option.group;
        if (group === 'input' || group === 'output') kept.set(name, value);
    }
    kept.delete('scale');  // of voxel outputs only, and this is a mesh
    const still = {output: 'glb', alpha: '1000000', normals: 'trivial', displacement_limit: 'none',
        solver: 'pcg', untangle: 'false', shading: 'flat'};
    for (const [name, value] of Object.entries(still)) kept.set(name, value);
    return kept;
}

function voxelKey(values) {
    return `${state.grid?.name} ${state.grid?.bytes.byteLength} ${query(voxelValues(values))}`;
}

function toggleCompare(on) {
    at('compare').setAttribute('aria-pressed', String(on));
    at('divider').hidden = !on;
    if (on) moveDivider(0.5);
    else view.setSplit(null);
}

async function compare() {
    if (at('compare').getAttribute('aria-pressed') === 'true') return toggleCompare(false);
    const values = state.sent.values;
    if (state.voxelsOf !== voxelKey(values)) {
        await busy('Fetching the voxels', async (signal) => {
            const response = await post(voxelValues(values), signal);
            const gltf = await view.decode(await response.arrayBuffer());
            view.place(view.voxels, gltf.scene, values.get('up') === 'z');
            state.voxelsOf = voxelKey(values);
        });
    }
    if (state.voxelsOf === voxelKey(values)) toggleCompare(true);
}

function moveDivider(fraction) {
    const kept = Math.min(1, Math.max(0, fraction));
    at('divider').style.left = `${kept * 100}%`;
    at('divider').setAttribute('aria-valuenow', String(Math.round(kept * 100)));
    view.setSplit(kept);
}

function setUpDivider() {
    const divider = at('divider');
    divider.addEventListener('pointerdown', (event) => divider.setPointerCapture(event.pointerId));
    divider.addEventListener('pointermove', (event) => {
        if (!divider.hasPointerCapture(event.pointerId)) return;
        const box = at('stage').getBoundingClientRect();
        moveDivider((event.clientX - box.left) / box.width);
    });
    divider.addEventListener('keydown', (event) => {
        const step = {ArrowLeft: -0.02, ArrowRight: 0.02}[event.key];
        if (step) moveDivider(Number(divider.getAttribute('aria-valuenow')) / 100 + step);
    });
}

async function useFile(file) {
    if (!file) return;
    useGrid(file.name, await file.arrayBuffer(), null);
    await convert();
}

async function useSample(name) {
    const bytes = await busy(`Fetching ${name}`, async (signal) =>
        (await request(`/v1/samples/${encodeURIComponent(name)}`, {signal})).arrayBuffer());
    if (!bytes) return;
    useGrid(`${name}.vox`, bytes, name);
    await convert();
}

function setUpDrop() {
    const inside = (on) => { at('drop').hidden = !on; };
    addEventListener('dragover', (event) => {
        event.preventDefault();
        inside(true);
    });
    addEventListener('dragleave', (event) => { if (!event.relatedTarget) inside(false); });
    addEventListener('drop', (event) => {
        event.preventDefault();
        inside(false);
        useFile(event.dataTransfer.files[0]);
    });
    at('file').addEventListener('change', (event) => {
        useFile(event.target.files[0]);
        event.target.value = '';
    });
}

function setUpTools() {
    const toggle = (id, look) => at(id).addEventListener('click', () => {
        const on = at(id).getAttribute('aria-pressed') !== 'true';
        at(id).setAttribute('aria-pressed', String(on));
        view.setLook(look, on);
    });
    toggle('wire', 'wireframe');
    toggle('flat', 'flatShading');
    at('home').addEventListener('click', () => view.frame());
    at('compare').addEventListener('click', compare);
    at('convert').addEventListener('click', convert);
    at('cancel').addEventListener('click', () => state.running?.abort());
    at('defaults').addEventListener('click', () => form.set(new Map()));
    for (const button of document.querySelectorAll('[data-copy]')) {
        button.addEventListener('click', async () => {
            const from = button.dataset.copy;
            await navigator.clipboard.writeText(from === 'link' ? location.href : at(from).textContent);
            const text = button.textContent;
            button.textContent = 'Copied';
            setTimeout(() => { button.textContent = text; }, 1200);
        });
    }
}

function showSamples(samples) {
    for (const target of [at('samples'), at('samples-large')]) {
        target.replaceChildren(...samples.map(({name, description}) => {
            const button = document.createElement('button');
            button.type = 'button';
            button.textContent = name;
            if (description) button.title = description;
            button.addEventListener('click', () => useSample(name));
            return button;
        }));
    }
}

async function begin() {
    setUpTools();
    setUpDrop();
    setUpDivider();
    try {
        view = new View(at('view'));
    } catch (error) {
        showError(new Problem({title: 'No 3D view', detail:
            'This browser has no WebGL 2; conversion and download work all the same.'}));
    }
    const wanted = new Map(new URLSearchParams(location.search));
    const sample = wanted.get('sample');
    wanted.delete('sample');
    const [options, samples] = await Promise.all(
        ['/v1/options', '/v1/samples'].map((path) => request(path).then((answer) => answer.json())));
    form = new OptionsForm(at('options'), options.options, showCommands);
    form.set(wanted);
    showSamples(samples.samples.map((one) => typeof one === 'string' ? {name: one} : one));
    fetch('/version').then((answer) => answer.json())
        .then(({version}) => { at('version').textContent = version ?? ''; }, () => {});
    if (sample) await useSample(sample);
}

begin().catch(showError);
