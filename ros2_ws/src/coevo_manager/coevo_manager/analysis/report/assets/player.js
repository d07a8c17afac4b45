'use strict';

/* An episode player for any page: `new EpisodePlayer(element)` fills the element, and
   `show(runs)` gives it runs as report/player.py makes them. Episodes that a run does not hold come
   from elsewhere: give a function `load(run, name)` that returns a promise of one. Runs that have
   grown since, or others, are given to `update(runs)`, which keeps what is chosen. */

const PLAYER_PAGE = `
  <div class="controls">
    <label>Run <select data-part="run"></select></label>
    <span class="pick predator">Predator <label>generation <select data-part="predator-generation"></select></label>
      <label>individual <select data-part="predator-rank"></select></label></span>
    <span class="pick prey">Prey <label>generation <select data-part="prey-generation"></select></label>
      <label>individual <select data-part="prey-rank"></select></label></span>
  </div>
  <div class="stage">
    <div>
      <canvas data-part="arena" width="1120" height="1120" role="img" aria-label="The arena from above"></canvas>
      <canvas data-part="timeline" width="1120" height="120" role="img" aria-label="Distance between the robots over time"></canvas>
      <input data-part="scrub" type="range" min="0" max="1" value="0" step="1" aria-label="Tick">
      <div class="controls">
        <button data-part="play" type="button">Play</button>
        <button data-part="back" type="button" aria-label="One tick back">&#8249;</button>
        <button data-part="forward" type="button" aria-label="One tick forward">&#8250;</button>
        <label>Speed <select data-part="speed">
          <option value="0.5">0.5&times;</option><option value="1">1&times;</option>
          <option value="2">2&times;</option><option value="5" selected>5&times;</option>
          <option value="10">10&times;</option><option value="25">25&times;</option></select></label>
        <label><input data-part="sensors" type="checkbox" checked> sensors</label>
        <label><input data-part="trails" type="checkbox" checked> trails</label>
        <output data-part="status"></output>
      </div>
    </div>
    <div>
      <canvas data-part="neurons" width="840" height="880" role="img" aria-label="Activity of the neurons of both robots"></canvas>
      <p class="legend"><span class="swatch predator"></span> predator, solid trail
        <span class="swatch prey"></span> prey, dashed trail. Lines from the rim: active infrared sensors.
        Arcs: camera sectors that see the other robot. Ground: darker towards the walls, as the robots sense it.</p>
      <div data-part="grid"></div>
    </div>
  </div>`;

async function inflate(base64) {
  const bytes = Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream('deflate-raw'));
  return new Response(stream).arrayBuffer();
}

/* Undo packing.py's packing: channels of differences, one after the other. */
async function unpack(episode, { units, layers }) {
  const buffer = await inflate(episode.data);
  const ticks = episode.ticks;
  let start = 0;
  const channel = (Type, length, orders) => {
    const values = new Type(buffer.slice(start, start + length * Type.BYTES_PER_ELEMENT));
    start += length * Type.BYTES_PER_ELEMENT;
    for (let order = 0; order < orders; order += 1) {
      for (let k = 1; k < length; k += 1) values[k] += values[k - 1];
    }
    return values;
  };
  const robots = (Type, count, length, orders, scale) => [0, 1].map(
    () => Array.from({ length: count }, (_, c) => Float32Array.from(channel(Type, length, orders), (v) => v * scale(c))),
  );
  return {
    ticks,
    captured: episode.captured,
    poses: robots(Int16Array, 3, ticks + 1, 2, (c) => (c < 2 ? units.length : (2 * Math.PI) / units.turn)),
    wheels: robots(Int16Array, 2, ticks, 1, () => units.speed),
    neurons: robots(Uint8Array, layers.channels, ticks, 1, () => 1 / units.neuron),
  };
}

class EpisodePlayer {
  constructor(root, load = (run, name) => Promise.resolve(run.episodes[name])) {
    this.root = root;
    this.loadEpisode = load;
    this.runs = [];
    this.time = 0;
    this.playing = false;
    root.classList.add('player');
    root.tabIndex = 0;
    root.setAttribute('aria-label', 'Episode player');
    root.innerHTML = PLAYER_PAGE;
    this.view = new ArenaView(this.element('arena'), this.element('neurons'));
    this.choices = ['predator-generation', 'predator-rank', 'prey-generation', 'prey-rank'].map((part) => this.element(part));
    this.element('run').addEventListener('change', () => this.chooseRun());
    this.choices.forEach((choice) => choice.addEventListener('change', () => this.load()));
    this.element('play').addEventListener('click', () => this.toggle());
    this.element('back').addEventListener('click', () => this.step(-1));
    this.element('forward').addEventListener('click', () => this.step(1));
    this.element('scrub').addEventListener('input', (event) => this.seek(Number(event.target.value)));
    for (const part of ['sensors', 'trails']) this.element(part).addEventListener('change', () => this.draw());
    this.element('timeline').addEventListener('pointerdown', (event) => {
      if (!this.trace) return;
      const box = event.target.getBoundingClientRect();
      this.seek(Math.round(((event.clientX - box.left) / box.width) * this.trace.ticks));
    });
    root.addEventListener('keydown', (event) => this.key(event));
  }

