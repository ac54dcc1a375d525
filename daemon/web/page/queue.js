// SPDX-License-Identifier: GPL-3.0-or-later
// The queue, as `eha queue` tells it: what is not over, and the last few that are.
import { byId, make, setText } from './dom.js';

const kMostOver = 5;

export class QueueView {
  constructor() {
    this.shown = null;
  }

  /**
   * Shows first what is played, then what waits in the order in which it will be played, then what is fitted or over, the newest first.
   * @param entries  as in the protocol: what is over, what is played, what waits in its order
   * @param leftOut  how many are over and not among them
   */
  show(entries, leftOut) {
    let over = 0;
    const newestFirst = [...entries].reverse();
    const rows = [...entries.filter((entry) => entry.state === 'running'), ...entries.filter(isQueued),
      ...newestFirst.filter((entry) => entry.state === 'fitting'),
      ...newestFirst.filter((entry) => isOver(entry) && ++over <= kMostOver)];
    let turn = 0;
    const earlier = Math.max(0, over - kMostOver) + leftOut;
    const wanted = JSON.stringify([rows, earlier]);
    if (wanted === this.shown) return;
    this.shown = wanted;
    setText(byId('queue-note'), rows.length === 0 ? 'No experiments in the queue.'
      : earlier > 0 ? `${earlier} earlier ones are over: eha queue --json lists them.` : '');
    byId('queue').replaceChildren(...rows.map((entry) => make('li', {},
      make('p', { class: 'title' }, make('strong', {}, `${entry.entry} "${entry.name}"`), ` of ${entry.user} `,
        make('span', { class: `tag ${entry.state}` }, isQueued(entry) ? `${entry.state}, ${placeText(++turn)}` : entry.state)),
      said(entry) ? make('p', { class: 'note' }, said(entry)) : null)));
  }
}

function isOver(entry) {
  return entry.state === 'over' || entry.state === 'cancelled';
}

function isQueued(entry) {
  return entry.state === 'waiting' || entry.state === 'held';
}

/** @param turn  1 for what is played next */
function placeText(turn) {
  return turn === 1 ? 'next' : `${turn}. in turn`;
}

function said(entry) {
  if (entry.state === 'waiting' || entry.state === 'held') return `waits for ${entry.waits_for ?? ''}`;
  if (entry.state === 'fitting') return 'models are fitted to its record';
  return entry.state === 'running' ? '' : verdictText(entry);
}

/** Outcome, accepted models, and what there is to say. */
function verdictText(entry) {
  const models = entry.models ?? [];
  const accepted = models.filter((model) => model.accepted).map((model) => model.name);
  const verdict = accepted.length > 0 ? `accepted: ${accepted.join(', ')}` : models.length > 0 ? 'none accepted' : '';
  const text = [entry.outcome?.replaceAll('_', ' '), verdict].filter(Boolean).join(', ');
  return [text, entry.note].filter(Boolean).join(': ');
}
