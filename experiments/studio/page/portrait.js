// SPDX-License-Identifier: BSD-3-Clause
// The picture of a motion in the plane: three canvases on top of each other, for what stands still (sets, obstacles,
// demonstrations), for the flow, and for what a pointer or a running motion changes at every frame.
import { fillOfSet, edgeOfSet } from './contours.js';
import { pathOfShape, handlesOf } from './shapes.js';
import { unpack } from './networks.js';

const PARTICLES = 700;
const PARTICLE_LIFE = 90; // frames
const FLOW_SIDE = 61; // points a side of the grid that particles follow; motions that are played use f itself

export class Portrait {
  constructor(box) {
    this.box = box;
    [this.still, this.flow, this.live] = box.querySelectorAll('canvas');
    this.field = [0, 0, 1, 0.75];
    this.motion = null;
    this.drawing = null; // {strokes, obstacles, initial, selected}
    this.autoInitial = null;
    this.counterexamples = [];
    this.showFlow = true;
    this.void = false;
    this.overlay = () => {};
    this.frames = [];
    this.reduced = matchMedia('(prefers-reduced-motion: reduce)');
    matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => this.refresh());
    new ResizeObserver(() => this.resize()).observe(box);
    this.resize();
    const tick = (time) => {
      this.frames.push(time);
      if (this.frames.length > 120) this.frames.shift();
      this.drawFlow();
      this.drawLive(time);
      requestAnimationFrame(tick);
    };
    requestAnimationFrame(tick);
  }

  // Frames a second, over the last 120.
  rate() {
    const n = this.frames.length;
    return n > 1 ? (1000 * (n - 1)) / (this.frames[n - 1] - this.frames[0]) : 0;
  }

  resize() {
    const { clientWidth: w, clientHeight: h } = this.box;
    const ratio = Math.min(2, window.devicePixelRatio || 1);
    for (const canvas of [this.still, this.flow, this.live]) {
      canvas.width = Math.max(1, Math.round(w * ratio));
      canvas.height = Math.max(1, Math.round(h * ratio));
      canvas.getContext('2d').setTransform(ratio, 0, 0, ratio, 0, 0);
    }
    this.width = w;
    this.height = h;
    this.refresh();
  }

  colour(name) {
    return getComputedStyle(this.box).getPropertyValue(`--${name}`).trim();
  }

  // Pixels for a unit of length, and where its corner lies.
  fit() {
    const [x0, y0, x1, y1] = this.field;
    this.scale = Math.min(this.width / (x1 - x0), this.height / (y1 - y0));
    this.left = (this.width - this.scale * (x1 - x0)) / 2;
    this.top = (this.height - this.scale * (y1 - y0)) / 2;
  }

  place(x, y) {
    return [this.left + this.scale * (x - this.field[0]), this.top + this.scale * (this.field[3] - y)];
  }

  point(px, py) {
    return [this.field[0] + (px - this.left) / this.scale, this.field[3] - (py - this.top) / this.scale];
  }

  setField(field) {
    this.field = field;
    this.refresh();
  }

  setMotion(motion) {
    this.motion = motion && motion.n === 2 ? motion : null;
    this.particles = null;
    this.counterexamples = [];
    if (this.motion) {
      const side = motion.run.final === false ? 81 : 161;
      this.barrier = { side, values: motion.grid(side, (x) => motion.barrier(x)) };
      this.counterexamples = motion.counterexamples();
      const [vx, vy] = [new Float32Array(FLOW_SIDE ** 2), new Float32Array(FLOW_SIDE ** 2)];
      let at = 0;
      motion.grid(FLOW_SIDE, (x) => {
        [vx[at], vy[at]] = motion.velocity(x);
        ++at;
        return 0;
      });
      this.velocity = { vx, vy };
    }
    this.refresh();
  }

  refresh() {
    if (!this.width) return;
    this.fit();
    this.box.style.aspectRatio = `${this.field[2] - this.field[0]} / ${this.field[3] - this.field[1]}`;
    this.flow.getContext('2d').clearRect(0, 0, this.width, this.height);
    const ink = {};
    for (const name of ['field', 'outside', 'safe', 'safe-edge', 'unsafe', 'unsafe-edge', 'initial', 'demonstration', 'held-out',
      'flow', 'counterexample', 'goal', 'ink', 'motion', 'lost', 'open', 'accent']) ink[name] = this.colour(name);
    this.ink = ink;
    this.drawStill();
  }

  line(context, points, colour, width, dash = []) {
    context.beginPath();
    points.forEach((p, k) => (k ? context.lineTo(...this.place(p[0], p[1])) : context.moveTo(...this.place(p[0], p[1]))));
    context.strokeStyle = colour;
    context.lineWidth = width;
    context.setLineDash(dash);
    context.lineJoin = context.lineCap = 'round';
    context.stroke();
    context.setLineDash([]);
  }

  disc(context, [x, y], radius, colour, edge = null) {
    context.beginPath();
    context.arc(...this.place(x, y), radius, 0, 2 * Math.PI);
    context.fillStyle = colour;
    context.fill();
    if (!edge) return;
    context.strokeStyle = edge;
    context.lineWidth = 1.5;
    context.stroke();
  }

  onGrid(side) {
    const { lower, upper } = this.motion;
    const step = [0, 1].map((i) => (upper[i] - lower[i]) / (side - 1));
    return (a, b) => this.place(lower[0] + a * step[0], lower[1] + b * step[1]);
  }

  drawStill() {
    const c = this.still.getContext('2d');
    const { ink } = this;
    c.clearRect(0, 0, this.width, this.height);
    c.fillStyle = ink.field;
    c.fillRect(...this.place(this.field[0], this.field[3]), this.scale * (this.field[2] - this.field[0]), this.scale * (this.field[3] - this.field[1]));
    c.save();
    c.beginPath();
    c.rect(...this.place(this.field[0], this.field[3]), this.scale * (this.field[2] - this.field[0]), this.scale * (this.field[3] - this.field[1]));
    c.clip();
    if (this.motion) this.drawSafeSet(c);
    this.drawObstacles(c);
    this.drawInitial(c);
    this.drawDemonstrations(c);
    if (this.motion) {
      c.fillStyle = ink.open;
      for (const [lower, upper] of this.motion.run.open_boxes) {
        const [px, py] = this.place(lower[0], upper[1]);
        c.fillRect(px - 1, py - 1, this.scale * (upper[0] - lower[0]) + 2, this.scale * (upper[1] - lower[1]) + 2);
      }
      for (const p of this.counterexamples) this.disc(c, p, 3, ink.counterexample);
    }
    const goal = this.motion?.goal ?? this.goal;
    if (goal) this.drawGoal(c, goal);
    c.restore();
    c.strokeStyle = ink.outside;
    c.lineWidth = 1;
    c.strokeRect(...this.place(this.field[0], this.field[3]), this.scale * (this.field[2] - this.field[0]), this.scale * (this.field[3] - this.field[1]));
  }

  drawSafeSet(c) {
    const { side, values } = this.barrier;
    const certified = this.motion.run.certificate.guarantee === 'invariant' && !this.void;
    c.fillStyle = this.ink.safe;
    c.globalAlpha = certified ? 1 : 0.45;
    c.fill(fillOfSet(values, side, this.onGrid(side)));
    c.globalAlpha = 1;
    c.strokeStyle = this.ink['safe-edge'];
    c.lineWidth = certified ? 2.5 : 1.5;
    c.setLineDash(certified ? [] : [6, 5]);
    c.stroke(edgeOfSet(values, side, this.onGrid(side)));
    c.setLineDash([]);
  }

  // The drawing's own; where a run has obstacles of other kinds, their level.
  drawObstacles(c) {
    const own = this.motion && this.motion.run.obstacles === null;
    c.fillStyle = this.ink.unsafe;
    c.strokeStyle = this.ink['unsafe-edge'];
    c.lineWidth = 1.5;
    if (own && this.motion.run.levels) {
      const { side, unsafe } = this.motion.run.levels;
      const values = unpack(unsafe);
      c.fill(fillOfSet(values, side, this.onGrid(side)));
      c.stroke(edgeOfSet(values, side, this.onGrid(side)));
    }
    const shapes = this.drawing ? this.drawing.obstacles : (this.motion?.run.obstacles ?? []);
    for (const shape of shapes) {
      const path = pathOfShape(shape, (x, y) => this.place(x, y), this.scale);
      c.fill(path);
      c.stroke(path);
    }
  }

  drawInitial(c) {
    c.strokeStyle = this.ink.initial;
    c.lineWidth = 1.5;
    c.setLineDash([5, 4]);
    const known = this.drawing?.initial ?? this.motion?.run.initial ?? this.autoInitial;
    if (known) {
      c.stroke(pathOfShape(known, (x, y) => this.place(x, y), this.scale));
    } else if (this.motion?.run.levels && !this.void) {
      const { side, initial } = this.motion.run.levels;
      c.stroke(edgeOfSet(unpack(initial), side, this.onGrid(side)));
    }
    c.setLineDash([]);
  }

  drawDemonstrations(c) {
    if (this.drawing) {
      this.drawing.strokes.forEach((s) => {
        const points = s.x.map((x, i) => [x, s.y[i]]);
        this.line(c, points, this.ink.demonstration, 2.5);
        this.disc(c, points[0], 4, this.ink.field, this.ink.demonstration);
      });
      return;
    }
    for (const { points, trains } of this.motion?.demonstrations ?? [])
      this.line(c, points, trains ? this.ink.demonstration : this.ink['held-out'], 2);
  }

  drawGoal(c, goal) {
    const [px, py] = this.place(goal[0], goal[1]);
    c.beginPath();
    for (let k = 0; k < 10; ++k) {
      const angle = -Math.PI / 2 + (k * Math.PI) / 5;
      const radius = k % 2 ? 5 : 11;
      c[k ? 'lineTo' : 'moveTo'](px + radius * Math.cos(angle), py + radius * Math.sin(angle));
    }
    c.closePath();
    c.fillStyle = this.ink.goal;
    c.strokeStyle = this.ink.ink;
    c.lineWidth = 1.2;
    c.fill();
    c.stroke();
  }

  // Velocity for particles, between the grid's points.
  velocityNear(x, y) {
    const { lower, upper } = this.motion;
    const a = ((x - lower[0]) / (upper[0] - lower[0])) * (FLOW_SIDE - 1);
    const b = ((y - lower[1]) / (upper[1] - lower[1])) * (FLOW_SIDE - 1);
    if (!(a >= 0 && b >= 0 && a < FLOW_SIDE - 1 && b < FLOW_SIDE - 1)) return null;
    const [i, j] = [Math.floor(a), Math.floor(b)];
    const [s, t] = [a - i, b - j];
    const mix = (v) => (1 - s) * ((1 - t) * v[i * FLOW_SIDE + j] + t * v[i * FLOW_SIDE + j + 1]) +
      s * ((1 - t) * v[(i + 1) * FLOW_SIDE + j] + t * v[(i + 1) * FLOW_SIDE + j + 1]);
    return [mix(this.velocity.vx), mix(this.velocity.vy)];
  }

  newParticle() {
    const { lower, upper } = this.motion;
    return { x: lower[0] + Math.random() * (upper[0] - lower[0]), y: lower[1] + Math.random() * (upper[1] - lower[1]),
      age: Math.floor(Math.random() * PARTICLE_LIFE) };
  }

  drawFlow() {
    const c = this.flow.getContext('2d');
    if (!this.motion || !this.showFlow) {
      if (this.particles) c.clearRect(0, 0, this.width, this.height);
      this.particles = null;
      return;
    }
    if (this.reduced.matches) {
      if (!this.particles) this.drawArrows(c);
      this.particles = [];
      return;
    }
    this.particles ??= Array.from({ length: PARTICLES }, () => this.newParticle());
    c.globalCompositeOperation = 'destination-out';
    c.fillStyle = 'rgba(0, 0, 0, 0.06)';
    c.fillRect(0, 0, this.width, this.height);
    c.globalCompositeOperation = 'source-over';
    c.strokeStyle = this.ink.flow;
    c.lineWidth = 1;
    c.beginPath();
    const extent = this.motion.scale;
    for (const p of this.particles) {
      const v = this.velocityNear(p.x, p.y);
      if (!v || ++p.age > PARTICLE_LIFE) {
        Object.assign(p, this.newParticle(), { age: 0 });
        continue;
      }
      // Slow places are shown as well: a particle's speed grows with the root of the flow's.
      const size = Math.hypot(...v) || 1;
      const dt = (0.006 * extent * Math.sqrt(Math.min(1, size / this.motion.speed))) / size;
      const [x, y] = [p.x + dt * v[0], p.y + dt * v[1]];
      c.moveTo(...this.place(p.x, p.y));
      c.lineTo(...this.place(x, y));
      [p.x, p.y] = [x, y];
    }
    c.stroke();
  }

  // For those who want no motion: the directions of f.
  drawArrows(c) {
    c.clearRect(0, 0, this.width, this.height);
    c.strokeStyle = this.ink.flow;
    c.lineWidth = 1;
    c.beginPath();
    for (let px = 14; px < this.width; px += 28) {
      for (let py = 14; py < this.height; py += 28) {
        const v = this.velocityNear(...this.point(px, py));
        if (!v) continue;
        const size = Math.hypot(...v) || 1;
        const [dx, dy] = [(9 * v[0]) / size, (-9 * v[1]) / size];
        c.moveTo(px - dx, py - dy);
        c.lineTo(px + dx, py + dy);
        c.lineTo(px + 0.4 * dx - 0.4 * dy, py + 0.4 * dy + 0.4 * dx);
      }
    }
    c.stroke();
  }

  drawLive(time) {
    const c = this.live.getContext('2d');
    c.clearRect(0, 0, this.width, this.height);
    const selected = this.drawing?.selected;
    if (selected) {
      c.strokeStyle = this.ink.accent;
      c.lineWidth = 2;
      c.stroke(pathOfShape(selected, (x, y) => this.place(x, y), this.scale));
      for (const handle of handlesOf(selected)) this.disc(c, handle, 6, this.ink.field, this.ink.accent);
    }
    this.overlay(c, time);
  }
}
