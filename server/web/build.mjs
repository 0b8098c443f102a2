// Bundles the viewer into the folder given as the argument; called by the CMake build.
import {copyFile, mkdir} from 'node:fs/promises';
import {dirname, join} from 'node:path';
import {fileURLToPath} from 'node:url';
import {build} from 'esbuild';

const here = dirname(fileURLToPath(import.meta.url));
const out = process.argv[2];
if (!out) throw new Error('usage: node build.mjs FOLDER');

await mkdir(join(out, 'draco'), {recursive: true});
await build({
    entryPoints: [join(here, 'src/main.js')],
    outfile: join(out, 'viewer.js'),
    bundle: true,
    minify: true,
    format: 'esm',
    target: 'es2022',
    legalComments: 'eof',
    logLevel: 'warning',
    // The decoder's own default places, which the viewer replaces by /draco/.
    define: {'import.meta.url': 'location.href'},
});
await build({
    entryPoints: [join(here, 'src/viewer.css')],
    outfile: join(out, 'viewer.css'),
    minify: true,
    logLevel: 'warning',
});
const draco = join(here, 'node_modules/three/examples/jsm/libs/draco/gltf');
for (const name of ['draco_wasm_wrapper.js', 'draco_decoder.wasm'])
    await copyFile(join(draco, name), join(out, 'draco', name));
for (const name of ['index.html', 'icon.svg']) await copyFile(join(here, 'src', name), join(out, name));
