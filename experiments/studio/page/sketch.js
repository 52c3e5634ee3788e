// SPDX-License-Identifier: BSD-3-Clause
// The drawing and what pointers and keys do to it. Coordinates are the drawing's; y points up.
import { boxBetween, handlesOf, movedShape, resizedShape, roundedShape, scaledShape, shapeContains, shapeIsTiny } from './shapes.js';

const MOST_UNDO = 100;
const EDGE = 0.05; // share of the field at each side where no demonstration is drawn: the safe set stays off its edge
const HINTS = {
  stroke: 'Draw the motion as it should be, at the speed that it should have; all demonstrations end near one goal.',
  ball: 'Drag from the middle of the circle.',
  box: 'Drag from one corner to the other.',
  polygon: 'Click the corners; click the first one again, or press Enter, to close it.',
  initial: 'Drag a box: every motion that starts in it shall be safe. Without one, it is the box around the starts.',
  select: 'Drag an obstacle to move it, its handles to resize it.',
  erase: 'Click a demonstration or an obstacle.',
  play: 'Click a start: the motion runs. Drag the moving point to push it.',
};

const empty = () => ({ name: 'motion', unit: 'm', field: [0, 0, 1, 0.75], seed: 0, strokes: [], obstacles: [], initial: null });

export class Sketch {
  constructor(portrait, player) {
    this.portrait = portrait;
    this.player = player;
    this.drawing = empty();
    this.undone = [];
    this.done = [];
    this.tool = 'stroke';
    this.selected = -1;
    this.onChange = () => {}; // the drawing is another
    this.onTool = () => {};
    const box = portrait.box;
    box.addEventListener('pointerdown', (event) => this.down(event));
    box.addEventListener('pointermove', (event) => this.move(event));
    box.addEventListener('pointerup', (event) => this.up(event));
    box.addEventListener('pointercancel', () => this.abandon());
    box.addEventListener('keydown', (event) => this.key(event));
    box.addEventListener('focus', () => box.matches(':focus-visible') && (this.cross ??= this.middle()));
    box.addEventListener('blur', () => (this.cross = null));
    const drawPlayer = portrait.overlay;
    portrait.overlay = (context, time) => {
      drawPlayer(context, time);
      this.drawOverlay(context);
    };
    this.show();
  }

  // ---- the drawing as a whole

  set(drawing) {
    this.drawing = drawing;
    this.selected = -1;
    this.show();
  }

  // Keeps the drawing before a change, for undo.
  change(drawing) {
    this.done.push(this.drawing);
    if (this.done.length > MOST_UNDO) this.done.shift();
    this.undone = [];
    this.drawing = drawing;
    this.show();
    this.onChange();
  }

  travel(from, to) {
    if (!from.length) return;
    to.push(this.drawing);
    this.drawing = from.pop();
    this.selected = -1;
    this.show();
    this.onChange();
  }

  undo() {
    this.travel(this.done, this.undone);
  }

  redo() {
    this.travel(this.undone, this.done);
  }

  clear() {
    this.selected = -1;
    this.change({ ...this.drawing, strokes: [], obstacles: [], initial: null });
  }

  show() {
    const { field } = this.drawing;
    this.portrait.drawing = { ...this.drawing, selected: this.drawing.obstacles[this.selected] };
    this.portrait.setField(field);
  }

  pick(tool) {
    this.finishPolygon();
    this.tool = tool;
    if (tool !== 'select') this.selected = -1;
    this.show();
    this.onTool();
  }

  hint() {
    return HINTS[this.tool];
  }

  size() {
    return this.drawing.field[2] - this.drawing.field[0];
  }

  grain() {
    return 10 ** Math.floor(Math.log10(this.size() / 2000));
  }

  middle() {
    const [x0, y0, x1, y1] = this.drawing.field;
    return [(x0 + x1) / 2, (y0 + y1) / 2];
  }

  inset([x, y], share = 0) {
    const [x0, y0, x1, y1] = this.drawing.field;
    const [a, b] = [share * (x1 - x0), share * (y1 - y0)];
    return [Math.min(x1 - a, Math.max(x0 + a, x)), Math.min(y1 - b, Math.max(y0 + b, y))];
  }

