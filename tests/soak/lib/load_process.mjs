// Load from a process of its own, so that what measures is not what drives.
import {fork} from 'node:child_process';
import {fileURLToPath} from 'node:url';

export class LoadProcess {
  constructor() {
    this.child = fork(fileURLToPath(new URL('generator.mjs', import.meta.url)));
  }

  get pid() { return this.child.pid; }

  // Starts a run. spec: {address, method, target, vary, bodyFile, watch: pid whose memory is
  // sampled 50 times a second} and either {clients}, a closed loop, or {rate: requests a second,
  // steady}, an open one; and {seconds}, or {most} requests of a closed one, unless `stop` ends it.
  // @return the figures, when it is over
  run(spec) {
    return new Promise((done, fail) => {
      const ended = (code) => fail(new Error(`the generator ended with ${code}`));
      this.child.once('exit', ended);
      this.child.once('message', (figures) => {
        this.child.off('exit', ended);
        done(figures);
      });
      this.child.send(spec);
    });
  }

  stop() { this.child.send('stop'); }
  close() { this.child.disconnect(); }
}
