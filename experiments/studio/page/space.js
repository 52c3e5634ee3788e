// SPDX-License-Identifier: BSD-3-Clause
// A run in three dimensions on one canvas: workspace, demonstrations and motions as lines, the obstacle by its
// outlines, and the safe set and the obstacle cut by a plane. Dragging (or arrow keys) turns it.
import { edgeOfSet, fillOfSet } from './contours.js';

const SIDE = 61;

export class Space {
  constructor(canvas, motion) {
    this.canvas = canvas;
    this.motion = motion;
    this.turn = 0.6;
    this.tilt = 0.45;
    this.axis = 2;
    this.share = 0.5;
    this.middle = motion.lower.map((v, i) => (v + motion.upper[i]) / 2);
    this.size = Math.hypot(...motion.lower.map((v, i) => motion.upper[i] - v));
    this.paths = motion.demonstrations.map(({ points }) => motion.path(points[0]));
    canvas.addEventListener('pointerdown', (event) => {
      canvas.setPointerCapture(event.pointerId);
      this.drag = [event.clientX, event.clientY];
    });
    canvas.addEventListener('pointermove', (event) => {
      if (!this.drag) return;
      this.rotate((event.clientX - this.drag[0]) / 150, (event.clientY - this.drag[1]) / 150);
      this.drag = [event.clientX, event.clientY];
    });
    canvas.addEventListener('pointerup', () => (this.drag = null));
    canvas.addEventListener('keydown', (event) => {
      const by = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, -0.1], ArrowDown: [0, 0.1] }[event.key];
      if (!by) return;
      event.preventDefault();
      this.rotate(...by);
    });
    new ResizeObserver(() => this.draw()).observe(canvas);
    this.cut(2, 0.5);
  }

  rotate(turn, tilt) {
    this.turn += turn;
    this.tilt = Math.max(-1.5, Math.min(1.5, this.tilt + tilt));
    this.draw();
  }

  // The plane at `share` (0 to 1) of the workspace along `axis`.
  cut(axis, share) {
    this.axis = axis;
    this.share = share;
    const { motion } = this;
    this.axes = [0, 1, 2].filter((i) => i !== axis);
    this.at = [...motion.goal];
    this.at[axis] = motion.lower[axis] + share * (motion.upper[axis] - motion.lower[axis]);
    this.barrier = motion.grid(SIDE, (x) => motion.barrier(x), this.axes, this.at);
    this.draw();
  }

  project(x) {
    const [a, b, c] = x.map((v, i) => (v - this.middle[i]) / this.size);
    const [u, w] = [a * Math.cos(this.turn) - b * Math.sin(this.turn), a * Math.sin(this.turn) + b * Math.cos(this.turn)];
    const k = Math.min(this.width, this.height) * 1.05;
    return [this.width / 2 + k * u, this.height / 2 - k * (c * Math.cos(this.tilt) + w * Math.sin(this.tilt))];
  }

  draw() {
    const ratio = Math.min(2, window.devicePixelRatio || 1);
    [this.width, this.height] = [this.canvas.clientWidth, this.canvas.clientHeight];
    this.canvas.width = this.width * ratio;
    this.canvas.height = this.height * ratio;
    const c = this.canvas.getContext('2d');
    c.setTransform(ratio, 0, 0, ratio, 0, 0);
    const style = getComputedStyle(this.canvas);
    const colour = (name) => style.getPropertyValue(`--${name}`).trim();
    const { lower, upper } = this.motion;
    const line = (points, ink, width) => {
      c.beginPath();
      points.forEach((p, k) => (k ? c.lineTo(...this.project(p)) : c.moveTo(...this.project(p))));
      c.strokeStyle = ink;
      c.lineWidth = width;
      c.stroke();
    };
    for (let k = 0; k < 8; ++k) {
      for (let i = 0; i < 3; ++i) {
        if ((k >> i) & 1) continue;
        const corner = (bits) => [0, 1, 2].map((axis) => ((bits >> axis) & 1 ? upper[axis] : lower[axis]));
        line([corner(k), corner(k | (1 << i))], colour('outside'), 1);
      }
    }
    const place = this.placing(this.axis, this.at[this.axis], SIDE);
    c.globalAlpha = 0.75;
    c.fillStyle = colour('safe');
    c.fill(fillOfSet(this.barrier, SIDE, place));
    c.globalAlpha = 1;
    c.strokeStyle = colour('safe-edge');
    c.lineWidth = 2;
    c.stroke(edgeOfSet(this.barrier, SIDE, place));
    this.drawObstacle(c, colour);
    for (const path of this.paths) line(path, colour('motion'), 1.5);
    for (const { points, trains } of this.motion.demonstrations) line(points, colour(trains ? 'demonstration' : 'held-out'), 1.5);
    c.fillStyle = colour('goal');
    c.beginPath();
    c.arc(...this.project(this.motion.goal), 6, 0, 2 * Math.PI);
    c.fill();
  }

  // From its levels on the run's grid: outlines on layers across all axes show the whole of it, and where the plane is,
  // on the layer nearest to it, it is filled.
  drawObstacle(c, colour) {
    if (!this.motion.run.levels) return;
    this.unsafe ??= unpackLevels(this.motion.run.levels);
    const { side } = this.unsafe;
    this.outlines ??= [0, 1, 2].flatMap((axis) =>
      [...Array(Math.ceil(side / 2)).keys()].map((k) => this.layer(axis, 2 * k)).filter(({ values }) => values.some((v) => v <= 0)));
    c.strokeStyle = colour('unsafe-edge');
    c.lineWidth = 1;
    c.globalAlpha = 0.6;
    for (const { values, axis, at } of this.outlines) c.stroke(edgeOfSet(values, side, this.placing(axis, at, side)));
    c.globalAlpha = 1;
    const { values } = this.layer(this.axis, Math.round(this.share * (side - 1)));
    const place = this.placing(this.axis, this.at[this.axis], side);
    c.fillStyle = colour('unsafe');
    c.fill(fillOfSet(values, side, place));
    c.stroke(edgeOfSet(values, side, place));
  }

  // The obstacle's levels on one layer of the grid.
  layer(axis, index) {
    const { side, values } = this.unsafe;
    const stride = [side * side, side, 1];
    const [first, second] = [0, 1, 2].filter((i) => i !== axis);
    const flat = new Float32Array(side * side);
    for (let a = 0; a < side; ++a) {
      for (let b = 0; b < side; ++b) flat[a * side + b] = values[a * stride[first] + b * stride[second] + index * stride[axis]];
    }
    const { lower, upper } = this.motion;
    return { values: flat, axis, at: lower[axis] + (index / (side - 1)) * (upper[axis] - lower[axis]) };
  }

  // Where grid coordinates of a plane across `axis` are drawn.
  placing(axis, at, side) {
    const { lower, upper } = this.motion;
    const axes = [0, 1, 2].filter((i) => i !== axis);
    return (...coordinates) => {
      const x = [at, at, at];
      coordinates.forEach((v, k) => (x[axes[k]] = lower[axes[k]] + (v / (side - 1)) * (upper[axes[k]] - lower[axes[k]])));
      return this.project(x);
    };
  }
}

function unpackLevels(levels) {
  const bytes = Uint8Array.from(atob(levels.unsafe.f32), (letter) => letter.charCodeAt(0));
  return { side: levels.side, values: new Float32Array(bytes.buffer) };
}
