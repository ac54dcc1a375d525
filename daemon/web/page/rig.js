// SPDX-License-Identifier: GPL-3.0-or-later
// The rig as `eha status` tells it: state, rod, run, lease, sensor, lines.
import { byId, setAttribute, setText, showBanner } from './dom.js';
import { count, duration, fixed, isNumber } from './units.js';

/** What a state means, and the sign beside its word. */
const kStates = {
  faulted: { glyph: '\u2715', meaning: 'nothing moves before eha arm' },
  idle: { glyph: '\u25cb', meaning: 'nothing drives it' },
  armed: { glyph: '\u25d0', meaning: 'ready for a run' },
  ramp_in: { glyph: '\u25b2', meaning: 'the command rises to the first voltage' },
  running: { glyph: '\u25cf', meaning: 'the experiment is played' },
  ramp_out: { glyph: '\u25bc', meaning: 'the command ramps down' },
  safe_stop: { glyph: '\u25a0', meaning: 'made safe at once' },
};

/** Words of the terminal for states whose name is another one. */
const kWords = { idle: 'not armed', ramp_in: 'ramping in', ramp_out: 'ramping out', safe_stop: 'made safe' };

/** A service that has just started has no fault to look for: as `eha status` says it. */
const kStarted = 'ehad has started';

/** State as shown; what no state is, is "unknown". */
export function stateOf(status) {
  return status && status.state in kStates ? status.state : 'unknown';
}

export function isDriven(status) {
  return ['ramp_in', 'running', 'ramp_out'].includes(stateOf(status));
}

export class RigView {
  constructor() {
    this.announced = null;
    this.velocity_percent = 0;
  }

  /** Shows an answer of /api/state. @param travel  {low_in, high_in, warningShare}, or null */
  show(status, unit, travel) {
    const state = stateOf(status);
    const known = kStates[state] ?? { glyph: '?', meaning: '' };
    const reason = typeof status.reason === 'string' ? status.reason : '';
    const isFresh = state === 'faulted' && reason === kStarted;
    const word = isFresh ? kWords.idle : kWords[state] ?? state;
    setText(byId('state-glyph'), isFresh ? kStates.idle.glyph : known.glyph);
    setText(byId('state-word'), word);
    const exploring_s = status.run?.exploring_at_most_s;
    const meaning = exploring_s
      ? `exploring: finds speeds and dead band before the triangles; at most ${fixed(exploring_s / 60, 0)} min`
      : (state === 'idle' || isFresh) && reason ? reason : known.meaning;
    const fitting = status.worker ? `; fitting ${status.worker.entry} "${status.worker.name}"` : '';
    setText(byId('state-meaning'), isDriven(status) ? meaning : meaning + fitting);
    setAttribute(byId('state'), 'data-state', isFresh ? 'idle' : state);
    setText(byId('rig-name'), status.rig.name);
    setText(byId('rig-kind'), status.rig.moves ? `${status.rig.backend}, moves a machine` : `${status.rig.backend}, no machine moves`);
    document.title = `${word} - ${status.rig.name}`;
    showBanner(byId('fault-banner'), state === 'faulted' && !isFresh ? `Faulted: ${reason || 'no reason was given'}. eha arm acknowledges it.` : null);
    this.showRun(status, unit);
    setText(byId('fact-lease'), leaseText(status.lease));
    setText(byId('fact-worker'), status.worker ? `fitting ${status.worker.entry} "${status.worker.name}"` : 'none');
    this.showSensor(status.rod, unit);
    this.showScale(status.rod, unit, travel);
    this.announce(status, word, reason);
  }

  /** Nothing is known of the rig any more: nobody may take the last state for the present one. */
  lose() {
    const state = byId('state');
    const last = state.dataset.state;
    if (last === 'unknown') return;
    setText(byId('state-glyph'), '?');
    setText(byId('state-word'), 'unknown');
    setText(byId('state-meaning'), `last known: ${last}`);
    setAttribute(state, 'data-state', 'unknown');
    document.title = `no contact - ${byId('rig-name').textContent}`;
    this.announced = null;
  }

  showRun(status, unit) {
    const run = status.run;
    setText(byId('fact-run'), run ? `${run.entry} "${run.name}" of ${run.user}`
      : `none; ${status.waiting} waiting, ${status.held} held`);
    const progress = byId('progress');
    progress.hidden = !run;
    if (!run) {
      setText(byId('fact-time'), '-');
      setText(byId('fact-ticks'), '-');
      this.showMotion(null, unit);
      return;
    }
    const left_s = run.experiment_total_s - run.experiment_s;
    setText(byId('fact-time'), run.exploring_at_most_s
      ? `exploring, ${duration(Math.max(0, run.exploring_at_most_s - run.elapsed_s))} at most, then ${duration(left_s)}`
      : `${fixed(run.experiment_s, 1)} of ${fixed(run.experiment_total_s, 1)} s, ${duration(left_s)} left`);
    progress.value = run.experiment_s / Math.max(run.experiment_total_s, 1e-9);
    setText(byId('fact-ticks'), `${count(run.ticks)}: ${count(run.late)} late, ${count(run.skipped)} skipped, ` +
      `latency at most ${fixed(run.latency_max_us, 0)} us`);
    this.showMotion(run, unit);
  }