  where(event) {
    const at = this.portrait.box.getBoundingClientRect();
    return this.portrait.point(event.clientX - at.left, event.clientY - at.top);
  }

  // ---- pointers

  down(event) {
    if (event.button > 0 || this.action) return;
    this.cross = null;
    this.portrait.box.setPointerCapture(event.pointerId);
    this.portrait.box.focus({ preventScroll: true });
    const at = this.where(event);
    this.begin(at, event.timeStamp);
  }

  begin(at, time) {
    const { tool, drawing } = this;
    if (tool === 'play') {
      if (this.player.holds(at)) {
        this.action = { kind: 'push' };
        this.player.push(at);
      } else if (this.portrait.motion) {
        this.player.start(this.inset(at));
      }
    } else if (tool === 'stroke') {
      this.action = { kind: 'stroke', samples: [[time, ...this.inset(at, EDGE)]] };
    } else if (tool === 'ball' || tool === 'box' || tool === 'initial') {
      this.action = { kind: tool, from: this.inset(at) };
    } else if (tool === 'polygon') {
      this.corner(at);
    } else if (tool === 'select') {
      this.grab(at);
    } else if (tool === 'erase') {
      this.erase(at);
    }
  }

  move(event) {
    if (!this.action) {
      this.pointer = this.where(event);
      return;
    }
    const events = event.getCoalescedEvents?.() ?? [];
    for (const one of events.length ? events : [event]) this.go(this.where(one), one.timeStamp);
  }

  go(at, time) {
    const action = this.action;
    if (action.kind === 'stroke') {
      const last = action.samples[action.samples.length - 1];
      if (time > last[0]) action.samples.push([time, ...this.inset(at, EDGE)]);
    } else if (action.kind === 'push') {
      this.player.push(this.inset(at));
    } else if (action.kind === 'move') {
      this.replaceSelected(movedShape(action.shape, at[0] - action.from[0], at[1] - action.from[1]));
    } else if (action.kind === 'resize') {
      this.replaceSelected(resizedShape(action.shape, action.handle, at));
    } else {
      action.to = this.inset(at);
    }
  }

  up(event) {
    if (!this.action) return;
    const action = this.action;
    this.action = null;
    if (action.kind === 'push') return this.player.release();
    if (action.kind === 'stroke') return this.addStroke([...action.samples, [event.timeStamp, ...this.inset(this.where(event), EDGE)]]);
    if (action.kind === 'move' || action.kind === 'resize') {
      const changed = this.drawing;
      this.drawing = action.before;
      if (changed !== action.before) this.change(changed);
      return undefined;
    }
    return this.addDragged(action.kind, action.from, this.inset(this.where(event)));
  }

  abandon() {
    if (this.action?.before) this.drawing = this.action.before;
    if (this.action?.kind === 'push') this.player.release();
    this.action = null;
    this.polygon = null;
    this.show();
  }

  // ---- what they do

  addStroke(samples) {
    const rising = samples.filter(([t], i) => i === 0 || t > samples[i - 1][0]);
    const length = rising.reduce((sum, [, x, y], i) => (i ? sum + Math.hypot(x - rising[i - 1][1], y - rising[i - 1][2]) : 0), 0);
    if (rising.length < 8 || length < 0.05 * this.size()) return;
    const [start] = rising[0];
    const round = (v) => Number(v.toFixed(9));
    const stroke = { t: rising.map(([t]) => round((t - start) / 1000)), x: rising.map(([, x]) => round(x)), y: rising.map(([, , y]) => round(y)) };
    this.change({ ...this.drawing, strokes: [...this.drawing.strokes, stroke] });
  }

  addObstacle(shape) {
    if (shapeIsTiny(shape, 0.01 * this.size())) return;
    this.change({ ...this.drawing, obstacles: [...this.drawing.obstacles, roundedShape(shape, this.grain())] });
  }

  dragged(kind, from, to) {
    if (kind === 'ball') return { type: 'ball', center: from, radius: Math.hypot(to[0] - from[0], to[1] - from[1]) };
    return boxBetween(from, to);
  }

