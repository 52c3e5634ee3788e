// SPDX-License-Identifier: BSD-3-Clause
// The studio's page: what the server tells is shown, what a person does is told to the server.
import { ask, listen, send, tell } from './connection.js';
import { Motion } from './motion.js';
import { Player } from './play.js';
import { Portrait } from './portrait.js';
import { Sketch } from './sketch.js';
import { Space } from './space.js';
import { showHistory } from './history.js';
import { element, GUARANTEES, showStatement } from './statement.js';

const $ = (id) => document.getElementById(id);
const portrait = new Portrait($('portrait'));
const player = new Player(portrait);
const sketch = new Sketch(portrait, player);
const KEYS = { d: 'stroke', c: 'ball', b: 'box', p: 'polygon', s: 'initial', m: 'select', e: 'erase', r: 'play' };
const WORKS = { learn: 'Learning', resume: 'Training on', adapt: 'Adapting' };

let state = null;
let run = null; // of the number run.number
let drawingVersion = -1;
let saving = null; // the drawing has changed and is on its way to the server
let preview = { refusals: [], warnings: [] };
let clockBase = 0; // when the job began, by this page's clock

// For tests and for the console of whoever looks closer.
window.studio = { portrait, player, sketch, get run() { return run; }, get state() { return state; } };

function complain(error) {
  $('message').textContent = error ? `${error.message ?? error}` : '';
}

async function attempt(act) {
  complain('');
  try {
    return await act();
  } catch (error) {
    complain(error);
    return null;
  }
}

// ---- the drawing

function save() {
  clearTimeout(saving);
  saving = setTimeout(saveNow, 250);
}

async function saveNow() {
  clearTimeout(saving);
  if (saving === null) return;
  saving = null;
  await attempt(async () => {
    ({ drawing_version: drawingVersion } = await tell('drawing', sketch.drawing));
    preview = await ask('preview');
  });
  showProblems();
}

function showProblems() {
  const list = $('problems');
  const shown = [...preview.refusals.map((text) => ['refusal', text]), ...preview.warnings.map((text) => ['warning', text])];
  if (preview.moved) shown.push(['warning', 'The demonstrations end apart: each is moved to end where they do on the average.']);
  list.replaceChildren(...shown.map(([kind, text]) => element('li', text, { class: kind })));
  portrait.autoInitial = preview.initial ?? null;
  portrait.goal = preview.goal ?? null;
  portrait.refresh();
  show();
}

const same = (a, b) => JSON.stringify(a) === JSON.stringify(b);

// Why the certificate of the run is not of the scene that is drawn, or ''.
function voidness() {
  const learned = state?.learned;
  if (!run || !learned || run.dimension !== 2 || running()) return '';
  if (!same(learned.strokes, sketch.drawing.strokes)) return 'Void: this speaks of other demonstrations than those drawn now. Learn again.';
  if (!same(run.obstacles ?? learned.obstacles, sketch.drawing.obstacles)) return 'Void: the obstacles are not where they were. Adapt, or learn again.';
  if (!same(learned.initial, sketch.drawing.initial)) return 'Void: the start region is another. Learn again.';
  return '';
}

// The proof is over; the motion is still being measured.
const isProved = () => state?.job?.certified > 0;
const running = () => state?.job?.state === 'running';

// ---- what is shown

