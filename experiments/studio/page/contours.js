// SPDX-License-Identifier: BSD-3-Clause
// The set {value <= 0} of a function on a grid of side x side points, the first axis slowest, by marching squares.
// `place` maps grid coordinates (a, b) in [0, side - 1] to [x, y] on the canvas.

const CORNERS = [[0, 0], [1, 0], [1, 1], [0, 1]];

// The part of one cell where the value is at most 0: a polygon in grid coordinates, perhaps empty.
function cellPolygon(values, side, a, b) {
  const v = CORNERS.map(([da, db]) => values[(a + da) * side + b + db]);
  const points = [];
  for (let k = 0; k < 4; ++k) {
    const next = (k + 1) % 4;
    if (v[k] <= 0) points.push([a + CORNERS[k][0], b + CORNERS[k][1]]);
    if (v[k] <= 0 === v[next] <= 0) continue;
    const s = v[k] / (v[k] - v[next]);
    points.push([a + CORNERS[k][0] + s * (CORNERS[next][0] - CORNERS[k][0]),
      b + CORNERS[k][1] + s * (CORNERS[next][1] - CORNERS[k][1]), 1]);
  }
  return points;
}

export function fillOfSet(values, side, place) {
  const path = new Path2D();
  const add = (points) => {
    points.forEach(([a, b], k) => (k === 0 ? path.moveTo(...place(a, b)) : path.lineTo(...place(a, b))));
    path.closePath();
  };
  const inside = (a, b) => values[a * side + b] <= 0;
  for (let a = 0; a + 1 < side; ++a) {
    let first = -1; // of the cells in a row that lie wholly inside
    for (let b = 0; b + 1 <= side; ++b) {
      const cell = b + 1 < side;
      const whole = cell && inside(a, b) && inside(a + 1, b) && inside(a, b + 1) && inside(a + 1, b + 1);
      if (whole && first < 0) first = b;
      if (!whole && first >= 0) {
        add([[a, first], [a + 1, first], [a + 1, b], [a, b]]);
        first = -1;
      }
      if (!whole && cell) {
        const points = cellPolygon(values, side, a, b);
        if (points.length > 2) add(points);
      }
    }
  }
  return path;
}

// The edge of the set as lines that go on from cell to cell, so that dashes do as well.
export function edgeOfSet(values, side, place) {
  const ends = new Map(); // by grid coordinates, the same in both cells of an edge: the lines that end there
  const lines = new Set();
  const name = (point) => `${point[0].toFixed(9)} ${point[1].toFixed(9)}`;
  const join = (from, to) => {
    const [a, b] = [ends.get(name(from)), ends.get(name(to))];
    for (const line of [a, b]) if (line) for (const end of [line[0], line[line.length - 1]]) ends.delete(name(end));
    if (a && name(a[0]) === name(from)) a.reverse();
    if (b && b !== a && name(b[0]) !== name(to)) b.reverse();
    const line = a === b && a ? [...a, to] : [...(a ?? [from]), ...(b ?? [to])];
    lines.delete(a);
    lines.delete(b);
    lines.add(line);
    if (name(line[0]) === name(line[line.length - 1])) return;
    ends.set(name(line[0]), line);
    ends.set(name(line[line.length - 1]), line);
  };
  for (let a = 0; a + 1 < side; ++a) {
    for (let b = 0; b + 1 < side; ++b) {
      const cuts = cellPolygon(values, side, a, b).filter((point) => point.length === 3);
      for (let k = 0; k + 1 < cuts.length; k += 2) join(cuts[k], cuts[k + 1]);
    }
  }
  const path = new Path2D();
  for (const line of lines)
    line.forEach((point, k) => (k ? path.lineTo(...place(point[0], point[1])) : path.moveTo(...place(point[0], point[1]))));
  return path;
}
