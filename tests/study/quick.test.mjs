// The whole study with few shapes: every section is there, every plot is well-formed XML, figures
// are the same in two runs, and wrong arguments are refused.
import {spawnSync} from 'node:child_process';
import {mkdtempSync, readFileSync, readdirSync, rmSync, writeFileSync} from 'node:fs';
import {tmpdir} from 'node:os';
import {join} from 'node:path';
import assert from 'node:assert/strict';
import test, {after} from 'node:test';

const program = process.env.RIVAGE_STUDY_PROGRAM;
const folder = mkdtempSync(join(tmpdir(), 'rivage-study-'));
after(() => rmSync(folder, {recursive: true}));

const kSections = ['shapes', 'normal-noise', 'position-noise', 'label-noise', 'creases',
    'convergence', 'speed'];
const kPlots = ['shapes', 'normal-noise', 'position-noise', 'label-noise', 'creases',
    'convergence-distance', 'convergence-normals', 'speed'];

const run = (...words) => spawnSync(program, words, {encoding: 'utf8'});
const read = (...path) => readFileSync(join(folder, ...path), 'utf8');

// Every tag is closed in its order, every attribute quoted, no character stands for itself wrongly.
function checkXml(text) {
    const open = [];
    const rest = text.replace(/<(\/?)([a-z]+)((?: [a-zA-Z0-9:-]+="[^"<>&]*")*)(\/?)>/g,
        (_, closing, name, __, alone) => {
            if (closing) assert.equal(open.pop(), name);
            else if (!alone) open.push(name);
            return '';
        });
    assert.deepEqual(open, []);
    assert.doesNotMatch(rest.replace(/&(lt|gt|amp);/g, ''), /[<>&]/);
}

const first = run('--quick', '--out', join(folder, 'a'), '--commit', 'abc123');

test('a quick run succeeds and has every section, table and plot', () => {
    assert.equal(first.status, 0, first.stderr);
    const text = read('a', 'RESULTS.md');
    assert.match(text, /abc123/);
    for (const title of ['Verdicts', 'Clean shapes', 'Noise of the normals',
        'Noise of the positions', 'Noise of the labels', 'Creases', 'Convergence', 'Speed'])
        assert.match(text, new RegExp(`^## ${title}$`, 'm'));
    assert.doesNotMatch(text, /Not measured|\bnan\b|\binf\b/);
    for (const plot of kPlots) assert.ok(text.includes(`(plots/${plot}.svg)`), plot);
});

test('tables have as many cells in each row as in their head', () => {
    let cells = 0;
    for (const line of read('a', 'RESULTS.md').split('\n')) {
        const here = line.startsWith('|') ? line.split('|').length : 0;
        if (cells && here) assert.equal(here, cells, line);
        cells = here;
    }
});

test('a verdict stands beside every claim', () => {
    const [, verdicts] = /## Verdicts\n([\s\S]*?)\n## /.exec(read('a', 'RESULTS.md'));
    const rows = verdicts.split('\n').filter((line) => /^\| [^-c]/.test(line));
    assert.ok(rows.length > 20);
    for (const row of rows) assert.match(row, /\| \*\*(holds\*\*|(partly|fails)\*\*(: .*)?) \|$/);
});

test('plots are well-formed and draw lines', () => {
    assert.deepEqual(readdirSync(join(folder, 'a', 'plots')).sort(),
        kPlots.map((name) => `${name}.svg`).sort());
    for (const plot of kPlots) {
        const svg = read('a', 'plots', `${plot}.svg`);
        checkXml(svg);
        assert.doesNotMatch(svg, /nan|inf/);
        assert.ok(svg.split('<circle').length > 8, plot);
    }
});

test('two runs give the same figures, section by section too', () => {
    for (const section of ['shapes', 'label-noise']) {
        const again = run('--quick', '--threads', '1', '--out', join(folder, 'b'), section);
        assert.equal(again.status, 0, again.stderr);
        assert.equal(read('b', `${section}.csv`), read('a', `${section}.csv`));
    }
    assert.match(read('b', 'RESULTS.md'), /Not measured: `\.\/dev study creases`/);
});

test('the report follows the figures', () => {
    const path = join(folder, 'b', 'shapes.csv');
    const [head, ...lines] = read('b', 'shapes.csv').split('\n');
    const bias = head.split(',').indexOf('bias');
    writeFileSync(path, [head, ...lines.map((line) => {
        // Names hold no commas but "paper, auto normals".
        const cells = line.replace(/"paper, auto normals"/, 'paper auto').split(',');
        if (cells.length > bias) cells[bias] = '-0.5';
        return cells.join(',');
    })].join('\n'));
    assert.equal(run('--out', join(folder, 'b'), 'report').status, 0);
    assert.match(read('b', 'RESULTS.md'), /`studio` does not shrink.*worst -0\.500.*\*\*fails\*\*/);
});

test('wrong arguments are refused by name', () => {
    for (const [words, message] of [
        [['--out', folder, 'colours'], /no section 'colours'/],
        [['--quick'], /--out is missing/],
        [['--out'], /--out needs a value/],
        [['--out', folder, '--poses', '0'], /--poses takes a number from 1/],
        [['--out', folder, '--threads', 'many'], /--threads takes a number/]]) {
        const {status, stderr} = run(...words);
        assert.equal(status, 2);
        assert.match(stderr, message);
        assert.match(stderr, /sections: shapes normal-noise/);
    }
    assert.ok(kSections.every((name) => run('--out', folder, 'none').stderr.includes(name)));
});

test('a folder that cannot be written is an error', () => {
    const {status, stderr} = run('--quick', '--out', '/proc/none', 'speed');
    assert.equal(status, 1);
    assert.match(stderr, /cannot/);
});
