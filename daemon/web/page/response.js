// SPDX-License-Identifier: GPL-3.0-or-later
// The measured frequency response: gain and phase with 95 % intervals, noise and distortion as levels in the same plot.
import { byId, make, setAttribute, setText } from './dom.js';
import { axis, colour, plotIn } from './plots.js';
import { count, fixed, isNumber, short } from './units.js';

/** Standard errors in half a 95 % interval. */
const kHalf95 = 1.96;
const kHeight_px = 260;
/** Levels further below the highest gain than this do not widen the plot [dB]. */
const kDeepest_dB = 80;

export class ResponseView {
  constructor() {
    this.lines = [];
    this.widest = { run: null, first: null };
    this.gain = plotIn(byId('gain-plot'), 'gain [dB]', kHeight_px,
      this.options(() => this.gainRange(), (plot) => this.drawGain(plot)), [[], []]);
    this.phase = plotIn(byId('phase-plot'), 'phase [deg]', kHeight_px,
      this.options(() => this.phaseRange(), (plot) => this.drawPhase(plot)), [[], []]);
  }

  /**
   * Shows an answer of /api/response. The response of an earlier run stays until the run of the answer has one.
   * @param isPlayed  whether its run goes on
   */
  show(answer, isPlayed, unit) {
    const hasLines = (answer.lines ?? []).length > 0;
    if (hasLines || !this.kept) {
      if (hasLines) this.kept = answer;
      this.draw(answer, isPlayed, unit, '');
    } else if (answer.run === this.kept.run) {
      this.draw(this.kept, isPlayed, unit, '');
    } else {
      const what = isPlayed ? `Run ${answer.run}, being played, has no response yet` : `Run ${answer.run} has no response`;
      this.draw(this.kept, false, unit, `${what}: ${answer.unknown || 'none'}. Shown below: `);
    }
  }

  /** @param before  what is said before the run's name */
  draw(answer, isPlayed, unit, before) {
    const shift_dB = unit.shift_dB;
    this.lines = (answer.lines ?? []).map((line) => ({
      ...line,
      gain_dB: isNumber(line.magnitude_dB) ? line.magnitude_dB + shift_dB : null,
      gain_half_dB: half(line.magnitude_std_dB),
      phase_half_deg: half(line.phase_std_deg),
    })).filter((line) => line.gain_dB !== null && line.f_Hz > 0);
    this.label(answer, isPlayed, unit, before);
    this.showTable();
    const frequencies = this.lines.map((line) => line.f_Hz);
    this.gain.plot.setData([frequencies, this.lines.map((line) => line.gain_dB)]);
    this.phase.plot.setData([frequencies, this.lines.map((line) => line.phase_deg)]);
    setText(this.gain.caption, `gain [dB re 1 ${unit.name}/V] over frequency [Hz]`);
    setText(this.phase.caption, 'phase [deg] over frequency [Hz]');
    setText(byId('gain-unit'), `${unit.name}/V`);
  }

  label(answer, isPlayed, unit, before) {
    const run = answer.run;
    const periods = answer.periods ?? 0;
    const length = periods === 1 ? '1 period' : `${periods} periods`;
    setText(byId('response-run'), run === null || run === undefined
      ? 'None: it is measured from the second period of an experiment on.'
      : isPlayed ? `Run ${run}, being played: ${length} so far.`
        : before ? `${before}${run}, ${length}.` : `Last run, ${run}: ${length}.`);
    byId('response-plots').hidden = this.lines.length === 0;
    setText(byId('response-rows'), count(answer.rows));
    const band = answer.usable_band_Hz;
    setText(byId('response-band'), band ? `${short(band[0])} .. ${short(band[1])} Hz` : 'none');
    setText(byId('response-known'), answer.unknown || '-');
    setText(byId('response-intervals'), this.intervalText(run, periods));
    setText(byId('response-valve'), this.valveText());
    const card = byId('response-card');
    setAttribute(card, 'data-periods', periods);
    setAttribute(card, 'data-widest-db', this.widestNow()?.gain_half_dB ?? '');
    setAttribute(byId('gain-plot'), 'aria-label', `gain at ${this.lines.length} lines, unit dB of ${unit.name}/V; the table below has the values`);
  }

