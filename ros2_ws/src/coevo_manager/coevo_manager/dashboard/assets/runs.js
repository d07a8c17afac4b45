'use strict';

/* The page of runs: how far each is, and charts of those that are chosen. */

const STATES = {
  running: 'running',
  finished: 'finished',
  stopped: 'stopped on request',
  failed: 'failed',
  killed: 'ended without a word: killed, or its machine went down',
  silent: 'silent: it runs elsewhere, or has ended',
};

const CHART_PERIOD = 5000;
const OPEN_FROM_THE_START = 12;

const chosen = new Set();
const known = new Set();
const cards = new Map();
let drawn = '';
let drawing = false;

function duration(seconds) {
  if (typeof seconds !== 'number') return '–';
  const whole = Math.round(seconds);
  const parts = [Math.floor(whole / 3600), Math.floor(whole / 60) % 60, whole % 60];
  return `${parts[0]}:${String(parts[1]).padStart(2, '0')}:${String(parts[2]).padStart(2, '0')}`;
}

const number = (value, digits = 0) => (typeof value === 'number'
  ? value.toLocaleString('en', { minimumFractionDigits: digits, maximumFractionDigits: digits }) : '–');

function facts(run) {
  const { configuration } = run;
  const of = configuration.phases ? ` of ${number(configuration.phases)}` : '';
  const share = typeof run.accepted === 'number' ? run.accepted / configuration.selected : null;
  const found = [
    ['phase', `${number(run.phase)}${of}`],
    ['generation', number(run.generation)],
    ['time left', run.state === 'running' ? duration(run.seconds_left) : '–'],
    ['ticks a second', typeof run.ticks_per_second === 'number' ? `${number(run.ticks_per_second / 1e6, 2)} M` : '–'],
    ['evolving', run.evolving ? `${run.evolving} ${number(run.fitness_mean, 3)}` : '–'],
    ['predators : prey', `${number(run.predator_fitness, 3)} : ${number(run.prey_fitness, 3)}`],
    ['agents retained', `${number(run.retained)} of ${configuration.selected}`],
    ['acceptance', number(share, 2)],
    ['episodes', number(run.episodes)],
  ];
  const list = element('dl', { className: 'facts' });
  for (const [name, value] of found) {
    list.append(element('div', {}, element('dt', {}, name), element('dd', { 'data-fact': name }, value)));
  }
  return list;
}

function tableOf(headings, rows) {
  const table = element('table');
  table.createTHead().append(element('tr', {}, ...headings.map((text) => element('th', { scope: 'col' }, text))));
  const body = table.createTBody();
  for (const row of rows) body.append(element('tr', {}, ...row.map((text) => element('td', {}, String(text)))));
  return element('div', { className: 'scroll' }, table);
}

const evaluatorName = ({ service }) => String(service).replace(/\/evaluate_batch$/, '');

function evaluators(run) {
  const parts = [];
  if (run.evaluators?.length) {
    const rows = run.evaluators.map((each) => [
      evaluatorName(each), each.process ? 'this run' : 'others', each.working ? 'at work' : 'not at work',
      `${number(each.busy * 100)} %`, number(each.requests), number(each.episodes_per_second),
    ]);
    parts.push(tableOf(['evaluator', 'started by', 'state', 'busy', 'requests', 'episodes a second'], rows));
  }
  if (run.losses?.length) {
    const rows = run.losses.map((each) => [new Date(each.time * 1000).toLocaleTimeString(), evaluatorName(each), each.reason]);
    parts.push(tableOf(['failed at', 'evaluator', 'why'], rows));
  }
  return parts;
}

function evaluatorSummary(run) {
  const count = run.evaluators?.length || 0;
  const working = run.evaluators?.filter((each) => each.working).length || 0;
  const busy = count ? run.evaluators.reduce((sum, each) => sum + each.busy, 0) / count : 0;
  const failed = run.losses?.length ? `, ${run.losses.length} failed` : '';
  return count || failed ? `Evaluators: ${working} of ${count} at work, ${number(busy * 100)} % busy${failed}` : 'Evaluators';
}

