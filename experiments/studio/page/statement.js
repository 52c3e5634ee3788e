// SPDX-License-Identifier: BSD-3-Clause
// What is known of a run, in words.

export const GUARANTEES = {
  none: 'Nothing is guaranteed',
  sampled: 'No violation found among samples',
  conformal: 'Holds for most points, with confidence',
  proved: 'Conditions proved at every point',
  invariant: 'Proved safe: stays in the safe set, misses the obstacles, reaches the goal',
};

const CONDITIONS = {
  lyapunov_positive: 'V > 0 but at the goal',
  lyapunov_decrease: 'V falls along every motion',
  initial: 'the start region lies in the safe set',
  unsafe: 'no obstacle touches the safe set',
  containment: 'the safe set stays off the edge of the workspace',
  barrier_decrease: 'no motion leaves the safe set through its edge',
};

const NOT_SAID = [
  'It speaks of the motion of a point, x\u2032 = f(x), not of a robot\u2019s tracking error: delays and the control period count as a disturbance.',
  'The size of the tool, joint limits, torques and contact are not in it. Grow the obstacles by the size of what moves.',
  'The obstacles do not move, and nothing is said outside of the workspace nor for starts outside of the safe set.',
  'It says that the motion arrives, not when, nor how closely it follows the demonstrations.',
];

export function element(name, text = '', attributes = {}) {
  const made = document.createElement(name);
  made.textContent = text;
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  return made;
}

export function shortNumber(value, digits = 3) {
  return value === null || !Number.isFinite(value) ? '\u2013' : String(Number(value.toPrecision(digits)));
}

// Fills `into` with the statement of a run; `isVoid`: why it speaks of another scene than the one shown, or ''.
export function showStatement(into, run, isVoid = '') {
  const { certificate } = run;
  const unit = run.frame.unit;
  into.replaceChildren();
  if (isVoid) into.append(element('p', isVoid, { class: 'void' }));
  const body = element('div', '', isVoid ? { class: 'struck' } : {});
  body.append(element('p', certificate.sentence, { class: 'sentence' }));
  if (isVoid) {
    into.append(body);
    return;
  }
  for (const remark of run.remarks) body.append(element('p', remark, { class: run.follows ? 'remark' : 'remark warn' }));
  if (certificate.guarantee === 'invariant' && certificate.disturbance_margin > 0)
    body.append(element('p', `It also holds under any disturbance of the velocity up to ${shortNumber(certificate.disturbance_margin)} ${unit}/s.`));
  const proofs = certificate.conditions.filter(({ method }) => method === 'proof');
  if (proofs.length) {
    const list = element('ul', '', { class: 'conditions' });
    for (const { condition, verdict, boxes } of proofs) {
      const item = element('li', '', { class: verdict });
      item.append(element('span', CONDITIONS[condition] ?? condition), element('span', `${verdict}, ${boxes} boxes`, { class: 'figure' }));
      list.append(item);
    }
    body.append(list);
  }
  const figures = [
    ['rounds', run.rounds],
    ['training', run.seconds === null ? '\u2013' : `${shortNumber(run.seconds)} s`],
    ['proof', run.proof_seconds === null ? '\u2013' : `${shortNumber(run.proof_seconds, 2)} s`],
    ['error of velocity, RMS', `${shortNumber(run.velocity_rms)} ${unit}/s`],
    ['distance from demonstrations (DTW)', `${shortNumber(run.dtw)} ${unit}`],
    ['safe set, of what is truly safe', run.safe_area_ratio === null ? '\u2013' : `${shortNumber(100 * run.safe_area_ratio)} %`],
  ];
  const table = element('dl');
  for (const [name, value] of figures) table.append(element('dt', name), element('dd', String(value)));
  body.append(table);
  if (certificate.statement) {
    const whole = element('details');
    whole.append(element('summary', 'The whole statement'), element('p', certificate.statement),
      element('p', `SHA-256 of the weights: ${certificate.weight_hash}`, { class: 'hash' }));
    body.append(whole);
  }
  into.append(body);
  if (certificate.guarantee === 'invariant') {
    into.append(element('h3', 'What it does not say'));
    const list = element('ul');
    for (const text of NOT_SAID) list.append(element('li', text));
    into.append(list);
  }
}