  addDragged(kind, from, to) {
    const shape = this.dragged(kind, from, to);
    if (kind !== 'initial') return this.addObstacle(shape);
    return this.change({ ...this.drawing, initial: shapeIsTiny(shape, 0.01 * this.size()) ? null : shape });
  }

  corner(at) {
    this.polygon ??= [];
    const near = this.polygon.length > 2 && Math.hypot(at[0] - this.polygon[0][0], at[1] - this.polygon[0][1]) * this.portrait.scale < 14;
    if (near) return this.finishPolygon();
    this.polygon.push(this.inset(at));
    return undefined;
  }

  finishPolygon() {
    const vertices = this.polygon;
    this.polygon = null;
    if (vertices && vertices.length > 2) this.addObstacle({ type: 'polygon', vertices });
  }

  grab(at) {
    const { obstacles } = this.drawing;
    const current = obstacles[this.selected];
    const handle = current ? handlesOf(current).findIndex((h) => Math.hypot(h[0] - at[0], h[1] - at[1]) * this.portrait.scale < 16) : -1;
    if (handle < 0) this.selected = obstacles.findLastIndex((shape) => shapeContains(shape, at));
    this.show();
    if (this.selected < 0) return;
    const shape = obstacles[this.selected];
    this.action = { kind: handle < 0 ? 'move' : 'resize', shape, handle, from: at, before: this.drawing };
  }

  replaceSelected(shape) {
    this.drawing = { ...this.drawing, obstacles: this.drawing.obstacles.map((one, i) => (i === this.selected ? roundedShape(shape, this.grain()) : one)) };
    this.show();
  }

  removeObstacle(index) {
    this.selected = -1;
    this.change({ ...this.drawing, obstacles: this.drawing.obstacles.filter((_, i) => i !== index) });
  }

  erase(at) {
    const index = this.drawing.obstacles.findLastIndex((shape) => shapeContains(shape, at));
    if (index >= 0) return this.removeObstacle(index);
    const distance = (stroke) => Math.min(...stroke.x.map((x, i) => Math.hypot(x - at[0], stroke.y[i] - at[1]))) * this.portrait.scale;
    const near = this.drawing.strokes.findIndex((stroke) => distance(stroke) < 14);
    if (near >= 0) return this.change({ ...this.drawing, strokes: this.drawing.strokes.filter((_, i) => i !== near) });
    const { initial } = this.drawing;
    if (initial && shapeContains(initial, at)) this.change({ ...this.drawing, initial: null });
    return undefined;
  }

  // ---- keys alone

  key(event) {
    const steps = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
    const step = steps[event.key];
    const size = (event.shiftKey ? 0.005 : 0.025) * this.size();
    const chosen = this.tool === 'select' ? this.drawing.obstacles[this.selected] : null;
    if (step) {
      this.cross ??= this.middle();
      if (chosen) this.change({ ...this.drawing, obstacles: this.drawing.obstacles.map((one, i) => (i === this.selected ? movedShape(one, step[0] * size, step[1] * size) : one)) });
      else this.cross = this.inset([this.cross[0] + step[0] * size, this.cross[1] + step[1] * size]);
    } else if (chosen && (event.key === '+' || event.key === '-')) {
      this.change({ ...this.drawing, obstacles: this.drawing.obstacles.map((one, i) => (i === this.selected ? scaledShape(one, event.key === '+' ? 1.1 : 1 / 1.1) : one)) });
    } else if (chosen && (event.key === 'Delete' || event.key === 'Backspace')) {
      this.removeObstacle(this.selected);
    } else if (event.key === ' ' || event.key === 'Enter') {
      this.act(event.key);
    } else if (event.key === 'Escape') {
      this.via = null;
      this.abandon();
      this.player.stop();
      this.selected = -1;
      this.show();
    } else {
      return;
    }
    event.preventDefault();
    event.stopPropagation();
  }

