// SPDX-License-Identifier: GPL-3.0-or-later
// A bench for the tests of the page: ehad on the simulated rig on the real clock, eha-web beside it, Debian's Chromium.
import { execFile, spawn } from 'node:child_process';
import { copyFileSync, mkdirSync, mkdtempSync, readdirSync, readFileSync, rmSync, symlinkSync, writeFileSync } from 'node:fs';
import http from 'node:http';
import net from 'node:net';
import { createRequire } from 'node:module';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { fileURLToPath } from 'node:url';

const kHere = path.dirname(fileURLToPath(import.meta.url));
const kRoot = path.resolve(kHere, '../..');
const kPrograms = path.join(kRoot, 'build/release/bin');
const { chromium } = createRequire(path.join(kRoot, 'build/web/package.json'))('playwright-core');

/** Longest wait for what must happen [ms]; a test that waits longer has failed. */
export const kGenerous_ms = 60000;
export const kScreenshots = path.join(kRoot, 'build/web/screenshots');
export const kExperiment = path.join(kHere, 'short_periodic.toml');
export const kToken = 'a-token-of-the-tests';

/** Waits until `condition` gives something. @returns it @throws Error  it did not in time */
export async function until(what, condition, patience_ms = kGenerous_ms) {
  const deadline = Date.now() + patience_ms;
  for (;;) {
    const found = await condition();
    if (found) return found;
    if (Date.now() > deadline) throw new Error(`not in ${patience_ms} ms: ${what}`);
    await new Promise((resolve) => setTimeout(resolve, 10));
  }
}

export function launchBrowser() {
  return chromium.launch({ executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium', chromiumSandbox: false,
    args: ['--host-resolver-rules=MAP rebound.test 127.0.0.1', '--disable-gpu'] });
}

/** Answer of one HTTP request with any headers, which a browser would not let a script set. */
export function request(port, method, where, headers = {}, body = '') {
  return new Promise((resolve, reject) => {
    const sent = http.request({ host: '127.0.0.1', port, method, path: where, headers }, (answer) => {
      let text = '';
      answer.on('data', (part) => { text += part; });
      answer.on('end', () => resolve({ status: answer.statusCode, headers: answer.headers, text }));
    });
    sent.on('error', reject);
    sent.end(body);
  });
}

/** The two services and the command line, in a folder of their own. */
export class Bench {
  constructor() {
    this.folder = mkdtempSync(path.join(tmpdir(), 'eha-web-'));
    this.socket = path.join(this.folder, 'ehad.sock');
    this.state = path.join(this.folder, 'state');
    this.tokenFile = path.join(this.folder, 'token');
    this.rig = path.join(this.folder, 'rig.toml');
    this.hold = path.join(this.folder, 'hold');
    mkdirSync(kScreenshots, { recursive: true });
    this.placePrograms();
    writeFileSync(this.tokenFile, `${kToken}\n`, { mode: 0o640 });
    // A quiet sensor would have no intervals to speak of; this one is as noisy as a bench's. People read mm.
    writeFileSync(this.rig, readFileSync(path.join(kRoot, 'config/rigs/sim.toml'), 'utf8')
      .replace('sensor_noise_V = 0.001', 'sensor_noise_V = 0.01').replace('# units = "mm"', 'units = "mm"'));
    writeFileSync(path.join(this.folder, 'ehad.toml'), 'schema = 1\n');
    this.logs = '';
  }

  /** The programs in a folder of the bench: ehad takes `eha` from its own, and this one waits where a fit is held. */
  placePrograms() {
    this.programs = path.join(this.folder, 'bin');
    mkdirSync(this.programs);
    for (const name of readdirSync(kPrograms).filter((name) => /^eha(d|-\w+)$/.test(name))) {
      if (name === 'ehad') copyFileSync(path.join(kPrograms, name), path.join(this.programs, name));
      else symlinkSync(path.join(kPrograms, name), path.join(this.programs, name));
    }
    writeFileSync(path.join(this.programs, 'eha'),
      `#!/bin/sh\nif [ "$1" = fit ]; then while [ -e '${this.hold}' ]; do sleep 0.02; done; fi\nexec '${path.join(kPrograms, 'eha')}' "$@"\n`,
      { mode: 0o755 });
  }

  start(program, words) {
    const child = spawn(path.join(this.programs, program), words, { stdio: ['ignore', 'pipe', 'pipe'] });
    child.over = new Promise((resolve) => { child.on('exit', resolve); });
    for (const stream of [child.stdout, child.stderr]) stream.on('data', (text) => { this.logs += `${program}: ${text}`; });
    return child;
  }

  async startDaemon() {
    this.daemon = this.start('ehad', ['--rig', this.rig, '--config', path.join(this.folder, 'ehad.toml'), '--state', this.state,
      '--socket', this.socket, '--allow-non-realtime']);
    await until('ehad answers', () => this.status().catch(() => null));
  }

  async startWeb() {
    this.port ??= await freePort();
    this.web = this.start('eha-web', ['--port', String(this.port), '--socket', this.socket, '--runs', path.join(this.state, 'runs'),
      '--token-file', this.tokenFile]);
    await until('eha-web answers', () => request(this.port, 'GET', '/').catch(() => null));
  }

  get address() {
    return `http://127.0.0.1:${this.port}/`;
  }

  /** What the page itself sends along with a POST, but for the token. */
  headers() {
    const host = `127.0.0.1:${this.port}`;
    return { 'Content-Type': 'application/json', Host: host, Origin: `http://${host}` };
  }

  /** Ends a program at once, as a crash does. */
  async kill(child) {
    child.kill('SIGKILL');
    await child.over;
  }

  async close() {
    for (const child of [this.web, this.daemon]) if (child && child.exitCode === null) await this.kill(child);
    rmSync(this.folder, { recursive: true, force: true });
  }

  /** Runs `eha`. @returns {code, text} */
  eha(...words) {
    return new Promise((resolve) => {
      execFile(path.join(kPrograms, 'eha'), words, { env: { ...process.env, EHA_SOCKET: this.socket }, cwd: this.folder },
        (error, out, err) => resolve({ code: error ? error.code : 0, text: out + err }));
    });
  }

  /** Content of the protocol's `status`. */
  status() {
    return new Promise((resolve, reject) => {
      const connection = net.connect(this.socket);
      let text = '';
      connection.on('connect', () => connection.write('{"id":1,"method":"status"}\n'));
      connection.on('error', reject);
      connection.on('data', (part) => {
        text += part;
        const lines = text.split('\n');
        if (lines.length < 3) return;
        connection.destroy();
        resolve(JSON.parse(lines[1]).result);
      });
    });
  }

  /**
   * Lets the next fit wait before its first instruction, so that what is shown meanwhile does not depend on how long a fit
   * takes. @returns what lets it go on
   */
  holdFit() {
    writeFileSync(this.hold, '');
    return () => rmSync(this.hold);
  }

  async inState(...states) {
    return until(`state ${states.join(' or ')}`, async () => {
      const status = await this.status();
      return states.includes(status.state) && status;
    });
  }
}

function freePort() {
  return new Promise((resolve) => {
    const server = net.createServer().listen(0, '127.0.0.1', () => {
      const { port } = server.address();
      server.close(() => resolve(port));
    });
  });
}
