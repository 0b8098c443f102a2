// The options form, built from GET /v1/options. What is left alone is not sent: the server's
// default, which depends on the preset, shows as the placeholder.
const titles = {input: 'Input', method: 'Method', output: 'Output', run: 'Run'};

const words = (name) => name.replaceAll('_', ' ');

export class OptionsForm {
    constructor(form, options, changed) {
        this.form = form;
        this.options = options;
        this.inputs = new Map();
        this.changed = changed;
        const first = options.find(({name}) => name === 'preset');
        if (first) form.append(this.field(first));
        for (const group of ['output', 'input', 'method', 'run']) this.addGroup(group);
        form.addEventListener('input', () => this.update());
        form.addEventListener('submit', (event) => event.preventDefault());
        this.update();
    }

    addGroup(group) {
        const members = this.options.filter((one) => one.group === group && one.name !== 'preset');
        if (!members.length) return;
        const details = document.createElement('details');
        const summary = document.createElement('summary');
        summary.append(titles[group] ?? group, ' ', document.createElement('span'));
        details.append(summary, ...members.map((option) => this.field(option)));
        this.form.append(details);
    }

    field(option) {
        const row = document.createElement('div');
        row.className = 'field';
        row.title = option.description;
        const label = document.createElement('label');
        label.textContent = words(option.name);
        label.htmlFor = `option-${option.name}`;
        const input = this.input(option);
        input.id = label.htmlFor;
        input.name = option.name;
        row.append(label, input);
        this.inputs.set(option.name, {option, input, row});
        return row;
    }

    input(option) {
        const values = option.type === 'flag' ? ['true', 'false'] : option.values;
        if (option.type === 'choice' || option.type === 'flag') {
            const select = document.createElement('select');
            select.append(new Option('', ''), ...values.map((value) => new Option(value, value)));
            return select;
        }
        const input = document.createElement('input');
        input.autocomplete = 'off';
        input.spellcheck = false;
        return input;
    }

    preset() {
        return this.inputs.get('preset')?.input.value ?? '';
    }

    defaultOf(option) {
        const value = option.presets?.[this.preset()] ?? option.default;
        if (value === null || value === undefined) return '';
        return typeof value === 'object' ? JSON.stringify(value) : String(value);
    }

    // Whether an option that needs another one beside it has an effect now: "format=raw", or
    // "output=vox or output=nrrd".
    applies(option) {
        const matches = (option.only_with ?? '').split(' or ')
            .map((text) => /^(\w+)=([\w-]+)$/.exec(text));
        return matches.some((match) => {
            const other = match && this.inputs.get(match[1]);
            return !other || (other.input.value || this.defaultOf(other.option)) === match[2];
        });
    }

    update() {
        for (const {option, input, row} of this.inputs.values()) {
            const value = this.defaultOf(option);
            row.hidden = !this.applies(option);
            row.classList.toggle('changed', !row.hidden && input.value !== '');
            if (input.tagName === 'SELECT') input.options[0].text = `${value || 'automatic'} (default)`;
            else input.placeholder = value;
            input.setCustomValidity(this.problem(option, input.value.trim()));
        }
        for (const details of this.form.querySelectorAll('details')) {
            const count = details.querySelectorAll('.changed').length;
            details.querySelector('summary span').textContent = count ? `${count} changed` : '';
        }
        this.changed();
    }

    // A sentence on what is wrong with a value, as far as the page can tell; the server decides.
    problem(option, text) {
        if (text === '' || option.values?.includes(text)) return '';
        if (option.type !== 'number' && option.type !== 'integer') return '';
        const value = Number(text);
        const whole = option.type !== 'integer' || Number.isInteger(value);
        if (whole && value >= option.minimum && value <= option.maximum) return '';
        const also = option.values ? `, or ${option.values.join(' or ')}` : '';
        return `${words(option.name)} takes a number from ${option.minimum} to ` +
            `${option.maximum}${also}`;
    }

    // The options to send, in the order of the form.
    values() {
        const values = new Map();
        for (const {option, input, row} of this.inputs.values()) {
            const text = input.value.trim();
            if (text !== '' && !row.hidden) values.set(option.name, text);
        }
        return values;
    }

    set(values) {
        for (const [name, {input}] of this.inputs) input.value = values.get(name) ?? '';
        this.update();
    }

    valid() {
        for (const {input, row} of this.inputs.values()) {
            if (row.hidden || input.checkValidity()) continue;
            const details = input.closest('details');
            if (details) details.open = true;
            input.reportValidity();
            return false;
        }
        return true;
    }
}
