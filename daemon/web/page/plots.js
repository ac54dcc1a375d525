// SPDX-License-Identifier: GPL-3.0-or-later
// What the plots share: colours of the style sheet, width of the page, axes.
import { make } from './dom.js';

const kFont = '12px system-ui, sans-serif';
/** A scale is narrowed when the values use less than this share of it. */
const kNarrowBelow = 0.5;

const plots = new Set();
const styles = getComputedStyle(document.documentElement);

/** Colour of app.css as it is now, light or dark. @param name  such as --ink */
export function colour(name) {
  return styles.getPropertyValue(name).trim();
}

matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => {
  for (const plot of plots) plot.redraw(true, true);
});

/** Axis in the page's colours. */
export function axis(options) {
  return {
    stroke: () => colour('--ink-2'),
    grid: { stroke: () => colour('--grid'), width: 1 },
    ticks: { stroke: () => colour('--grid'), width: 1, size: 4 },
    font: kFont,
    ...options,
  };
}

/** uPlot in `place`, as wide as it. @param caption  stands above it: quantity and unit */
export function plotIn(place, caption, height, options, data) {
  const text = make('p', { class: 'caption' }, caption);
  place.replaceChildren(text);
  const plot = new uPlot({
    width: Math.max(place.clientWidth, 100),
    height,
    legend: { show: false },
    cursor: { show: false },
    padding: [8, 12, 0, 0],
    ...options,
  }, data, place);
  plots.add(plot);
  new ResizeObserver(() => {
    const width = place.clientWidth;
    if (width > 0 && width !== plot.width) plot.setSize({ width, height });
  }).observe(place);
  return { plot, caption: text };
}

/** Range that holds still: it widens at once, and narrows when the values use less than half of it. */
export class SteadyRange {
  /** @param least  smallest width of the range */
  constructor(least) {
    this.least = least;
    this.range = null;
  }

  /** @returns [lowest, highest] for values from `low` to `high` */
  around(low, high) {
    if (!(low <= high)) return this.range ?? [0, this.least];
    const width = Math.max(high - low, this.least);
    const middle = 0.5 * (low + high);
    const wanted = [middle - 0.6 * width, middle + 0.6 * width];
    const isWithin = this.range && low >= this.range[0] && high <= this.range[1];
    const isTooWide = this.range && width < kNarrowBelow * (this.range[1] - this.range[0]);
    if (!isWithin || isTooWide) this.range = wanted;
    return this.range;
  }
}
