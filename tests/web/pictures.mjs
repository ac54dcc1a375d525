// SPDX-License-Identifier: GPL-3.0-or-later
// Draws docs/pictures anew: report, plots and page of the simulated rig, as the programs draw them now.
import { copyFileSync, readFileSync } from 'node:fs';
import path from 'node:path';
import { fileURLToPath } from 'node:url';
import { Bench, kExperiment, launchBrowser, until } from './bench.mjs';

const kRoot = path.resolve(path.dirname(fileURLToPath(import.meta.url)), '../..');
const kPictures = path.join(kRoot, 'docs/pictures');
const kPeriods = 5;  // of the experiment on the page
const bench = new Bench();

async function eha(...words) {
  const { code, text } = await bench.eha(...words);
  if (code !== 0) throw new Error(`eha ${words.join(' ')}: code ${code}\n${text}`);
  return text;
}

async function shoot(browser, address, viewport, name, ready = async () => {}, options = {}) {
  const context = await browser.newContext({ viewport });
  await context.addInitScript(() => { try { sessionStorage.setItem('eha-token-declined', 'yes'); } catch { /* a report */ } });
  const page = await context.newPage();
  await page.goto(address);
  await ready(page);
  await page.screenshot({ path: path.join(kPictures, name), ...options });
  await context.close();
}

async function drawRun(browser) {
  copyFileSync(path.join(kRoot, 'config/experiments/paper.toml'), path.join(bench.folder, 'paper.toml'));
  copyFileSync(path.join(kRoot, 'config/rigs/sim.toml'), path.join(bench.folder, 'sim.toml'));
  await eha('run', 'paper.toml', '--local', '--fast', '--rig', 'sim.toml');
  const run = path.join(bench.folder, 'runs/latest');
  const { model } = JSON.parse(readFileSync(path.join(run, 'run.json'), 'utf8')).identification.recommendation;
  await eha('plot', 'runs/latest', '-o', path.join(kPictures, 'fit.png'));
  await eha('plot', `runs/latest/models/${model}.json`, '-o', path.join(kPictures, 'bode.png'));
  await shoot(browser, `file://${run}/report.html`, { width: 1180, height: 1050 }, 'report.png');
}

async function drawPage(browser) {
  await bench.startDaemon();
  await bench.startWeb();
  await eha('arm');
  await eha('run', kExperiment, '--detach');
  await shoot(browser, bench.address, { width: 1280, height: 900 }, 'page.png', async (page) => {
    await until('periods are measured', async () => Number(await page.locator('#response-card').getAttribute('data-periods')) >= kPeriods);
    await until('the lists are filled', () => page.locator('#queue li').count());
  }, { fullPage: true });
}

const browser = await launchBrowser();
try {
  await drawRun(browser);
  await drawPage(browser);
} finally {
  await browser.close();
  await bench.close();
}
