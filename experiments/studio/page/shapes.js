// SPDX-License-Identifier: BSD-3-Clause
// Balls, boxes and polygons as a drawing has them.

export function pathOfShape(shape, place, scale) {
  const path = new Path2D();
  if (shape.type === 'ball') {
    path.arc(...place(...shape.center), Math.max(0, shape.radius * scale), 0, 2 * Math.PI);
  } else {
    cornersOf(shape).forEach((corner, k) => (k ? path.lineTo(...place(...corner)) : path.moveTo(...place(...corner))));
    path.closePath();
  }
  return path;
}

export function cornersOf(shape) {
  if (shape.type === 'polygon') return shape.vertices;
  const [[x0, y0], [x1, y1]] = [shape.lower, shape.upper];
  return [[x0, y0], [x1, y0], [x1, y1], [x0, y1]];
}

export function shapeContains(shape, [x, y]) {
  if (shape.type === 'ball') return Math.hypot(x - shape.center[0], y - shape.center[1]) <= shape.radius;
  if (shape.type === 'box') return x >= shape.lower[0] && x <= shape.upper[0] && y >= shape.lower[1] && y <= shape.upper[1];
  let inside = false;
  const v = shape.vertices;
  for (let i = 0, j = v.length - 1; i < v.length; j = i++) {
    if (v[i][1] > y !== v[j][1] > y && x < ((v[j][0] - v[i][0]) * (y - v[i][1])) / (v[j][1] - v[i][1]) + v[i][0]) inside = !inside;
  }
  return inside;
}

// Places that can be dragged to change the shape's size.
export function handlesOf(shape) {
  if (shape.type === 'ball') return [[shape.center[0] + shape.radius, shape.center[1]]];
  return cornersOf(shape);
}

export function movedShape(shape, dx, dy) {
  const move = ([x, y]) => [x + dx, y + dy];
  if (shape.type === 'ball') return { ...shape, center: move(shape.center) };
  if (shape.type === 'box') return { ...shape, lower: move(shape.lower), upper: move(shape.upper) };
  return { ...shape, vertices: shape.vertices.map(move) };
}

export function boxBetween([x0, y0], [x1, y1]) {
  return { type: 'box', lower: [Math.min(x0, x1), Math.min(y0, y1)], upper: [Math.max(x0, x1), Math.max(y0, y1)] };
}

// The shape with its handle k moved to `to`.
export function resizedShape(shape, k, to) {
  if (shape.type === 'ball') return { ...shape, radius: Math.hypot(to[0] - shape.center[0], to[1] - shape.center[1]) };
  if (shape.type === 'box') return boxBetween(cornersOf(shape)[(k + 2) % 4], to);
  return { ...shape, vertices: shape.vertices.map((corner, i) => (i === k ? to : corner)) };
}

export function scaledShape(shape, factor) {
  if (shape.type === 'ball') return { ...shape, radius: shape.radius * factor };
  const corners = cornersOf(shape);
  const middle = [0, 1].map((i) => corners.reduce((sum, corner) => sum + corner[i], 0) / corners.length);
  const grow = (corner) => corner.map((value, i) => middle[i] + factor * (value - middle[i]));
  if (shape.type === 'box') return { ...shape, lower: grow(shape.lower), upper: grow(shape.upper) };
  return { ...shape, vertices: shape.vertices.map(grow) };
}

// With no more digits than a drawing has: multiples of `grain`, a power of ten.
export function roundedShape(shape, grain) {
  const round = (value) => Number((Math.round(value / grain) * grain).toPrecision(12));
  return Object.fromEntries(Object.entries(shape).map(([key, value]) => [key,
    typeof value === 'number' ? round(value) : Array.isArray(value) ? value.map((v) => (Array.isArray(v) ? v.map(round) : round(v))) : value]));
}

export function shapeIsTiny(shape, least) {
  if (shape.type === 'ball') return shape.radius < least;
  const corners = cornersOf(shape);
  const range = (i) => Math.max(...corners.map((c) => c[i])) - Math.min(...corners.map((c) => c[i]));
  return corners.length < 3 || range(0) < least || range(1) < least;
}