  /** What of the response the valve's dead band makes. */
  valveText() {
    const known = this.lines.filter((line) => isNumber(line.valve_phase_deg));
    if (known.length === 0) return this.lines.length === 0 ? '-' : 'not known: the rig file has no [following]';
    const most = known.reduce((a, b) => (Math.abs(b.valve_phase_deg) > Math.abs(a.valve_phase_deg) ? b : a));
    const least = known.reduce((a, b) => (b.valve_dB < a.valve_dB ? b : a));
    return `makes up to ${fixed(most.valve_phase_deg, 1, true)} deg of the phase, at ${short(most.f_Hz)} Hz, and ` +
      `${fixed(least.valve_dB, 1, true)} dB of the gain, at ${short(least.f_Hz)} Hz: the valve's, not the rod's; less at larger amplitudes`;
  }

  widestNow() {
    const known = this.lines.filter((line) => line.gain_half_dB !== null);
    return known.reduce((worst, line) => (worst === null || line.gain_half_dB > worst.gain_half_dB ? line : worst), null);
  }

  /** Widest interval now, and what it was when this run first had one. */
  intervalText(run, periods) {
    const widest = this.widestNow();
    if (this.widest.run !== run) this.widest = { run, first: null };
    if (!widest) return run ? 'none before the second period' : '-';
    this.widest.first ??= { half_dB: widest.gain_half_dB, periods };
    const first = this.widest.first;
    const before = first.periods < periods ? `; after ${first.periods} periods \u00b1${short(first.half_dB)} dB` : '';
    return `widest \u00b1${short(widest.gain_half_dB)} dB, at ${short(widest.f_Hz)} Hz${before}`;
  }

  showTable() {
    const cell = (text) => make('td', {}, text);
    byId('response-table').replaceChildren(...this.lines.map((line) => make('tr', {},
      make('th', { scope: 'row' }, short(line.f_Hz)), cell(fixed(line.gain_dB, 2)), cell(fixed(line.gain_half_dB, 2)),
      cell(fixed(line.phase_deg, 1)), cell(fixed(line.phase_half_deg, 1)), cell(fixed(line.valve_phase_deg, 1, true)), cell(fixed(line.noise_dB, 1)),
      cell(fixed(line.distortion_dB, 1)))));
  }

  options(range, draw) {
    return {
      scales: {
        x: { time: false, distr: 3, range: () => this.band() },
        y: { range },
      },
      axes: [axis({ splits: () => marksOf(this.band()), filter: (plot, splits) => splits, values: (plot, splits) => splits.map(short), size: 30 }),
        axis({ size: 52, space: 32 })],
      series: [{}, { paths: () => null, points: { show: false } }],
      hooks: { draw: [draw] },
    };
  }

  /** Frequencies shown: a little more than the lines. */
  band() {
    if (this.lines.length === 0) return [0.01, 10];
    const f = this.lines.map((line) => line.f_Hz);
    return [Math.min(...f) / 1.5, Math.max(...f) * 1.5];
  }

  gainRange() {
    if (this.lines.length === 0) return [-40, 0];
    const top = Math.max(...this.lines.map((line) => line.gain_dB + Math.min(line.gain_half_dB ?? 0, 20)));
    const bottoms = this.lines.flatMap((line) => [
      line.gain_dB - Math.min(line.gain_half_dB ?? 0, 20), level(line, 'noise_dB'), level(line, 'distortion_dB')]);
    const bottom = Math.max(Math.min(...bottoms.filter(isNumber)), top - kDeepest_dB);
    return [bottom - 4, top + 4];
  }

  phaseRange() {
    if (this.lines.length === 0) return [-180, 0];
    const ends = this.lines.flatMap((line) => {
      const reach = Math.min(line.phase_half_deg ?? 0, 60);
      const withoutValve = line.phase_deg - (line.valve_phase_deg ?? 0);
      return [line.phase_deg - reach, line.phase_deg + reach, withoutValve];
    });
    return [Math.min(...ends) - 10, Math.max(...ends) + 10];
  }

