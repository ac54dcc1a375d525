// SPDX-License-Identifier: GPL-3.0-or-later
// The page of eha-web: asks for state, samples, response and runs, and hands each to its view. Only Stop acts on the rig.
import { Contact, Poller } from './contact.js';
import { byId, setText } from './dom.js';
import { LivePlots } from './live.js';
import { QueueView } from './queue.js';
import { ResponseView } from './response.js';
import { isDriven, RigView } from './rig.js';
import { RunsView } from './runs.js';
import { StopButton } from './stop.js';
import { isNumber, LengthUnit } from './units.js';

const kLive_ms = 100;
const kState_ms = 250;
const kResponse_ms = 1000;
const kResponseIdle_ms = 5000;
const kRuns_ms = 5000;

const rig = new RigView();
const live = new LivePlots();
const queue = new QueueView();
const response = new ResponseView();
const runs = new RunsView();
const stop = new StopButton();
const contact = new Contact((isLive) => {
  document.body.classList.toggle('old', !isLive);
  stop.reaches(isLive);
  if (!isLive) rig.lose();
});

/** Of the rig file; null before the first answer: a number without its unit is not shown. */
let unit = null;
let travel = null;
let fittedOrDriven = '';
let playedRun = null;

/** Travel limits [in] and the share of the way to them that is warned of: of the rig file, or as they were before. */
function travelOf(limits) {
  const { travel_min_in: low_in, travel_max_in: high_in, warning_share: warningShare } = limits ?? {};
  return [low_in, high_in, warningShare].every(isNumber) && low_in < high_in ? { low_in, high_in, warningShare } : travel;
}

const poll = (path, period_ms, onAnswer) => new Poller(path, period_ms, onAnswer, () => contact.refused());

poll(() => live.path(), kLive_ms, (answer) => {
  contact.answered();
  live.take(answer);
  const newest = live.newest();
  if (newest && contact.isLive && unit) {
    rig.showRod(isNumber(newest.x_min) ? 0.5 * (newest.x_min + newest.x_max) : null, unit, travel);
    rig.showVolts(isNumber(newest.v_min) ? 0.5 * (newest.v_min + newest.v_max) : null);
  }
});

poll('api/state', kState_ms, (answer) => {
  contact.answered();
  contact.daemonIs(answer.daemon === 'connected');
  setText(byId('versions'), `ehad ${answer.status?.ehad ?? answer.version ?? ''}`);
  setText(byId('delay'), live.delayText());
  if (!answer.status || !contact.isLive) return;
  unit = new LengthUnit(answer.units);
  travel = travelOf(answer.limits);
  live.show(unit, travel);
  rig.show(answer.status, unit, travel);
  if (!live.newest()) rig.showRod(answer.status.rod?.displacement_in ?? null, unit, travel);
  queue.show(answer.queue ?? [], answer.queue_left_out ?? 0);
  runs.fits((answer.queue ?? []).filter((entry) => entry.state === 'fitting' && entry.run).map((entry) => entry.run));
  stop.show(answer.status);
  stop.opened();
  playedRun = answer.status.run?.run || null;
  // A run that begins, ends or is fitted changes the lists at once.
  const now = JSON.stringify([answer.status.run?.entry ?? null, answer.status.worker?.entry ?? null]);
  if (now !== fittedOrDriven) {
    fittedOrDriven = now;
    runsPoller.askNow();
    responsePoller.period_ms = isDriven(answer.status) ? kResponse_ms : kResponseIdle_ms;
    responsePoller.askNow();
  }
});

const responsePoller = poll('api/response', kResponseIdle_ms, (answer) => {
  if (unit) response.show(answer, answer.run !== null && answer.run === playedRun, unit);
});
const runsPoller = poll('api/runs?limit=50', kRuns_ms, (answer) => runs.show(answer));
