// SPDX-License-Identifier: GPL-3.0-or-later
// Polling of eha-web, and the finding that it or ehad no longer answers.
import { byId, showBanner } from './dom.js';
import { timeOfDay } from './units.js';

/** An answer that takes longer counts as none [ms]; what is computed or read from disk may take longer. */
const kPatience_ms = 700;
const kLongPatience_ms = 10000;
/** Without any answer for this long eha-web is lost [ms]; it is said within 1 s. */
const kLost_ms = 850;
const kLook_ms = 100;
/** This many refused connections, without an answer between them, are enough. */
const kRefusals = 2;
/** Least time from one request to the next after one that failed [ms]. */
const kAfterFailure_ms = 500;

/** @returns the answer's JSON. @throws Error  no answer in time, or a refusal with its sentence */
async function fetchJson(path, patience_ms) {
  const response = await fetch(path, { signal: AbortSignal.timeout(patience_ms), cache: 'no-store' });
  if (!response.ok) {
    const answer = await response.json().catch(() => ({}));
    throw new Error(answer.error ?? `${path}: HTTP ${response.status}`);
  }
  return response.json();
}

/** Whether eha-web and ehad answer; says it when they do not, and when they do again. */
export class Contact {
  /** @param onChange  called with `isLive`: whether what is shown is of now */
  constructor(onChange) {
    this.onChange = onChange;
    this.lastAnswer_ms = performance.now();
    this.refusals = 0;
    this.web = true;
    this.daemon = true;
    this.since = null;
    setInterval(() => this.look(), kLook_ms);
    document.addEventListener('visibilitychange', () => {
      this.lastAnswer_ms = performance.now();
    });
  }

  get isLive() {
    return this.web && this.daemon;
  }

  answered() {
    this.lastAnswer_ms = performance.now();
    this.refusals = 0;
    if (!this.web) this.change(true, this.daemon);
  }

  /** A connection was refused: nobody listens there. */
  refused() {
    if (++this.refusals >= kRefusals && this.web) this.change(false, this.daemon);
  }

  daemonIs(connected) {
    if (connected !== this.daemon) this.change(this.web, connected);
  }

  look() {
    if (document.hidden || !this.web) return;
    if (performance.now() - this.lastAnswer_ms > kLost_ms) this.change(false, this.daemon);
  }

  change(web, daemon) {
    if (this.isLive) this.since = timeOfDay(new Date());
    this.web = web;
    this.daemon = daemon;
    const banner = byId('contact-banner');
    if (!web) {
      showBanner(banner, `No contact with eha-web since ${this.since}. The values below are old, and Stop does not ` +
        'reach the rig from here: use the emergency stop, or eha stop at the rig. Trying again.');
    } else if (!daemon) {
      showBanner(banner, `ehad does not answer since ${this.since}. The values below are old. When ehad ends, ` +
        'eha-safe switches the hydraulics off; systemctl status ehad tells why it ended. Trying again.');
    } else {
      showBanner(banner, null);
    }
    this.onChange(this.isLive);
  }
}

/** Asks for `path` every `period_ms`, one request at a time; failures are left to Contact. */
export class Poller {
  /** @param path  text, or a function that gives it @param onAnswer  called with the answer @param onRefused  called without one, where nobody listens */
  constructor(path, period_ms, onAnswer, onRefused) {
    this.path = path;
    this.period_ms = period_ms;
    this.onAnswer = onAnswer;
    this.onRefused = onRefused;
    this.timer = null;
    this.patience_ms = period_ms < kPatience_ms ? kPatience_ms : kLongPatience_ms;
    this.isAsking = false;
    this.isWantedAgain = false;
    document.addEventListener('visibilitychange', () => this.askNow());
    this.askNow();
  }

  /** Asks at once instead of at the next turn. */
  askNow() {
    this.isWantedAgain = this.isAsking;
    if (this.isAsking || document.hidden) return;
    clearTimeout(this.timer);
    this.ask();
  }

  async ask() {
    const started_ms = performance.now();
    this.isAsking = true;
    let period_ms = this.period_ms;
    try {
      const answer = await fetchJson(typeof this.path === 'function' ? this.path() : this.path, this.patience_ms);
      this.onAnswer(answer);
    } catch (fault) {
      if (fault instanceof TypeError) this.onRefused();
      else if (fault.name !== 'TimeoutError') console.warn(fault.message);
      period_ms = Math.max(period_ms, kAfterFailure_ms);
    }
    this.isAsking = false;
    const wait_ms = this.isWantedAgain ? 0 : Math.max(0, period_ms - (performance.now() - started_ms));
    this.isWantedAgain = false;
    if (!document.hidden) this.timer = setTimeout(() => this.ask(), wait_ms);
  }
}
