// SPDX-License-Identifier: GPL-3.0-or-later
// The queue, as `eha queue` tells it: what is not over, and the last few that are.
import { byId, make, setText } from './dom.js';

const kMostOver = 5;

export class QueueView {
  constructor() {
    this.shown = null;
  }

  /** @param entries  as in the protocol, oldest first @param leftOut  how many are over and not among them */
  show(entries, leftOut) {
    let over = 0;
    const rows = [...entries].reverse().filter((entry) => !isOver(entry) || ++over <= kMostOver);
    const earlier = Math.max(0, over - kMostOver) + leftOut;
    const wanted = JSON.stringify([rows, earlier]);
    if (wanted === this.shown) return;
    this.shown = wanted;
    setText(byId('queue-note'), rows.length === 0 ? 'No experiments in the queue.'
      : earlier > 0 ? `${earlier} earlier ones are over: eha queue --json lists them.` : '');
    byId('queue').replaceChildren(...rows.map((entry) => make('li', {},
      make('p', { class: 'title' }, make('strong', {}, `${entry.entry} "${entry.name}"`), ` of ${entry.user} `,
        make('span', { class: `tag ${entry.state}` }, entry.state)),
      said(entry) ? make('p', { class: 'note' }, said(entry)) : null)));
  }
}

function isOver(entry) {
  return entry.state === 'over' || entry.state === 'cancelled';
}

function said(entry) {
  if (entry.state === 'waiting' || entry.state === 'held') return `waits for ${entry.waits_for ?? ''}`;
  return entry.state === 'running' ? '' : verdictText(entry);
}

/** Outcome, accepted models, and what there is to say. */
function verdictText(entry) {
  const models = entry.models ?? [];
  const accepted = models.filter((model) => model.accepted).map((model) => model.name);
  const verdict = accepted.length > 0 ? `accepted: ${accepted.join(', ')}` : models.length > 0 ? 'all rejected' : '';
  const text = [entry.outcome, verdict].filter(Boolean).join(', ');
  return [text, entry.note].filter(Boolean).join(': ');
}
