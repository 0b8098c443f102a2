// Reads the Prometheus text format, and accepts nothing that is not of it.
import assert from 'node:assert/strict';

const kSample = /^([a-zA-Z_:][a-zA-Z0-9_:]*)(\{(.*)\})? (-?[0-9.]+(?:e[+-]?[0-9]+)?|NaN|[+-]Inf)$/;
const kLabel = /^([a-zA-Z_][a-zA-Z0-9_]*)="((?:[^"\\\n]|\\["\\n])*)"(?:,|$)/;

function readLabels(text) {
  const labels = {};
  for (let rest = text; rest;) {
    const match = kLabel.exec(rest);
    assert.ok(match, `labels: ${text}`);
    assert.ok(!(match[1] in labels), `the label ${match[1]} once`);
    labels[match[1]] = match[2];
    rest = rest.slice(match[0].length);
  }
  return labels;
}

// The metrics: a map of names to {type, help, samples: [{name, labels, value}]}.
export function readMetrics(text) {
  assert.ok(text.endsWith('\n'), 'the last line ends');
  const families = new Map();
  const seen = new Set();
  for (const line of text.slice(0, -1).split('\n')) {
    const head = /^# (HELP|TYPE) ([a-zA-Z_:][a-zA-Z0-9_:]*) (.+)$/.exec(line);
    if (head) {
      const family = families.get(head[2]) ?? {samples: []};
      assert.ok(!(head[1].toLowerCase() in family), `${head[1]} of ${head[2]} once`);
      assert.equal(family.samples.length, 0, `${head[1]} before the samples`);
      family[head[1].toLowerCase()] = head[3];
      families.set(head[2], family);
      continue;
    }
    const match = kSample.exec(line);
    assert.ok(match, `a sample: ${line}`);
    const base = families.has(match[1]) ? match[1] : match[1].replace(/_(bucket|sum|count)$/, '');
    const family = families.get(base);
    assert.ok(family?.type, `a type before ${line}`);
    assert.ok(!seen.has(`${match[1]}${match[2]}`), `${line} once`);
    seen.add(`${match[1]}${match[2]}`);
    family.samples.push({
      name: match[1],
      labels: readLabels(match[3]),
      value: Number(match[4].replace('Inf', 'Infinity')),
    });
  }
  return families;
}

// The sum of the samples with this name and these labels; 0 if there are none.
export function valueOf(families, name, labels = {}) {
  const base = families.has(name) ? name : name.replace(/_(bucket|sum|count)$/, '');
  const samples = (families.get(base)?.samples ?? []).filter(
    (sample) =>
      sample.name === name &&
      Object.entries(labels).every(([label, value]) => sample.labels[label] === value)
  );
  return samples.reduce((sum, sample) => sum + sample.value, 0);
}
