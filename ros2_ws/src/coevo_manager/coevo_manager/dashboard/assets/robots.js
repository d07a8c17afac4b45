'use strict';

/* The page of robots that run now: what their topics say, and what their services can be asked. */

const TRAIL = 400;
const KEY_STEP = 0.05;
const KEY_TURN = Math.PI / 12;

let view = null;
let frame = null;
let stream = null;
let held = null;
let trails = [{ x: [], y: [] }, { x: [], y: [] }];
let episode = null;

async function order(command, values = {}) {
  const problem = document.getElementById('robots-problem');
  try {
    await answer(`/robots/${command}`, {
      method: 'POST',
      headers: { 'Content-Type': 'application/json' },
      body: JSON.stringify(values),
    });
    problem.hidden = true;
  } catch (error) {
    problem.textContent = error.message;
    problem.hidden = false;
  }
}

function takeFrame(given) {
  frame = given;
  if (frame.failure) {
    const problem = document.getElementById('robots-problem');
    problem.textContent = frame.failure;
    problem.hidden = false;
  }
  if (frame.arena?.episode !== episode) {
    episode = frame.arena?.episode;
    trails = [{ x: [], y: [] }, { x: [], y: [] }];
  }
  frame.robots.forEach((robot, k) => {
    const { x, y } = trails[k];
    if (robot.x === null || (x.at(-1) === robot.x && y.at(-1) === robot.y)) return;
    x.push(robot.x);
    y.push(robot.y);
    if (x.length > TRAIL) {
      x.shift();
      y.shift();
    }
  });
  drawRobots();
  showDiagnostics();
}

function drawRobots() {
  const { arena } = frame;
  const there = frame.robots.every((robot) => robot.x !== null);
  const state = arena && (arena.captured ? 'captured' : arena.ended ? 'ended' : arena.paused ? 'paused' : 'running');
  document.getElementById('robots-status').textContent = arena && there
    ? `episode ${arena.episode}, ${(arena.tick / 10).toFixed(1)} s, ${state}` : 'no robots are heard yet';
  document.getElementById('pause').textContent = arena?.paused ? 'Go on' : 'Pause';
  document.getElementById('step').disabled = !arena?.paused;
  if (!there) return;
  const robots = frame.robots.map((robot, k) => ({
    ...robot, ...(held?.robot === k ? held.pose : {}), trail: { ...trails[k], length: trails[k].x.length },
  }));
  view.draw(frame.world, robots);
}

function showDiagnostics() {
  const rows = frame.diagnostics.map(({ name, level, message, values }) => [
    name, ['fine', 'warning', 'error', 'stale'][level] ?? level, message, values.map((pair) => pair.join(' ')).join(', '),
  ]);
  const place = document.getElementById('diagnostics');
  const text = JSON.stringify(rows);
  if (place.dataset.shown === text) return;
  place.dataset.shown = text;
  place.replaceChildren(tableOf(['diagnostics of', 'level', 'message', 'values'], rows));
}

const poseOf = ({ x, y, heading }) => ({ x, y, heading });

function hold(robot) {
  held = { robot, pose: poseOf(frame.robots[robot]) };
}

function place() {
  const robots = frame.robots.map((robot, k) => {
    const { x, y, heading } = k === held.robot ? held.pose : robot;
    return [x, y, heading];
  });
  held = null;
  return order('poses', { robots });
}

function drag(canvas) {
  canvas.addEventListener('pointerdown', (event) => {
    if (!frame || frame.robots.some((robot) => robot.x === null)) return;
    const point = view.place(event);
    const distances = frame.robots.map((robot) => Math.hypot(robot.x - point.x, robot.y - point.y));
    const nearest = distances.indexOf(Math.min(...distances));
    if (distances[nearest] > 2 * frame.world.radius) return;
    canvas.setPointerCapture(event.pointerId);
    hold(nearest);
    held.dragged = true;
  });
  canvas.addEventListener('pointermove', (event) => {
    if (!held?.dragged) return;
    Object.assign(held.pose, view.place(event));
    drawRobots();
  });
  canvas.addEventListener('pointerup', () => { if (held?.dragged) place(); });
  canvas.addEventListener('pointercancel', () => { held = null; });
}

function moveByKeys(canvas) {
  canvas.addEventListener('keydown', (event) => {
    if (!frame || frame.robots.some((robot) => robot.x === null)) return;
    const move = (x, y, turn) => {
      if (!held) hold(0);
      held.pose.x += x * KEY_STEP;
      held.pose.y += y * KEY_STEP;
      held.pose.heading += turn * KEY_TURN;
    };
    const actions = {
      p: () => hold(held ? 1 - held.robot : 0),
      ArrowLeft: () => move(-1, 0, 0),
      ArrowRight: () => move(1, 0, 0),
      ArrowUp: () => move(0, 1, 0),
      ArrowDown: () => move(0, -1, 0),
      ',': () => move(0, 0, 1),
      '.': () => move(0, 0, -1),
      Enter: () => { if (held) place(); },
      Escape: () => { held = null; },
    };
    if (!(event.key in actions) || event.ctrlKey || event.altKey || event.metaKey) return;
    event.preventDefault();
    actions[event.key]();
    drawRobots();
  });
}

function offerOptions(select, names, latest = false) {
  const before = select.value;
  select.replaceChildren(...names.map(([value, text]) => new Option(text, value)));
  if (names.some(([value]) => String(value) === before)) select.value = before;
  else if (latest && names.length) select.value = names.at(-1)[0];
}

/* The runs whose individuals may drive the robots. */
async function offerGenomes() {
  if (document.getElementById('robots').hidden) return;
  const found = await answer('/watch').catch(() => []);
  const run = document.getElementById('swap-run');
  const fill = () => {
    const chosenRun = found.find((each) => each.key === run.value);
    offerOptions(document.getElementById('swap-generation'), (chosenRun?.generations ?? []).map((g) => [g, g]), true);
    offerOptions(document.getElementById('swap-rank'), (chosenRun?.ranks ?? []).map((rank) => [rank, rank]));
  };
  offerOptions(run, found.map((each) => [each.key, each.title]));
  run.onchange = fill;
  fill();
  document.getElementById('swap').hidden = !found.length;
}

function followPage() {
  const shown = !document.getElementById('robots').hidden;
  if (shown && !stream) stream = listenTo('/robots/frames', takeFrame);
  if (!shown && stream) {
    stream.close();
    stream = null;
  }
  offerGenomes();
}

window.addEventListener('DOMContentLoaded', () => {
  const canvas = document.getElementById('robots-arena');
  view = new ArenaView(canvas, document.getElementById('robots-neurons'));
  drag(canvas);
  moveByKeys(canvas);
  const onClick = (id, action) => document.getElementById(id).addEventListener('click', action);
  onClick('pause', () => order('pause', { paused: !frame?.arena?.paused }));
  onClick('step', () => order('step', { ticks: Number(document.getElementById('step-ticks').value) }));
  onClick('reset', () => order('reset'));
  onClick('swap-go', () => order('genome', Object.fromEntries(
    ['species', 'run', 'generation', 'rank'].map((name) => [name, document.getElementById(`swap-${name}`).value]),
  )));
  document.addEventListener('page', followPage);
  followPage();
});
