// The same conversion as an address, as a curl command and as a `rivage` command.
const quote = (text) => /^[\w.,:=/@%+-]+$/.test(text) ? text : `'${text.replaceAll("'", `'\\''`)}'`;

export function query(values) {
    const text = new URLSearchParams([...values]).toString();
    return text ? `?${text}` : '';
}

export function curlCommand(grid, values) {
    const extension = values.get('output') ?? 'glb';
    const name = grid?.name ?? 'grid.vox';
    const stem = name.replace(/\.[^.]*$/, '');
    const lines = [
        `curl --fail-with-body -o ${quote(`${stem}.${extension}`)}`,
        `--data-binary ${quote(`@${name}`)} -H 'Content-Type: application/octet-stream'`,
        quote(`${location.origin}/v1/regularize${query(values)}`),
    ];
    if (grid?.sample)
        lines.unshift(`curl -o ${quote(name)} ${quote(`${location.origin}/v1/samples/${grid.sample}`)} &&`);
    return lines.join(' \\\n  ');
}

export function clientCommand(grid, values) {
    const extension = values.get('output') ?? 'glb';
    const name = grid?.name ?? 'grid.vox';
    const flags = [...values].map(([key, value]) => ` --${key.replaceAll('_', '-')} ${quote(value)}`);
    const server = ` --server ${location.origin}`;
    const convert = `rivage regularize ${quote(name)} ` +
        `-o ${quote(name.replace(/\.[^.]*$/, `.${extension}`))}${server}${flags.join('')}`;
    if (!grid?.sample) return convert;
    return `rivage sample ${grid.sample} -o ${quote(name)}${server} &&\n  ${convert}`;
}

// The page's own address with what it shows; only a sample can be opened by whoever gets it.
export function pageLink(grid, values) {
    const all = new Map(values);
    if (grid?.sample) all.set('sample', grid.sample);
    return `${location.origin}${location.pathname}${query(all)}`;
}