function show() {
  const works = running();
  const busy = works && !isProved();
  const drawn = sketch.drawing.strokes.length > 0;
  const isVoid = voidness();
  const obstaclesMoved = isVoid.includes('obstacles');
  $('learn').disabled = works || state?.look_only || !drawn || preview.refusals.length > 0;
  $('learn').textContent = run && !isVoid && !works ? 'Learn again' : 'Learn';
  $('cancel').hidden = !works;
  $('adapt').hidden = works || state?.look_only || !obstaclesMoved;
  $('adapt').className = obstaclesMoved ? 'main' : '';
  $('learn').className = obstaclesMoved ? '' : 'main';
  $('resume').hidden = works || !run || run.finished || isVoid !== '' || state?.job?.state === 'cancelled';
  $('undo').disabled = sketch.done.length === 0;
  $('redo').disabled = sketch.undone.length === 0;
  $('statement-section').hidden = !run || busy;
  $('downloads').hidden = !run || works || isVoid !== '';
  $('play-section').hidden = !run || run.dimension !== 2;
  document.querySelector('[data-tool="play"]').disabled = !run;
  portrait.void = isVoid !== '' || busy;
  const chip = $('guarantee');
  const guarantee = run?.certificate.guarantee;
  chip.dataset.guarantee = isVoid ? 'void' : busy ? 'none' : (guarantee ?? 'none');
  chip.textContent = busy ? WORKS[state.job.kind] : isVoid ? 'Certificate void' : run ? GUARANTEES[guarantee] : 'Draw a motion';
  if (run) {
    showHistory($('history'), run);
    if (!busy) showStatement($('statement'), run, isVoid);
  } else {
    $('history').toggleAttribute('hidden', true);
  }
  $('folder').textContent = state ? `Everything lies in ${state.folder}` : '';
  const flat = !run || run.dimension === 2;
  $('hint').textContent = flat ? sketch.hint() : 'Drag the picture, or use the arrow keys, to turn it.';
  $('learn').hidden = !flat;
  document.querySelector('[href$="demonstrations"]').parentElement.hidden = !flat;
  $('look-only').hidden = !(state?.look_only && flat);
  portrait.refresh();
  showProgress();
  showPlay();
}

function showProgress() {
  const job = state?.job;
  if (!job) {
    $('progress').textContent = '';
    return;
  }
  const seconds = (job.state === 'running' ? (performance.now() - clockBase) / 1000 : job.seconds).toFixed(1);
  const rounds = run ? `round ${run.rounds}` : 'fitting the demonstrations';
  const loss = run?.history.loss?.at(-1);
  const left = run ? `, ${portrait.counterexamples.length} counterexamples left${loss ? `, loss ${Number(loss.toPrecision(3))}` : ''}` : '';
  $('progress').textContent = {
    running: isProved() ? `Proof over after ${job.certified.toFixed(1)} s; measuring the motion` : `${WORKS[job.kind]}: ${seconds} s, ${rounds}${left}`,
    done: `${job.kind === 'adapt' ? 'Adapted' : 'Learned'} in ${(job.certified || job.seconds).toFixed(1)} s.`,
    cancelled: `Cancelled after ${seconds} s. What was learned so far is shown; nothing is guaranteed of it.`,
    failed: `Failed after ${seconds} s: ${job.message}`,
  }[job.state];
}

function showPlay() {
  $('play-state').textContent = player.words();
}

async function takeRun() {
  const text = await ask('run');
  run = text;
  if (run === null) {
    portrait.setMotion(null);
    player.stop();
    return;
  }
  const motion = new Motion(run);
  portrait.setMotion(motion);
  showSpace(motion);
}

let space = null;
function showSpace(motion) {
  const flat = motion.n === 2;
  $('portrait').hidden = !flat;
  $('space').hidden = $('cuts').hidden = motion.n !== 3;
  document.querySelector('.tools').hidden = !flat;
  if (motion.n > 3) complain('This run has more than three dimensions: there is no picture of it.');
  if (motion.n !== 3) return;
  space = new Space($('space'), motion);
  const cut = () => space.cut(Number($('cut-axis').value), Number($('cut-place').value));
  $('cut-axis').onchange = $('cut-place').oninput = cut;
}