/* Made once for each run; what changes is put into it anew, so that focus and open parts stay. */
function makeCard(run) {
  const box = element('input', { type: 'checkbox' });
  box.checked = chosen.has(run.key);
  box.addEventListener('change', () => {
    if (box.checked) chosen.add(run.key); else chosen.delete(run.key);
    offerFields();
    drawCharts();
  });
  const parts = {
    box,
    state: element('span', { className: 'state' }),
    progress: element('progress', { max: 1, 'aria-label': `Progress of ${run.name}` }),
    facts: element('div'),
    summary: element('summary'),
    evaluators: element('div'),
    events: element('pre'),
    problem: element('p', { className: 'warning' }),
  };
  const configuration = Object.entries(run.configuration).map(([name, value]) => [name, value ?? 'none']);
  const card = element(
    'article', { className: 'run', 'data-run': run.name },
    element('div', { className: 'run-head' }, element('label', {}, box, run.name), parts.state),
    parts.progress, parts.problem, parts.facts,
    element('details', {}, parts.summary, parts.evaluators),
    element('details', {}, element('summary', {}, 'Events'), parts.events),
    element(
      'details', {}, element('summary', {}, 'Configuration'),
      element('p', { className: 'hint' }, `${run.folder}${run.host ? `, on ${run.host}` : ''}`), tableOf(['field', 'value'], configuration),
    ),
  );
  return { card, parts };
}

function fillCard({ card, parts }, run) {
  parts.state.textContent = STATES[run.state] ?? run.state;
  parts.state.className = `state ${run.state}`;
  parts.progress.value = run.progress ?? 0;
  parts.progress.title = `${number((run.progress ?? 0) * 100, 1)} %`;
  parts.problem.textContent = run.problem;
  parts.problem.hidden = !run.problem;
  parts.facts.replaceChildren(facts(run));
  parts.summary.textContent = evaluatorSummary(run);
  parts.evaluators.replaceChildren(...evaluators(run));
  parts.evaluators.parentElement.hidden = !run.evaluators?.length && !run.losses?.length;
  parts.events.textContent = run.events.join('\n');
  card.dataset.state = run.state;
}

function showRuns() {
  document.getElementById('no-runs').hidden = runs.size > 0;
  for (const [key, { card }] of cards) {
    if (!runs.has(key)) {
      card.remove();
      cards.delete(key);
      chosen.delete(key);
    }
  }
  for (const [key, run] of runs) {
    if (!known.has(key)) {
      known.add(key);
      if (chosen.size < OPEN_FROM_THE_START) chosen.add(key);
    }
    if (!cards.has(key)) {
      cards.set(key, makeCard(run));
      document.getElementById('run-list').append(cards.get(key).card);
    }
    fillCard(cards.get(key), run);
  }
  offerFields();
  drawCharts();
}

/* Put the fields in which the chosen runs differ first. */
function offerFields() {
  const select = document.getElementById('by');
  const configurations = [...chosen].map((key) => runs.get(key)?.configuration).filter(Boolean);
  const differs = (name) => new Set(configurations.map((each) => JSON.stringify(each[name]))).size > 1;
  const [first, ...rest] = [...select.options];
  const ordered = [first, ...rest.filter((o) => differs(o.value)), ...rest.filter((o) => !differs(o.value))];
  if (ordered.some((option, k) => option !== select.options[k])) {
    const { value } = select;
    select.replaceChildren(...ordered);
    select.value = value;
  }
}

async function drawCharts() {
  if (drawing || document.getElementById('runs').hidden) return;
  const keys = [...chosen].filter((key) => runs.has(key));
  const by = document.getElementById('by').value;
  const wanted = JSON.stringify([by, keys.map((key) => [key, runs.get(key).episodes ?? 0])]);
  if (wanted === drawn) return;
  drawing = true;
  const place = document.getElementById('run-charts');
  try {
    if (keys.length) drawChart(place, await answer(`/charts?runs=${keys.join(',')}&by=${by}`));
    else place.replaceChildren();
    drawn = wanted;
  } catch (error) {
    if (!place.childElementCount) place.textContent = error.message;
  }
  setTimeout(() => {
    drawing = false;
    drawCharts();
  }, keys.length ? CHART_PERIOD : 0);
}

function chooseAll(all) {
  for (const [key, { parts }] of cards) {
    parts.box.checked = all;
    if (all) chosen.add(key); else chosen.delete(key);
  }
  offerFields();
  drawCharts();
}

window.addEventListener('DOMContentLoaded', () => {
  listeners.push(showRuns);
  document.addEventListener('page', () => drawCharts());
  document.getElementById('by').addEventListener('change', () => drawCharts());
  document.getElementById('choose-all').addEventListener('click', () => chooseAll(true));
  document.getElementById('choose-none').addEventListener('click', () => chooseAll(false));
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => {
    drawn = '';
    drawCharts();
  });
});
