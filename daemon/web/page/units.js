// SPDX-License-Identifier: GPL-3.0-or-later
// Numbers as people read them: lengths in the rig's unit, durations, times of day.

const kMetres = { mm: 1e-3, cm: 1e-2, m: 1, in: 0.0254 };
const kDecimals = { mm: 2, cm: 3, m: 5, in: 3 };
const kMissing = '-';

/** Unit in which lengths are shown; the interface has them in inches. */
export class LengthUnit {
  /** @param name  mm, cm, m or in; in for anything else */
  constructor(name) {
    this.name = name in kMetres ? name : 'in';
    this.factor = kMetres.in / kMetres[this.name];
    this.decimals = kDecimals[this.name];
  }

  /** Length without its unit, "-" for none. @param length_in  [in] or null */
  number(length_in, signed = false) {
    if (!isNumber(length_in)) return kMissing;
    return fixed(length_in * this.factor, this.decimals, signed);
  }

  text(length_in) {
    return isNumber(length_in) ? `${this.number(length_in)} ${this.name}` : kMissing;
  }

  /** What the gain in dB of in/V changes by in this unit. */
  get shift_dB() {
    return 20 * Math.log10(this.factor);
  }
}

export function isNumber(value) {
  return typeof value === 'number' && Number.isFinite(value);
}

/** Decimal number of a fixed number of places; without "-0.00", "-" for none. */
export function fixed(value, places, signed = false) {
  if (!isNumber(value)) return kMissing;
  const text = value.toFixed(places);
  const isZero = Number(text) === 0;
  const digits = isZero ? text.replace('-', '') : text;
  return signed && value > 0 && !isZero ? `+${digits}` : digits;
}

/** Three significant digits without an exponent. */
export function short(value) {
  return isNumber(value) ? String(Number(value.toPrecision(3))) : kMissing;
}

/** Whole number with narrow spaces between thousands. */
export function count(value) {
  return isNumber(value) ? Math.round(value).toString().replace(/\B(?=(\d{3})+$)/g, '\u202f') : kMissing;
}

/** "47 s", "2 min 05 s", "1 h 02 min". @param seconds  rounded up, so that 0 s means over */
export function duration(seconds) {
  if (!isNumber(seconds)) return kMissing;
  const whole = Math.max(0, Math.ceil(seconds));
  const two = (value) => String(value).padStart(2, '0');
  if (whole < 60) return `${whole} s`;
  if (whole < 3600) return `${Math.floor(whole / 60)} min ${two(whole % 60)} s`;
  return `${Math.floor(whole / 3600)} h ${two(Math.floor((whole % 3600) / 60))} min`;
}

/** Date and time of day here. @param text  ISO 8601; what cannot be read is returned as it is */
export function localTime(text) {
  const date = new Date(text ?? '');
  if (Number.isNaN(date.getTime())) return text ?? kMissing;
  const two = (value) => String(value).padStart(2, '0');
  return `${date.getFullYear()}-${two(date.getMonth() + 1)}-${two(date.getDate())} ${timeOfDay(date)}`;
}

export function timeOfDay(date) {
  const two = (value) => String(value).padStart(2, '0');
  return `${two(date.getHours())}:${two(date.getMinutes())}:${two(date.getSeconds())}`;
}

export function median(values) {
  if (values.length === 0) return NaN;
  const sorted = [...values].sort((a, b) => a - b);
  const middle = sorted.length >> 1;
  return sorted.length % 2 ? sorted[middle] : 0.5 * (sorted[middle - 1] + sorted[middle]);
}
