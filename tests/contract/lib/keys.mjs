// Servers with API keys.
import {createHash, randomBytes} from 'node:crypto';
import {useFakeServer, useFolder, writeFile} from './server.mjs';

export const hashOf = (key) => createHash('sha256').update(key).digest('hex');

// A server whose key file has these names with these settings; the keys are made here.
export function useKeys(settings, args = []) {
  const names = Object.keys(settings);
  const keys = Object.fromEntries(names.map((name) => [name, randomBytes(16).toString('hex')]));
  const lines = names.map((name) =>
    `${name} sha256:${hashOf(keys[name])} ${settings[name]}`.trim()
  );
  const file = writeFile(useFolder(), 'keys', `# keys of a test\n\n${lines.join('\n')}\n`);
  return {server: useFakeServer(['--api-keys', file, ...args]), keys, file};
}