  element(part) {
    return this.root.querySelector(`[data-part="${part}"]`);
  }

  show(runs) {
    this.runs = runs;
    this.fill(this.element('run'), runs.map((run) => run.title));
    return this.chooseRun();
  }

  update(runs) {
    const chosen = this.element('run').selectedOptions[0]?.text;
    this.runs = runs;
    this.fill(this.element('run'), runs.map((run) => run.title), chosen);
    if (this.element('run').selectedOptions[0]?.text !== chosen) return this.chooseRun();
    this.run = this.runs[Number(this.element('run').value)];
    this.choices.forEach((choice, k) => {
      this.fill(choice, k % 2 ? this.run.ranks : this.run.generations, choice.selectedOptions[0]?.text);
    });
    return Promise.resolve();
  }

  /* Offer some names; the one that is to be kept stays chosen where it is still among them. */
  fill(select, names, keep) {
    select.replaceChildren(...names.map((name, k) => new Option(name, k)));
    const place = names.findIndex((name) => String(name) === keep);
    if (place >= 0) select.value = place;
  }

  chooseRun() {
    this.run = this.runs[Number(this.element('run').value)];
    const last = this.run.generations.length - 1;
    this.choices.forEach((choice, k) => {
      this.fill(choice, k % 2 ? this.run.ranks : this.run.generations);
      choice.value = k % 2 ? 0 : last;
    });
    this.drawGrid();
    return this.load();
  }

  /* Identity of the pair that is chosen: places of generations and ranks in the run. */
  chosen() {
    return this.choices.map((choice) => choice.value).join('/');
  }

  async load() {
    const [run, name] = [this.run, this.chosen()];
    const isWanted = () => this.run.title === run.title && this.chosen() === name;
    this.element('status').textContent = 'loading';
    let trace;
    try {
      trace = await unpack(await this.loadEpisode(run, name), run);
    } catch (error) {
      if (isWanted()) this.element('status').textContent = error.message;
      return;
    }
    if (!isWanted()) return;
    this.trace = trace;
    this.name = name;
    this.element('scrub').max = trace.ticks;
    for (const button of this.element('grid').querySelectorAll('button')) {
      button.ariaPressed = String(button.dataset.name === name);
    }
    this.seek(0);
  }

  toggle() {
    if (!this.trace) return;
    this.playing = !this.playing;
    this.element('play').textContent = this.playing ? 'Pause' : 'Play';
    if (!this.playing) return;
    if (this.time >= this.trace.ticks) this.time = 0;
    let before = performance.now();
    const frame = (now) => {
      if (!this.playing) return;
      const rate = Number(this.element('speed').value) / this.run.tick / 1000;
      // The first frame may bear a time before this call.
      this.time = Math.min(this.trace.ticks, this.time + Math.max(0, now - before) * rate);
      before = now;
      this.draw();
      if (this.time >= this.trace.ticks) this.toggle();
      else requestAnimationFrame(frame);
    };
    requestAnimationFrame(frame);
  }

  step(ticks) {
    if (this.playing) this.toggle();
    this.seek(Math.round(this.time) + ticks);
  }

  seek(tick) {
    if (!this.trace) return;
    this.time = Math.max(0, Math.min(this.trace.ticks, tick));
    this.draw();
  }

  key(event) {
    if (['SELECT', 'INPUT', 'BUTTON'].includes(event.target.tagName)) return;
    const actions = { ' ': () => this.toggle(), ArrowLeft: () => this.step(-1), ArrowRight: () => this.step(1) };
    if (!(event.key in actions)) return;
    event.preventDefault();
    actions[event.key]();
  }

