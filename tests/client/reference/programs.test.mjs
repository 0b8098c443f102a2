// The pages and scripts that the build made by running the programs: nothing that --help tells is
// missing in them, and `cmake --install` puts them where man and the shells look.
import assert from 'node:assert/strict';
import {execFileSync, spawnSync} from 'node:child_process';
import {existsSync, mkdtempSync, readFileSync, rmSync} from 'node:fs';
import {tmpdir} from 'node:os';
import {join} from 'node:path';
import test from 'node:test';

const build = process.env.RIVAGE_BUILD;
const programs = ['rivage', 'rivage-load'].filter((name) =>
    existsSync(join(build, 'share/man/man1', `${name}.1`)));

const pagesOf = (name) => [
    `share/man/man1/${name}.1`,
    `share/bash-completion/completions/${name}`,
    `share/zsh/site-functions/_${name}`,
    `share/fish/vendor_completions.d/${name}.fish`,
];

const help = (name, command) =>
    execFileSync(join(build, 'bin', name), [...command, '--help'], {encoding: 'utf8'});

// The options and commands that --help names, of a command and all below it.
function namesIn(name, command = []) {
    const text = help(name, command);
    const options = [...text.matchAll(/^ +(?:-\w,)?--([a-z][\w-]*)/gm)].map((match) => match[1]);
    const [, list = ''] = /^Subcommands:\n((?: .*\n?)*)/m.exec(text) ?? [];
    const commands = [...list.matchAll(/^ {2}(\w[\w-]*)/gm)].map((match) => match[1]);
    return [...options, ...commands,
        ...commands.flatMap((below) => namesIn(name, [...command, below]))];
}

const isInstalled = (program) => spawnSync('sh', ['-c', `command -v ${program}`]).status === 0;

// That a program finds nothing to say of a file.
function accepts(t, [program, ...rest], file) {
    if (!isInstalled(program)) return t.diagnostic(`${program} is not installed`);
    const {status, stderr, stdout} = spawnSync(program, [...rest, file], {
        encoding: 'utf8', env: {...process.env, LC_ALL: 'C.UTF-8', MANWIDTH: '80'}});
    const words = (program === 'man' ? stderr : stderr + stdout).split('\n')
        .filter((line) => line && !line.includes('missing date'));  // there is no release yet
    assert.deepEqual(words, []);
    if (program !== 'mandoc') assert.equal(status, 0);  // which counts the date
}

test('there is a program with pages', () => assert.ok(programs.includes('rivage')));

for (const name of programs) {
    const [page, bash, zsh, fish] = pagesOf(name).map((path) => join(build, path));

    test(`${name}: all that --help names is in the page and in every script`, () => {
        const names = new Set(namesIn(name));
        assert.ok(names.size > 20, `only ${names.size} names`);
        for (const file of [page, bash, zsh, fish]) {
            const text = readFileSync(file, 'utf8').replaceAll('\\-', '-');
            const missing = [...names].filter((one) => !text.includes(one));
            assert.deepEqual(missing, [], file);
        }
    });

    test(`${name}: man, mandoc and the shells accept what was written`, (t) => {
        accepts(t, ['man', '--warnings', '-E', 'UTF-8', '-l', '-Tutf8', '-Z'], page);
        accepts(t, ['mandoc', '-T', 'lint', '-W', 'warning'], page);
        accepts(t, ['bash', '-n'], bash);
        accepts(t, ['zsh', '-n'], zsh);
        accepts(t, ['fish', '-n'], fish);
    });
}

test('cmake --install puts programs, pages and scripts in place', () => {
    const prefix = mkdtempSync(join(tmpdir(), 'rivage-install-'));
    try {
        execFileSync('cmake', ['--install', build, '--prefix', prefix], {stdio: 'pipe'});
        for (const name of programs)
            for (const path of [`bin/${name}`, ...pagesOf(name)])
                assert.ok(existsSync(join(prefix, path)), path);
        const version = execFileSync(join(prefix, 'bin/rivage'), ['--version'], {encoding: 'utf8'});
        assert.match(version, /^rivage \d/);
    } finally {
        rmSync(prefix, {recursive: true});
    }
});
