// SPDX-License-Identifier: BSD-3-Clause
// The page of one run, from the JSON in it.
import { Motion } from './motion.js';
import { Portrait } from './portrait.js';
import { Space } from './space.js';
import { GUARANTEES, showStatement } from './statement.js';
import { showHistory } from './history.js';

function showReport() {
  const run = JSON.parse(document.getElementById('run').textContent);
  const motion = new Motion(run);
  document.getElementById('guarantee').textContent = GUARANTEES[run.certificate.guarantee];
  document.getElementById('guarantee').dataset.guarantee = run.certificate.guarantee;
  showStatement(document.getElementById('statement'), run);
  showHistory(document.getElementById('history'), run);
  document.getElementById('history').closest('section').hidden = document.getElementById('history').hasAttribute('hidden');
  document.getElementById('about').textContent =
    `Seed ${run.seed}; trained ${run.created} by s2nnds ${run.version}. Obstacle: ${run.unsafe_in_words}. Start region: ${run.initial_in_words}.`;
  const box = document.getElementById('portrait');
  if (motion.n === 3) {
    box.hidden = true;
    const canvas = document.getElementById('space');
    canvas.hidden = false;
    new Space(canvas, motion);
    return;
  }
  if (motion.n !== 2) {
    box.hidden = true;
    document.getElementById('no-picture').hidden = false;
    return;
  }
  const portrait = new Portrait(box);
  portrait.setField([...motion.lower, ...motion.upper]);
  portrait.setMotion(motion);
  const paths = [];
  for (const { points } of motion.demonstrations) paths.push(motion.path(points[0]));
  portrait.overlay = (context) => paths.forEach((path) =>
    portrait.line(context, path, motion.safe(path[0]) ? portrait.ink.motion : portrait.ink.lost, 2.5));
  box.addEventListener('click', (event) => {
    const at = box.getBoundingClientRect();
    const x = portrait.point(event.clientX - at.left, event.clientY - at.top);
    if (motion.inWorkspace(x)) paths.push(motion.path(x));
  });
}

showReport();