  /* Pose of a robot at a moment between ticks: x, y in m, heading in rad. */
  pose(robot, time) {
    const k = Math.min(Math.floor(time), this.trace.ticks);
    const next = Math.min(k + 1, this.trace.ticks);
    const [x, y, heading] = this.trace.poses[robot];
    const turn = (heading[next] - heading[k] + 65 * Math.PI) % (2 * Math.PI) - Math.PI;
    const part = time - k;
    return {
      x: x[k] + (x[next] - x[k]) * part,
      y: y[k] + (y[next] - y[k]) * part,
      heading: heading[k] + turn * part,
    };
  }

  neuron(robot, index) {
    const k = Math.min(Math.floor(this.time), this.trace.ticks - 1);
    return this.trace.neurons[robot][index][k];
  }

  /* A robot as ArenaView draws it. */
  robot(k) {
    const tick = Math.min(Math.floor(this.time), this.trace.ticks - 1);
    const [x, y] = this.trace.poses[k];
    return {
      ...this.pose(k, this.time),
      wheels: this.trace.wheels[k].map((wheel) => wheel[tick]),
      neurons: this.trace.neurons[k].map((channel) => channel[tick]),
      trail: { x, y, length: Math.floor(this.time) + 1 },
    };
  }

  draw() {
    if (!this.trace) return;
    this.view.draw(this.run, [this.robot(0), this.robot(1)], {
      sensors: this.element('sensors').checked,
      trails: this.element('trails').checked,
    });
    this.drawTimeline();
    const tick = Math.floor(this.time);
    this.element('scrub').value = tick;
    const seconds = (count) => `${(count * this.run.tick).toFixed(1)} s`;
    const [a, b] = [0, 1].map((robot) => this.pose(robot, this.time));
    const end = this.trace.captured ? `captured at ${seconds(this.trace.ticks)}` : `not captured in ${seconds(this.trace.ticks)}`;
    this.element('status').textContent = `${seconds(tick)} of ${seconds(this.trace.ticks)}, distance ${Math.hypot(a.x - b.x, a.y - b.y).toFixed(2)} m; ${end}`;
  }

  drawTimeline() {
    const canvas = this.element('timeline');
    const context = canvas.getContext('2d');
    const { width, height } = canvas;
    context.clearRect(0, 0, width, height);
    const [[ax, ay], [bx, by]] = this.trace.poses;
    const far = this.run.arena * 1.2;
    context.beginPath();
    for (let k = 0; k <= this.trace.ticks; k += 1) {
      const distance = Math.hypot(ax[k] - bx[k], ay[k] - by[k]);
      context.lineTo((k / this.trace.ticks) * width, height - 6 - (distance / far) * (height - 30));
    }
    context.strokeStyle = pageColour(canvas, '--ink');
    context.lineWidth = 2.5;
    context.stroke();
    context.font = '20px system-ui, sans-serif';
    context.fillStyle = pageColour(canvas, '--soft');
    context.fillText('distance between the robots', 10, 24);
    const now = (this.time / this.trace.ticks) * width;
    context.fillStyle = pageColour(canvas, '--accent');
    context.fillRect(now - 2, 0, 4, height);
  }

  drawGrid() {
    const { generations, ranks, episodes, tick } = this.run;
    this.element('grid').replaceChildren();
    if (!episodes) return;
    const longest = Math.max(...Object.values(episodes).map((episode) => episode.ticks));
    const people = generations.flatMap((generation, g) => ranks.map((rank, r) => ({ generation, rank, key: `${g}/${r}` })));
    const table = document.createElement('table');
    const head = table.createTHead().insertRow();
    head.append(this.heading('predator \\ prey'), ...people.map((prey) => this.heading(`${prey.generation} ${prey.rank}`)));
    const body = table.createTBody();
    for (const predator of people) {
      const row = body.insertRow();
      row.append(this.heading(`${predator.generation} ${predator.rank}`));
      for (const prey of people) {
        const name = `${predator.key}/${prey.key}`;
        const episode = episodes[name];
        const button = document.createElement('button');
        button.type = 'button';
        button.dataset.name = name;
        button.textContent = episode.captured ? (episode.ticks * tick).toFixed(0) : 'free';
        const light = 96 - 46 * (1 - episode.ticks / longest);
        button.style.background = `hsl(10 60% ${light}%)`;
        button.title = `predator ${predator.generation} ${predator.rank}, prey ${prey.generation} ${prey.rank}`;
        button.addEventListener('click', () => this.chooseCell(name));
        row.insertCell().append(button);
      }
    }
    this.element('grid').replaceChildren(table);
  }

  heading(text) {
    const cell = document.createElement('th');
    cell.textContent = text;
    return cell;
  }

  chooseCell(name) {
    name.split('/').forEach((value, k) => { this.choices[k].value = value; });
    return this.load();
  }
}
