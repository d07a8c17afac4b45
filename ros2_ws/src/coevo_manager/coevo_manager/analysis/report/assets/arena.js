'use strict';

/* Draws two robots in their arena, and their neurons, from above, whoever moves them: a recorded
   episode, or robots that run now. `world` has the constants of report/packing.py. Each robot
   is { x, y, heading, wheels: [left, right], neurons, trail: { x, y, length } }: m, rad, rad/s, and
   the activations that world.layers places, 0 to 1. */


/* A colour of the page, so that canvases follow its light or dark style. */
function pageColour(element, name) {
  return getComputedStyle(element).getPropertyValue(name).trim();
}

class ArenaView {
  constructor(arena, neurons) {
    this.arena = arena;
    this.neurons = neurons;
  }

  draw(world, robots, { sensors = true, trails = true } = {}) {
    this.world = world;
    this.robots = robots;
    this.drawArena(sensors, trails);
    this.drawNeurons();
  }

  /* Metres in the arena of a point on the screen. */
  place({ clientX, clientY }) {
    const box = this.arena.getBoundingClientRect();
    const size = this.world.arena * 1.02;
    return {
      x: ((clientX - box.left) / box.width - 0.5) * size,
      y: (0.5 - (clientY - box.top) / box.height) * size,
    };
  }

  drawArena(sensors, trails) {
    const canvas = this.arena;
    const context = canvas.getContext('2d');
    const scale = canvas.width / (this.world.arena * 1.02);
    context.setTransform(scale, 0, 0, -scale, canvas.width / 2, canvas.height / 2);
    const half = this.world.arena / 2;
    const ground = context.createRadialGradient(0, 0, 0, 0, 0, half * Math.SQRT2);
    ground.addColorStop(0, '#ffffff');
    ground.addColorStop(1, '#6f6f6f');
    context.fillStyle = '#000';
    context.fillRect(-2 * half, -2 * half, 4 * half, 4 * half);
    context.fillStyle = ground;
    context.fillRect(-half, -half, 2 * half, 2 * half);
    if (this.world.obstacle) this.disc(context, 0, 0, this.world.obstacle, '#222');
    if (trails) this.robots.forEach((robot, k) => this.drawTrail(context, robot.trail, k));
    this.robots.forEach((robot, k) => this.drawRobot(context, robot, k, sensors));
  }

  disc(context, x, y, radius, colour) {
    context.beginPath();
    context.arc(x, y, radius, 0, 2 * Math.PI);
    context.fillStyle = colour;
    context.fill();
  }

  drawTrail(context, { x, y, length }, k) {
    context.beginPath();
    for (let i = 0; i < length; i += 1) context.lineTo(x[i], y[i]);
    context.lineWidth = 0.012;
    context.setLineDash(k ? [0.05, 0.03] : []);
    context.strokeStyle = this.world.colours[k];
    context.globalAlpha = 0.7;
    context.stroke();
    context.globalAlpha = 1;
    context.setLineDash([]);
  }

  drawRobot(context, robot, k, sensors) {
    const { radius, colours } = this.world;
    context.save();
    context.translate(robot.x, robot.y);
    context.rotate(robot.heading);
    if (sensors) this.drawSensors(context, robot, k);
    this.disc(context, 0, 0, radius, colours[k]);
    context.lineWidth = 0.012;
    context.strokeStyle = k ? '#fff' : '#000';
    context.stroke();
    context.beginPath();
    context.moveTo(radius * 0.8, 0);
    context.lineTo(-radius * 0.4, radius * 0.5);
    context.lineTo(-radius * 0.4, -radius * 0.5);
    context.closePath();
    context.fillStyle = '#fff';
    context.fill();
    context.restore();
  }

  drawSensors(context, robot, k) {
    const { radius, range, colours, layers } = this.world;
    for (let i = 0; i < layers.rays; i += 1) {
      const activation = robot.neurons[i];
      if (activation === 0) continue;
      const angle = ((i + 0.5) * 2 * Math.PI) / layers.rays;
      context.beginPath();
      context.moveTo(Math.cos(angle) * radius, Math.sin(angle) * radius);
      context.lineTo(Math.cos(angle) * (radius + range), Math.sin(angle) * (radius + range));
      context.strokeStyle = `rgba(0, 0, 0, ${0.25 + 0.75 * activation})`;
      context.lineWidth = 0.008;
      context.stroke();
    }
    for (let i = 0; i < layers.sectors; i += 1) {
      const seen = robot.neurons[layers.camera + i];
      if (seen === 0) continue;
      context.beginPath();
      context.arc(0, 0, radius + range + 0.04, (i * 2 * Math.PI) / layers.sectors, ((i + 1) * 2 * Math.PI) / layers.sectors);
      context.strokeStyle = colours[1 - k];
      context.globalAlpha = 0.35 + 0.65 * seen;
      context.lineWidth = 0.04;
      context.stroke();
      context.globalAlpha = 1;
    }
  }

  drawNeurons() {
    const canvas = this.neurons;
    const context = canvas.getContext('2d');
    context.clearRect(0, 0, canvas.width, canvas.height);
    this.soft = pageColour(canvas, '--soft');
    this.line = pageColour(canvas, '--line');
    this.robots.forEach((robot, k) => {
      const top = k * 440;
      context.font = 'bold 24px system-ui, sans-serif';
      context.fillStyle = this.world.colours[k];
      context.fillText(k ? 'Prey' : 'Predator', 0, top + 24);
      const [left, right] = robot.wheels.map((wheel) => wheel.toFixed(1));
      context.font = '20px system-ui, sans-serif';
      context.fillStyle = this.soft;
      const most = this.world.speeds[k] === null ? '' : ` of ${this.world.speeds[k]}`;
      context.fillText(`wheels ${left}, ${right}${most} rad/s`, 140, top + 24);
      this.world.layers.bars.forEach((row, r) => this.drawBars(context, row, k, top + 44 + r * 128));
    });
  }

  drawBars(context, row, k, top) {
    const wide = row.reduce((total, [, , count]) => total + count, 0);
    const step = Math.min(36, (this.neurons.width - 22 * row.length) / wide);
    let x = 0;
    for (const [name, first, count] of row) {
      context.font = '18px system-ui, sans-serif';
      context.fillStyle = this.soft;
      context.fillText(name, x, top + 16);
      const labelled = context.measureText(name).width;
      for (let i = 0; i < count; i += 1) {
        const value = this.robots[k].neurons[first + i];
        const left = x + i * step;
        context.fillStyle = this.line;
        context.fillRect(left, top + 24, step - 6, 80);
        context.fillStyle = this.world.colours[k];
        context.fillRect(left, top + 24 + 80 * (1 - value), step - 6, 80 * value);
      }
      x += Math.max(count * step, labelled) + 22;
    }
  }
}