  drawGain(plot) {
    const pen = penOf(plot);
    for (const line of this.lines) {
      const x = plot.valToPos(line.f_Hz, 'x', true);
      const y = (value) => plot.valToPos(value, 'y', true);
      const noise = level(line, 'noise_dB');
      const distortion = level(line, 'distortion_dB');
      if (noise !== null) triangle(pen, x, y(noise), colour('--noise'));
      if (distortion !== null) diamond(pen, x, y(distortion), colour('--distortion'));
      interval(pen, x, y(line.gain_dB), line.gain_half_dB, (value) => y(line.gain_dB + value));
    }
    pen.ctx.restore();
  }

  drawPhase(plot) {
    const pen = penOf(plot);
    for (const line of this.lines) {
      if (!isNumber(line.phase_deg)) continue;
      const x = plot.valToPos(line.f_Hz, 'x', true);
      const y = (value) => plot.valToPos(line.phase_deg + value, 'y', true);
      interval(pen, x, y(0), line.phase_half_deg, y);
      if (isNumber(line.valve_phase_deg)) square(pen, x, y(-line.valve_phase_deg), colour('--volts'));
    }
    pen.ctx.restore();
  }
}

function half(std) {
  return isNumber(std) ? kHalf95 * std : null;
}

/** Noise or distortion, which are told below the output at the line, as a level beside the gain [dB]. */
function level(line, name) {
  return isNumber(line[name]) ? line.gain_dB + line[name] : null;
}

/** Round frequencies of a logarithmic axis: 1, 2 and 5 of each decade, or the decades alone where there are many. */
function marksOf([lowest_Hz, highest_Hz]) {
  const decades = Math.log10(highest_Hz / lowest_Hz);
  const digits = decades > 2.5 ? [1] : [1, 2, 5];
  const marks = [];
  for (let decade = Math.floor(Math.log10(lowest_Hz)); 10 ** decade <= highest_Hz; ++decade) {
    for (const digit of digits) marks.push(Number(`${digit}e${decade}`));
  }
  return marks.filter((mark_Hz) => mark_Hz >= lowest_Hz && mark_Hz <= highest_Hz);
}

/** Context within the plot's frame, saved. */
function penOf(plot) {
  const { ctx, bbox } = plot;
  ctx.save();
  ctx.beginPath();
  ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
  ctx.clip();
  return { ctx, unit: devicePixelRatio };
}

/** Point with a bar of +-half. @param at  place of a difference from the point */
function interval({ ctx, unit }, x, y, half_value, at) {
  ctx.strokeStyle = ctx.fillStyle = colour('--rod');
  ctx.lineWidth = 1.5 * unit;
  if (half_value !== null) {
    const [low, high] = [at(-half_value), at(half_value)];
    const cap = 4 * unit;
    ctx.beginPath();
    ctx.moveTo(x, low);
    ctx.lineTo(x, high);
    for (const end of [low, high]) {
      ctx.moveTo(x - cap, end);
      ctx.lineTo(x + cap, end);
    }
    ctx.stroke();
  }
  ctx.beginPath();
  ctx.arc(x, y, 3.5 * unit, 0, 2 * Math.PI);
  ctx.fill();
}

function triangle({ ctx, unit }, x, y, paint) {
  const r = 4.5 * unit;
  shape(ctx, paint, [[x - r, y - r], [x + r, y - r], [x, y + r]], unit);
}

function square({ ctx, unit }, x, y, paint) {
  const r = 4 * unit;
  shape(ctx, paint, [[x - r, y - r], [x + r, y - r], [x + r, y + r], [x - r, y + r]], unit);
}

function diamond({ ctx, unit }, x, y, paint) {
  const r = 4.5 * unit;
  shape(ctx, paint, [[x, y - r], [x + r, y], [x, y + r], [x - r, y]], unit);
}

/** Outline of a mark, hollow. */
function shape(ctx, paint, corners, unit) {
  ctx.strokeStyle = paint;
  ctx.lineWidth = 1.5 * unit;
  ctx.beginPath();
  corners.forEach(([x, y], i) => (i === 0 ? ctx.moveTo(x, y) : ctx.lineTo(x, y)));
  ctx.closePath();
  ctx.stroke();
}
