// SPDX-License-Identifier: GPL-3.0-or-later
// The runs, newest first: outcome, recommended model with its verdict, report, downloads.
import { byId, make, setText } from './dom.js';
import { localTime } from './units.js';

/** Sign beside a grade or an outcome, so that colour is not the only one. */
const kSigns = { good: '\u2713', usable: '\u2248', rejected: '\u2715' };
const kInProgress = 'in_progress';

export class RunsView {
  constructor() {
    this.shown = null;
    this.runs = null;
    this.fitting = [];
  }

  /** @param fitting  ids of runs whose models are being fitted */
  fits(fitting) {
    if (JSON.stringify(fitting) === JSON.stringify(this.fitting)) return;
    this.fitting = fitting;
    if (this.runs) this.show(this.runs);
  }

  /** @param runs  answer of /api/runs */
  show(runs) {
    this.runs = runs;
    const wanted = JSON.stringify([runs, this.fitting]);
    if (wanted === this.shown) return;
    this.shown = wanted;
    setText(byId('runs-note'), runs.length === 0 ? 'No runs yet. eha run EXPERIMENT.toml plays one.' : '');
    const open = new Set([...document.querySelectorAll('#runs details[open]')].map((element) => element.dataset.run));
    byId('runs').replaceChildren(...runs.map((run) => item(run, open.has(run.id), this.fitting.includes(run.id))));
  }
}

function item(run, isOpen, isFitted) {
  const isChosen = Boolean(run.recommended);
  return make('li', { 'data-run': run.id },
    make('p', { class: 'title' }, make('strong', {}, run.name || run.id), ` ${run.started ? localTime(run.started) : ''} `, tag(run)),
    ['unreadable', kInProgress].includes(run.outcome) ? null : make('p', {}, recommendation(run, isFitted)),
    run.reason ? make('p', { class: 'note' }, `${isChosen ? 'chosen as' : 'because'}: ${run.reason}`) : null,
    run.note || run.error ? make('p', { class: 'note' }, run.note || run.error) : null,
    make('div', { class: 'links' }, reportLink(run), downloads(run, isOpen)));
}

function reportLink(run) {
  if (!run.has_report) return null;
  return make('a', { href: `runs/${encodeURIComponent(run.id)}/report.html`, target: '_blank', rel: 'noopener' },
    'report', make('span', { class: 'unseen' }, ` of ${run.id}, in a new tab`));
}

function tag(run) {
  const isPlain = ['completed', 'precise_enough'].includes(run.outcome) || run.outcome === kInProgress;
  return make('span', { class: `tag ${isPlain ? '' : 'not-completed'}` }, run.outcome.replaceAll('_', ' '));
}

function recommendation(run, isFitted) {
  if (isFitted) return make('span', { class: 'grade' }, 'fitting');
  if (run.recommended) {
    return make('span', { class: `grade ${run.grade}` }, `${kSigns[run.grade] ?? ''} recommended: ${run.recommended} (${run.grade})`);
  }
  if (run.measured) return make('span', { class: 'grade' }, run.measured);
  if (run.grade === 'rejected') return make('span', { class: 'grade rejected' }, `${kSigns.rejected} none accepted`);
  return make('span', { class: 'grade' }, 'not fitted');
}

function downloads(run, isOpen) {
  const files = run.files ?? [];
  if (files.length === 0) return null;
  const links = files.map((file) => make('li', {},
    make('a', { href: `runs/${encodeURIComponent(run.id)}/files/${file.split('/').map(encodeURIComponent).join('/')}`, download: '' }, file)));
  return make('details', { 'data-run': run.id, open: isOpen ? '' : null },
    make('summary', {}, `${files.length === 1 ? '1 file' : `${files.length} files`}`,
      make('span', { class: 'unseen' }, ` of ${run.id}`)),
    make('ul', { class: 'files' }, ...links));
}