let taking = false;
async function onState(next) {
  const before = state;
  state = next;
  if (running() && !(before?.job?.state === 'running')) clockBase = performance.now() - 1000 * next.job.seconds;
  if (next.drawing_version !== drawingVersion && saving === null) {
    drawingVersion = next.drawing_version;
    sketch.set(next.drawing);
    if (next.drawing.strokes.length) preview = await ask('preview').catch(() => preview);
    showProblems();
  }
  if (!taking && next.run_version !== (run?.number ?? (before ? before.run_version : -1))) {
    taking = true;
    await attempt(takeRun);
    taking = false;
    if (state.run_version !== next.run_version) return onState(state);
  }
  return show();
}

// ---- what a person does

async function act(name) {
  await saveNow();
  await attempt(async () => onState(await tell(name)));
}

for (const name of ['learn', 'adapt', 'resume', 'cancel']) $(name).addEventListener('click', () => act(name));
$('undo').addEventListener('click', () => sketch.undo());
$('redo').addEventListener('click', () => sketch.redo());
$('clear').addEventListener('click', () => sketch.clear());
for (const button of document.querySelectorAll('[data-tool]')) button.addEventListener('click', () => sketch.pick(button.dataset.tool));
sketch.onTool = () => {
  for (const button of document.querySelectorAll('[data-tool]')) button.setAttribute('aria-pressed', button.dataset.tool === sketch.tool);
  show();
};
sketch.onChange = () => {
  portrait.autoInitial = null;
  saving = 0;
  save();
  show();
};
player.onChange = showPlay;
player.certified = () => run?.certificate.guarantee === 'invariant' && !portrait.void;
document.addEventListener('keydown', (event) => {
  if (event.target.matches('input, select')) return;
  if ((event.ctrlKey || event.metaKey) && event.key.toLowerCase() === 'z') {
    event.preventDefault();
    if (event.shiftKey) sketch.redo();
    else sketch.undo();
  } else if (!event.ctrlKey && !event.metaKey && !event.altKey && KEYS[event.key]) {
    const button = document.querySelector(`[data-tool="${KEYS[event.key]}"]`);
    if (!button.disabled) sketch.pick(KEYS[event.key]);
  }
});
for (const [id, unit] of [['period', 's'], ['delay', 's'], ['noise', '']]) {
  const tellValue = () => {
    player.model[id] = Number($(id).value);
    document.querySelector(`output[for="${id}"]`).textContent = id === 'noise' ? `${Math.round(100 * $(id).value)} %` : `${$(id).value} ${unit}`;
  };
  $(id).addEventListener('input', tellValue);
  tellValue();
}
$('flow').addEventListener('change', () => (portrait.showFlow = $('flow').checked));

// Recordings in several files become one drawing.
async function take(files) {
  await saveNow();  // what was drawn just now comes before what is dropped
  let drawing = null;
  for (const file of files) {
    const answer = await attempt(() => send(file));
    if (answer?.opened !== 'demonstrations') return;
    const [a, b] = [drawing?.field ?? answer.drawing.field, answer.drawing.field];
    const field = [Math.min(a[0], b[0]), Math.min(a[1], b[1]), Math.max(a[2], b[2]), Math.max(a[3], b[3])];
    drawing = { ...answer.drawing, field, strokes: [...(drawing?.strokes ?? []), ...answer.drawing.strokes] };
  }
  sketch.change(drawing);
}
$('file').addEventListener('change', () => {
  const files = [...$('file').files];
  $('file').value = '';
  if (files.length) take(files);
});
for (const name of ['dragenter', 'dragover']) {
  document.addEventListener(name, (event) => {
    event.preventDefault();
    $('portrait').classList.add('dropping');
  });
}
for (const name of ['dragleave', 'drop']) document.addEventListener(name, () => $('portrait').classList.remove('dropping'));
document.addEventListener('drop', (event) => {
  event.preventDefault();
  const files = [...event.dataTransfer.files];
  if (files.length) take(files);
});

setInterval(() => running() && showProgress(), 100);
listen(onState, (lost) => ($('connection').hidden = !lost));
show();