  showMotion(run, unit) {
    const velocity = run ? run.velocity_in_per_s : null;
    setText(byId('velocity'), isNumber(velocity) ? fixed(velocity * unit.factor, unit.decimals - 1, true) : '-');
    setText(byId('velocity-unit'), `${unit.name}/s`);
    this.velocity_percent = run?.velocity_percent ?? 0;
  }

  showSensor(rod, unit) {
    let sensor = 'not read yet';
    let lines = '-';
    if (rod && rod.error) sensor = rod.error;
    if (rod && !rod.error) {
      const noise = isNumber(rod.noise_in) ? `, noise ${Number((rod.noise_in * unit.factor).toPrecision(2))} ${unit.name} RMS` : '';
      sensor = `${fixed(rod.feedback_V, 4, true)} V, code ${rod.feedback_code}${noise}` +
        (rod.at_rail ? ', AT THE END OF THE CONVERTER' : '');
      lines = lineText(rod);
    }
    setText(byId('fact-sensor'), sensor);
    setText(byId('fact-lines'), lines);
  }

  showScale(rod, unit, travel) {
    setText(byId('travel-min'), travel ? unit.text(travel.low_in) : '-');
    setText(byId('travel-max'), travel ? unit.text(travel.high_in) : '-');
    const bar = byId('bar');
    bar.hidden = !travel;
    if (travel) {
      setAttribute(bar, 'aria-valuemin', unit.number(travel.low_in));
      setAttribute(bar, 'aria-valuemax', unit.number(travel.high_in));
      const width = `${50 * (1 - travel.warningShare)}%`;
      byId('warning-low').style.width = byId('warning-high').style.width = width;
      setText(byId('warning-text'), `hatched: over ${fixed(100 * travel.warningShare, 0)} %`);
    }
    setText(byId('displacement-unit'), unit.name);
    if (!rod || rod.error) this.showRod(null, unit, travel);
    const nearLimit = rod && !rod.error && rod.near_limit;
    const isFast = travel && this.velocity_percent > 100 * travel.warningShare;
    const upper = travel && rod && rod.displacement_in > 0.5 * (travel.low_in + travel.high_in);
    showBanner(byId('limit-banner'), nearLimit
      ? `Near a limit: ${fixed(rod.travel_percent, 0)} % of the way to the ${upper ? 'upper' : 'lower'} travel limit; 100 % trips`
      : isFast ? `Near a limit: ${fixed(this.velocity_percent, 0)} % of the velocity limit; 100 % trips` : null);
  }

  /** Moves the rod on its bar. @param displacement_in  null: it cannot be read */
  showRod(displacement_in, unit, travel) {
    setText(byId('displacement'), unit.number(displacement_in));
    const head = byId('head');
    const shaft = byId('shaft');
    const isKnown = isNumber(displacement_in) && travel !== null;
    head.hidden = shaft.hidden = !isKnown;
    if (!isKnown) return;
    const share = (displacement_in - travel.low_in) / (travel.high_in - travel.low_in);
    const place = `${(100 * Math.min(1, Math.max(0, share))).toFixed(2)}%`;
    head.style.left = place;
    shaft.style.width = place;
    const bar = byId('bar');
    setAttribute(bar, 'aria-valuenow', unit.number(displacement_in));
    setAttribute(bar, 'aria-valuetext', unit.text(displacement_in));
    bar.classList.toggle('near', Math.abs(2 * share - 1) > travel.warningShare);
  }

  showVolts(volts) {
    setText(byId('volts'), fixed(volts, 2, true));
  }

  /** Tells screen readers what has changed; faults and limits are banners, which they read by themselves. */
  announce(status, state, reason) {
    const run = status.run ? `, experiment ${status.run.entry} ${status.run.name}` : '';
    const words = `state ${kWords[state] ?? state}${run}${state === 'idle' && reason ? `: ${reason}` : ''}`;
    if (words !== this.announced) setText(byId('said'), words);
    this.announced = words;
  }
}

function leaseText(lease) {
  return lease ? `held by ${lease.user}, ${duration(lease.remaining_s)} left` : 'none';
}

function lineText(rod) {
  const named = (value, name, whenTrue, whenFalse) =>
    `${name} ${value === null || value === undefined ? 'none' : value ? whenTrue : whenFalse}`;
  return `inputs 0x${(rod.digital_inputs >>> 0).toString(16).padStart(8, '0')}, ` +
    `${named(rod.emergency_stop_open, 'emergency stop', 'OPEN', 'closed')}, ` +
    named(rod.enable_contact_closed, 'enable contact', 'closed', 'open');
}