  act(key) {
    if (this.polygon && key === 'Enter') return this.finishPolygon();
    const at = (this.cross ??= this.middle());
    if (this.tool === 'stroke') {
      this.via ??= [];
      const last = this.via[this.via.length - 1];
      if (!last || last[0] !== at[0] || last[1] !== at[1]) this.via.push(this.inset(at, EDGE));
      if (key === 'Enter' && this.via.length > 1) {
        this.addStroke(smoothStroke(this.via, 0.4 * this.size()));
        this.via = null;
      }
    } else if (this.tool === 'ball') {
      this.addObstacle({ type: 'ball', center: at, radius: 0.08 * this.size() });
    } else if (this.tool === 'box' || this.tool === 'initial') {
      if (!this.pin) this.pin = at;
      else {
        this.addDragged(this.tool, this.pin, at);
        this.pin = null;
      }
    } else {
      this.begin(at, 0);
      this.action = null;
    }
    return undefined;
  }

  // ---- what is under way

  drawOverlay(c) {
    const { ink } = this.portrait;
    const { action } = this;
    if (action?.kind === 'stroke') this.portrait.line(c, action.samples.map(([, x, y]) => [x, y]), ink.demonstration, 3);
    if (action?.to) this.outline(c, this.dragged(action.kind, action.from, action.to));
    if (this.pin && this.cross) this.outline(c, this.dragged('box', this.pin, this.cross));
    if (this.polygon) {
      const next = this.cross ?? this.pointer;
      this.portrait.line(c, next ? [...this.polygon, next] : this.polygon, ink['unsafe-edge'], 2);
      this.polygon.forEach((corner) => this.portrait.disc(c, corner, 5, ink.field, ink['unsafe-edge']));
    }
    if (this.via) {
      this.portrait.line(c, [...this.via, ...(this.cross ? [this.cross] : [])], ink.demonstration, 2, [4, 4]);
      this.via.forEach((point) => this.portrait.disc(c, point, 4, ink.demonstration));
    }
    if (this.cross) {
      const [px, py] = this.portrait.place(...this.cross);
      c.strokeStyle = ink.accent;
      c.lineWidth = 2;
      c.beginPath();
      c.moveTo(px - 12, py);
      c.lineTo(px + 12, py);
      c.moveTo(px, py - 12);
      c.lineTo(px, py + 12);
      c.stroke();
    }
  }

  outline(c, shape) {
    const { ink } = this.portrait;
    const points = shape.type === 'ball'
      ? Array.from({ length: 65 }, (_, k) => [shape.center[0] + shape.radius * Math.cos((k * Math.PI) / 32), shape.center[1] + shape.radius * Math.sin((k * Math.PI) / 32)])
      : [...handlesOf(shape), handlesOf(shape)[0]];
    this.portrait.line(c, points, this.tool === 'initial' ? ink.initial : ink['unsafe-edge'], 2);
  }
}

// A stroke through the places chosen by keys, at about `speed` a second, from rest to rest: Catmull-Rom curves.
function smoothStroke(via, speed) {
  const at = (k) => via[Math.max(0, Math.min(via.length - 1, k))];
  const dense = [];
  for (let k = 0; k + 1 < via.length; ++k) {
    for (let s = 0; s < 1; s += 0.02) {
      dense.push([0, 1].map((i) => {
        const [a, b, c, d] = [at(k - 1)[i], at(k)[i], at(k + 1)[i], at(k + 2)[i]];
        return b + 0.5 * s * (c - a + s * (2 * a - 5 * b + 4 * c - d + s * (3 * (b - c) + d - a)));
      }));
    }
  }
  dense.push(at(via.length - 1));
  const length = [0];
  for (let i = 1; i < dense.length; ++i) length.push(length[i - 1] + Math.hypot(dense[i][0] - dense[i - 1][0], dense[i][1] - dense[i - 1][1]));
  const total = length[length.length - 1];
  const seconds = Math.max(1, total / speed);
  const samples = [];
  for (let k = 0, i = 0; k <= 150; ++k) {
    const u = k / 150;
    const wanted = total * u ** 3 * (10 - 15 * u + 6 * u * u);
    while (i + 2 < length.length && length[i + 1] < wanted) ++i;
    const s = Math.min(1, (wanted - length[i]) / (length[i + 1] - length[i] || 1));
    samples.push([1000 * seconds * u, dense[i][0] + s * (dense[i + 1][0] - dense[i][0]), dense[i][1] + s * (dense[i + 1][1] - dense[i][1])]);
  }
  return samples;
}
