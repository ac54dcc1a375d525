// SPDX-License-Identifier: GPL-3.0-or-later
// The last 60 s of displacement and volts: each block of ticks as the band between its least and its greatest value.
import { byId, setAttribute, setText } from './dom.js';
import { axis, colour, plotIn, SteadyRange } from './plots.js';
import { fixed, isNumber, median } from './units.js';

const kWindow_s = 60;
/** A pause between blocks that is drawn as a gap [s]. */
const kGap_s = 1;
/** After a longer pause between answers, as of a hidden tab, blocks are neither lost nor late [ms]. */
const kPause_ms = 2000;
const kHeight_px = 200;
/** Delays that the median is taken of, at most and at least. */
const kDelays = 200;
const kFewestDelays = 20;

export class LivePlots {
  constructor() {
    this.next = -1;
    this.blocks = [];
    this.delays_ms = [];
    this.drawn_ns = 0;
    this.taken_ms = -Infinity;
    this.lost = 0;
    this.unit = null;
    this.travel = null;
    this.x_range = new SteadyRange(1);
    this.v_range = new SteadyRange(1);
    this.volts = plotIn(byId('volts-plot'), 'applied [V]', kHeight_px, this.options('--volts', this.v_range, 1), empty());
  }

  /** Address of the next request: only what is not here yet. */
  path() {
    return `api/live?since=${this.next}`;
  }

  /** @param travel  {low_in, high_in, warningShare}, or null */
  show(unit, travel) {
    this.travel = travel;
    if (this.unit?.name === unit.name) return;
    this.unit = unit;
    this.x_range = new SteadyRange(0.2 * unit.factor);
    const options = this.options('--rod', this.x_range, 0.1 * unit.factor);
    options.hooks = { drawAxes: [(plot) => this.drawTravel(plot)] };
    this.place = plotIn(byId('displacement-plot'), `displacement [${unit.name}]`, kHeight_px, options, empty());
  }

  /** Takes an answer of /api/live. */
  take(answer) {
    const restarted = answer.next < this.next;
    if (restarted) this.blocks = [];
    const asked = this.next;
    this.next = restarted ? -1 : answer.next;
    const isSteady = performance.now() - this.taken_ms < kPause_ms;
    this.taken_ms = performance.now();
    if (restarted) return;
    if (isSteady && asked >= 0) this.lost += answer.dropped ?? 0;
    for (const [, x_min, x_max, v_min, v_max, wall_ns] of answer.blocks) {
      this.blocks.push({ at_s: wall_ns * 1e-9, x_min, x_max, v_min, v_max, wall_ns });
    }
    this.now_s = answer.now_ns * 1e-9;
    const oldest_s = this.now_s - kWindow_s - 1;
    let stale = 0;
    while (stale < this.blocks.length && this.blocks[stale].at_s < oldest_s) ++stale;
    if (stale > 0) this.blocks.splice(0, stale);
    this.wantFrame(isSteady && asked >= 0);
  }

  /** Newest block, or null where none is younger than a gap. */
  newest() {
    const last = this.blocks.at(-1);
    return last && this.now_s - last.at_s < kGap_s ? last : null;
  }

  /** Draws with the next frame of the screen. */
  wantFrame(isCurrent) {
    if (this.frame) return;
    this.frame = requestAnimationFrame(() => {
      this.frame = null;
      this.draw();
      this.noteDelay(isCurrent);
    });
  }

  draw() {
    const [t, x_min, x_max, v_min, v_max] = [[], [], [], [], []];
    const factor = this.unit?.factor ?? 1;
    const scaled = (value, by) => (isNumber(value) ? value * by : null);
    let before_s = null;
    for (const block of this.blocks) {
      if (before_s !== null && block.at_s - before_s > kGap_s) {
        t.push(before_s - this.now_s + 0.001);
        for (const column of [x_min, x_max, v_min, v_max]) column.push(null);
      }
      before_s = block.at_s;
      t.push(block.at_s - this.now_s);
      x_min.push(scaled(block.x_min, factor));
      x_max.push(scaled(block.x_max, factor));
      v_min.push(scaled(block.v_min, 1));
      v_max.push(scaled(block.v_max, 1));
    }
    this.place?.plot.setData([t, x_min, x_max]);
    this.volts.plot.setData([t, v_min, v_max]);
    const note = this.blocks.length === 0 ? 'No samples yet.'
      : this.lost > 0 ? `${this.lost} blocks of samples did not reach this page.` : '';
    setText(byId('live-note'), note);
    setAttribute(byId('live-card'), 'data-blocks', this.blocks.length);
    setAttribute(byId('live-card'), 'data-newest-ns', this.blocks.at(-1)?.wall_ns ?? 0);
  }

  /** From each new block's last tick to its drawing, by this machine's clock. */
  noteDelay(isCurrent) {
    const drawn_ms = Date.now();
    const fresh = isCurrent ? this.blocks.filter((block) => block.wall_ns > this.drawn_ns) : [];
    for (const block of fresh) this.delays_ms.push(drawn_ms - block.wall_ns * 1e-6);
    this.drawn_ns = this.blocks.at(-1)?.wall_ns ?? 0;
    this.delays_ms.splice(0, Math.max(0, this.delays_ms.length - kDelays));
  }

  /** "" before there are some, and where this machine's clock is not the rig's. */
  delayText() {
    const delay_ms = median(this.delays_ms);
    if (this.delays_ms.length < kFewestDelays || !(delay_ms >= 0 && delay_ms < 5000)) return '';
    return `From a sample to this page: ${fixed(delay_ms, 0)} ms, the median of ${this.delays_ms.length}.`;
  }

  options(name, range, least) {
    const stroke = () => colour(name);
    const line = { stroke, width: 1.5, points: { show: false } };
    return {
      scales: {
        x: { time: false, range: [-kWindow_s, 0] },
        y: { range: (plot, low, high) => (low === null ? [0, least] : range.around(low, high)) },
      },
      axes: [
        axis({ values: (plot, splits) => splits.map((at_s) => (at_s === 0 ? 'now' : `${at_s} s`)), size: 30, space: 64 }),
        axis({ size: 56, space: 32 }),
      ],
      series: [{}, line, { ...line }],
      bands: [{ series: [2, 1], fill: stroke }],
    };
  }

  /** The warning bands and the limits of the travel, where they are within the plot. */
  drawTravel(plot) {
    if (!this.travel) return;
    const { ctx, bbox } = plot;
    const low = this.travel.low_in * this.unit.factor;
    const high = this.travel.high_in * this.unit.factor;
    const band = 0.5 * (1 - this.travel.warningShare) * (high - low);
    ctx.save();
    ctx.beginPath();
    ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
    ctx.clip();
    for (const [limit, edge] of [[low, low + band], [high, high - band]]) {
      const from = plot.valToPos(limit, 'y', true);
      const to = plot.valToPos(edge, 'y', true);
      ctx.fillStyle = colour('--warn-ground');
      ctx.fillRect(bbox.left, Math.min(from, to), bbox.width, Math.abs(to - from));
      ctx.strokeStyle = colour('--bad');
      ctx.lineWidth = 2 * devicePixelRatio;
      ctx.setLineDash([6 * devicePixelRatio, 4 * devicePixelRatio]);
      ctx.beginPath();
      ctx.moveTo(bbox.left, from);
      ctx.lineTo(bbox.left + bbox.width, from);
      ctx.stroke();
    }
    ctx.restore();
  }
}

function empty() {
  return [[], [], []];
}
