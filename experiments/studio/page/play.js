// SPDX-License-Identifier: BSD-3-Clause
// One motion under the learned law, as a machine would execute it: f is evaluated once a period, of the position `delay`
// earlier, and each evaluation is off by noise; in between the velocity is held. A drag takes the point along: a push.

const FINE = 0.001; // seconds: the step between two evaluations
const TRAIL = 4000; // points that are kept

export class Player {
  constructor(portrait) {
    this.portrait = portrait;
    this.model = { period: 0.01, delay: 0, noise: 0 };
    this.state = 'idle'; // running, pushed, arrived, left, stopped
    portrait.overlay = (context, time) => this.draw(context, time);
    this.onChange = () => {};
    this.certified = () => false; // whether the statement shown is `invariant`, and of this scene
  }

  start(x) {
    this.motion = this.portrait.motion;
    if (!this.motion) return;
    this.x = [...x];
    this.past = [];
    this.trail = [[...x, this.motion.safe(x)]];
    this.clock = 0;
    this.due = 0;
    this.last = null;
    this.leftSafe = !this.motion.safe(x);
    this.touched = false;
    this.set('running');
  }

  stop() {
    this.state = 'idle';
    this.onChange();
  }

  set(state) {
    this.state = state;
    this.onChange();
  }

  // Whether a pointer at x takes hold of the moving point.
  holds(x) {
    if (this.state !== 'running' && this.state !== 'arrived') return false;
    return Math.hypot(x[0] - this.x[0], x[1] - this.x[1]) * this.portrait.scale < 26;
  }

  push(x) {
    this.state = 'pushed';
    this.x = [...x];
    this.trail.push([...x, this.motion.safe(x)]);
  }

  release() {
    this.past = [];
    this.due = this.clock;
    this.leftSafe = !this.motion.safe(this.x);
    this.set('running');
  }

  // Noise of the velocity, normal, by the method of Box and Muller.
  noise() {
    return this.model.noise * this.motion.speed * Math.sqrt(-2 * Math.log(1 - Math.random())) * Math.cos(2 * Math.PI * Math.random());
  }

  advance(seconds) {
    const { period, delay } = this.model;
    for (const until = this.clock + seconds; this.clock < until;) {
      if (this.clock >= this.due) {
        this.past.push([this.clock, [...this.x]]);
        while (this.past.length > 1 && this.past[1][0] <= this.clock - delay) this.past.shift();
        this.command = this.motion.velocity(this.past[0][1]).map((v) => v + this.noise());
        this.due = this.clock + period;
      }
      const dt = Math.min(FINE, Math.max(1e-6, this.due - this.clock), until - this.clock + 1e-9);
      this.x = this.x.map((v, i) => v + dt * this.command[i]);
      this.clock += dt;
    }
    const safe = this.motion.safe(this.x);
    if (!safe) this.leftSafe = true;
    this.trail.push([...this.x, safe]);
    if (this.trail.length > TRAIL) this.trail.shift();
    if (this.motion.arrived(this.x)) this.set('arrived');
    if (!this.motion.inWorkspace(this.x) || this.clock > 120) this.set('left');
  }

  draw(context, time) {
    if (this.state === 'idle' || this.portrait.motion === null) return;
    if (this.portrait.motion !== this.motion) this.motion = this.portrait.motion; // adapted meanwhile
    if (this.state === 'running') {
      const seconds = this.last === null ? 0 : Math.min(0.1, (time - this.last) / 1000);
      this.advance(seconds);
    }
    this.last = time;
    const { ink } = this.portrait;
    for (let k = 1, first = 0; k <= this.trail.length; ++k) {
      if (k < this.trail.length && this.trail[k][2] === this.trail[first][2]) continue;
      const inside = this.trail[first][2];
      this.portrait.line(context, this.trail.slice(first, k + 1), inside ? ink.motion : ink.lost, 3, inside ? [] : [7, 6]);
      first = k;
    }
    this.portrait.disc(context, this.x, 9, this.motion.safe(this.x) ? ink.motion : ink.lost, ink.field);
  }

  words() {
    const certified = this.certified();
    const where = this.leftSafe && certified ? ' It was outside of the safe set, where nothing is guaranteed.' : '';
    const inside = certified ? 'Inside the safe set: under x\u2032 = f(x) it arrives and misses the obstacles.'
      : 'Without a certificate nothing is guaranteed of this motion.';
    return {
      idle: 'Choose a start in the picture; drag the moving point to push it.',
      running: this.leftSafe && certified ? 'Outside of the safe set, now or before: nothing is guaranteed of this motion.' : inside,
      pushed: 'Pushed. Let go, and the motion goes on from there.',
      arrived: `Arrived at the goal.${where}`,
      left: `Left the workspace, or did not arrive in two minutes.${where}`,
    }[this.state];
  }
}
