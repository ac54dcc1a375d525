// SPDX-License-Identifier: GPL-3.0-or-later
// The Stop button and its token, which this device keeps. It is asked for when the page opens.
import { byId, setAttribute, setText, showBanner } from './dom.js';
import { stateOf } from './rig.js';

const kKey = 'eha-token';
/** Set in a tab in which the token was not given; Stop still asks. */
const kDeclined = 'eha-token-declined';
const kPatience_ms = 3000;
const kTold_ms = 15000;
const kUnreached = 'NOT STOPPED: the service cannot be reached from this page. Use the emergency stop at the rig.';

const kEffects = {
  ramping_out: 'The command ramps down. Stop again makes the rig safe at once.',
  safe_at_once: 'The rig is made safe at once.',
  disarmed: 'Nothing was running; the rig is disarmed.',
};

/** @returns {status, error, result} of a POST with the token. @throws Error  no answer */
async function post(path, token) {
  const response = await fetch(path, {
    method: 'POST',
    headers: { 'Content-Type': 'application/json', 'X-Eha-Token': token },
    body: '{}',
    signal: AbortSignal.timeout(kPatience_ms),
  });
  const answer = await response.json().catch(() => ({}));
  return { status: response.status, error: answer.error ?? `HTTP ${response.status}`, result: answer.result };
}

export class StopButton {
  constructor() {
    this.button = byId('stop');
    this.dialog = byId('token-dialog');
    this.isReached = true;
    this.button.addEventListener('click', () => this.press());
    this.hasOpened = false;
    this.isForStop = false;
    this.dialog.addEventListener('close', () => {
      if (this.token === null) sessionStorage.setItem(kDeclined, 'yes');
    });
    byId('token-cancel').addEventListener('click', () => this.dialog.close());
    byId('token-form').addEventListener('submit', (event) => {
      event.preventDefault();
      const token = byId('token').value.trim();
      if (event.submitter?.value === 'keep') this.keep(token);
      else this.stop(token);
    });
    this.show(null);
  }

  get token() {
    return localStorage.getItem(kKey);
  }

  /** Once the rig is shown: asks for the token, or has the kept one checked, which eha-web may have changed. */
  async opened() {
    if (this.hasOpened) return;
    this.hasOpened = true;
    if (this.token === null) {
      if (sessionStorage.getItem(kDeclined) === null) this.open('token-keep');
      return;
    }
    try {
      const answer = await post('api/token', this.token);
      if (answer.status === 401) this.refused(answer, 'The kept token is no longer right');
    } catch {
      // Contact says that eha-web does not answer.
    }
  }

  /** Takes note of whether eha-web and ehad answer; where they do not, no token helps. */
  reaches(isReached) {
    if (isReached && this.wasUnreached) {
      this.wasUnreached = false;
      this.tell('The service is reached again. What was not stopped goes on: press Stop if something moves.', false);
    }
    this.isReached = isReached;
    // The dialog that asks when the page opens is nobody's wish to stop; Contact says that nothing answers.
    if (!isReached && this.dialog.open) {
      if (this.isForStop) this.unreached();
      else this.dialog.close();
    }
    this.show(null);
  }

  unreached() {
    this.wasUnreached = true;
    if (this.dialog.open) this.dialog.close();
    this.tell(kUnreached, true);
  }

  /** Tells on the button what pressing it does now. */
  show(status) {
    const state = stateOf(status);
    if (this.isRamping && (state === 'idle' || state === 'armed' || state === 'faulted')) {
      this.isRamping = false;
      this.tell('Stopped: the command is ramped down.', false);
    }
    const effect = !this.isReached ? 'out of reach: use the emergency stop' : this.token === null ? 'needs the token: enter it now'
      : state === 'ramp_out' ? 'again: safe at once'
        : state === 'running' || state === 'ramp_in' ? 'ramps the command down'
          : state === 'armed' ? 'disarms' : state === 'unknown' ? 'state unknown' : 'nothing is running';
    setText(byId('stop-effect'), effect);
    setAttribute(this.button, 'data-token', this.token === null ? 'missing' : 'kept');
  }

  press() {
    if (this.token !== null) this.stop(this.token);
    else if (this.isReached) this.open('token-stop');
    else this.unreached();
  }

  /** Opens the dialog. @param first  the button that Enter presses: nobody who was not about to stop shall stop */
  open(first) {
    const button = byId(first);
    button.parentElement.prepend(button);
    this.isForStop = first === 'token-stop';
    this.ask('');
  }

  /** Asks for the token. @param fault  why the last one would not do; "": there was none */
  ask(fault) {
    setText(byId('token-fault'), fault);
    setAttribute(byId('token'), 'aria-invalid', fault !== '');
    if (!this.dialog.open) this.dialog.showModal();
    byId('token').focus();
    byId('token').select();
  }

  async stop(token) {
    try {
      const answer = await post('api/stop', token);
      if (answer.status === 200) {
        this.isRamping = answer.result === 'ramping_out';
        this.accepted(token, kEffects[answer.result] ?? 'Stopped.');
      }
      else if (answer.status === 409) this.accepted(token, 'Nothing was running.');
      else this.refused(answer, 'NOT STOPPED');
    } catch {
      this.wasUnreached = true;
      this.tell('NOT STOPPED: eha-web does not answer. Use the emergency stop, or eha stop at the rig.', true);
    }
  }

  /** Has a token checked without stopping, and keeps it. */
  async keep(token) {
    try {
      const answer = await post('api/token', token);
      if (answer.status === 200) this.accepted(token, 'Token kept: Stop now acts at once.');
      else this.refused(answer, 'Not kept');
    } catch {
      this.ask('Not kept: eha-web does not answer.');
    }
  }

  accepted(token, text) {
    localStorage.setItem(kKey, token);
    byId('token').value = '';
    if (this.dialog.open) this.dialog.close();
    this.button.focus();
    this.tell(text, false);
    this.show(null);
  }

  refused(answer, consequence) {
    if (answer.status === 503 || !this.isReached) {
      this.unreached();
    } else if (answer.status === 401) {
      localStorage.removeItem(kKey);
      this.show(null);
      this.ask(`${consequence}: wrong token.`);
    } else if (this.dialog.open) {
      this.ask(`${consequence}: ${answer.error}`);
    } else {
      this.tell(`${consequence}: ${answer.error}`, true);
    }
  }

  /** A sentence beneath the header; good news leaves after a while. */
  tell(text, isBad) {
    const banner = byId('stop-banner');
    banner.classList.toggle('bad', isBad);
    showBanner(banner, text);
    clearTimeout(this.timer);
    if (!isBad) this.timer = setTimeout(() => showBanner(banner, null), kTold_ms);
  }
}
