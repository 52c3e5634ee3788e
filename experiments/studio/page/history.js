// SPDX-License-Identifier: BSD-3-Clause
// The history of training as a small chart: counterexamples of each round as bars, loss as a line.

const SVG = 'http://www.w3.org/2000/svg';

function svgElement(name, attributes) {
  const made = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  return made;
}

export function showHistory(svg, run) {
  const { history } = run;
  svg.toggleAttribute('hidden', (history.round ?? []).length < 4);
  const rounds = history.round ?? [];
  const found = rounds.map((_, i) => Object.entries(history)
    .reduce((sum, [name, column]) => sum + (name.startsWith('count_') ? (column[i] ?? 0) : 0), 0));
  const [width, height] = [300, 90];
  svg.setAttribute('viewBox', `0 0 ${width} ${height}`);
  svg.replaceChildren();
  const top = Math.log10(1 + Math.max(10, ...found));
  const step = width / Math.max(12, rounds.length);
  found.forEach((count, i) => {
    const h = (Math.log10(1 + count) / top) * (height - 8);
    svg.append(svgElement('rect', { x: i * step + 1, y: height - h - 1, width: Math.max(1, step - 2), height: Math.max(count ? 2 : 1, h), class: count ? 'bad' : 'clean' }));
  });
  const loss = (history.loss ?? []).map((v) => (v > 0 ? Math.log10(v) : null));
  const known = loss.filter((v) => v !== null);
  if (known.length > 1) {
    const [low, high] = [Math.min(...known), Math.max(...known)];
    const points = loss.map((v, i) => (v === null ? null : `${(i + 0.5) * step},${8 + ((high - v) / (high - low || 1)) * (height - 16)}`));
    svg.append(svgElement('polyline', { points: points.filter(Boolean).join(' '), class: 'loss' }));
  }
  const last = found.length ? found[found.length - 1] : 0;
  svg.setAttribute('aria-label', `${rounds.length} rounds; ${last} counterexamples in the last one`);
}
