// Builds the report panel from the report of a conversion (API.md, section 3).
const numbers = new Intl.NumberFormat('en', {maximumFractionDigits: 1});
const fine = new Intl.NumberFormat('en', {maximumSignificantDigits: 5});

function element(name, text) {
    const node = document.createElement(name);
    if (text !== undefined) node.textContent = text;
    return node;
}

function table(caption, head, rows) {
    const node = element('table');
    node.append(element('caption', caption));
    if (head) {
        const row = element('tr');
        row.append(...head.map((text) => {
            const cell = element('th', text);
            cell.scope = 'col';
            return cell;
        }));
        const group = element('thead');
        group.append(row);
        node.append(group);
    }
    const body = element('tbody');
    for (const [name, ...values] of rows) {
        const row = element('tr');
        const title = element('th', name);
        title.scope = 'row';
        row.append(title, ...values.map((text) => element('td', text)));
        body.append(row);
    }
    node.append(body);
    return node;
}

export function bytesText(bytes) {
    if (bytes < 1000) return `${bytes} B`;
    if (bytes < 1e6) return `${numbers.format(bytes / 1e3)} kB`;
    return `${numbers.format(bytes / 1e6)} MB`;
}

// The times by stage of a Server-Timing header, for a report that has none.
export function timings(header) {
    const times = {};
    for (const item of (header ?? '').split(',')) {
        const match = /^\s*([\w-]+).*;\s*dur=([\d.]+)/.exec(item);
        if (match) times[match[1]] = Number(match[2]);
    }
    return Object.keys(times).length ? times : null;
}

function stageTable(times) {
    const stages = Object.entries(times).filter(([name]) => name !== 'total');
    const total = times.total ?? stages.reduce((sum, [, value]) => sum + value, 0);
    const rows = stages.map(([name, value]) => [name, `${numbers.format(value)} ms`]);
    const track = element('div');
    track.className = 'track';
    for (const [name, value] of stages) {
        const part = element('i');
        part.style.flexGrow = String(value);
        part.title = `${name}: ${numbers.format(value)} ms`;
        track.append(part);
    }
    return [table('Time', null, [...rows, ['total', `${numbers.format(total)} ms`]]), track];
}

function labelTable(report) {
    const rows = report.input.labels.map(({name, voxels}) =>
        [name, numbers.format(voxels), report.closed?.[name] === false ? 'no' : 'yes']);
    return table('Labels', ['', 'voxels', 'closed'], rows);
}

function voxelTable({dims, voxels, scale, colors, models, palette_error: error}) {
    const rows = [
        ['scale', scale],
        ['size', dims.join(' x ')],
        ['voxels', numbers.format(voxels)],
        ['colours', numbers.format(colors)],
        ['models', numbers.format(models)],
    ];
    if (error) rows.push(['colour error, mean', fine.format(error.mean)]);
    return table('Result', null, rows);
}

export function showReport(target, report, times) {
    const {input, surface, energy, displacement, output} = report;
    const rows = (names) => names.map((name) =>
        [name, fine.format(energy.before[name]), fine.format(energy.after[name])]);
    const parts = [
        table('Grid', null, [
            ['format', input.format],
            ['size', `${input.dims.join(' x ')}`],
            ['voxels', numbers.format(input.voxels)],
            ['faces', numbers.format(surface.surfels)],
            ['interfaces', numbers.format(surface.interfaces.length)],
        ]),
        labelTable(report),
        table('Energy', ['', 'before', 'after'], rows(['data', 'alignment', 'fairness', 'total'])),
        table('Surface', null, [
            ['displacement, rms', `${fine.format(displacement.rms)} voxel`],
            ['displacement, max', `${fine.format(displacement.max)} voxel`],
            ['inverted faces', `${numbers.format(report.inverted_faces.before)} before, ` +
                `${numbers.format(report.inverted_faces.after)} after`],
            ['solver', `${report.solver.name}, ${report.solver.iterations} iterations`],
            ['relative residual', report.solver.relative_residual.toExponential(1)],
            ...(report.voxels ? [] : [
                ['vertices', numbers.format(output.vertices)],
                ['triangles', numbers.format(output.triangles)],
            ]),
        ]),
    ];
    if (report.voxels) parts.push(voxelTable(report.voxels));
    const measured = report.milliseconds ?? times;
    if (measured) parts.push(...stageTable(measured));
    if (report.warnings?.length) {
        const list = element('ul');
        list.className = 'warnings';
        list.append(...report.warnings.map((text) => element('li', text)));
        parts.push(list);
    }
    target.replaceChildren(...parts);
}
