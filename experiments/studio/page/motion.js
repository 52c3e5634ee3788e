// SPDX-License-Identifier: BSD-3-Clause
// A run as the page works with it: positions in the data's unit and frame go in, velocities in that unit come out.
import { Network, unpack } from './networks.js';

export class Motion {
  constructor(run) {
    this.run = run;
    this.n = run.dimension;
    this.goal = run.frame.goal;
    this.scale = run.frame.position_scale;
    this.speed = run.frame.velocity_scale;
    this.lower = run.workspace.lower;
    this.upper = run.workspace.upper;
    this.f = new Network(run.networks.f);
    this.V = new Network(run.networks.V);
    this.B = new Network(run.networks.B);
    this.demonstrations = run.demonstrations.map(({ position, trains, seconds }) => {
      const flat = unpack(position);
      const points = [];
      for (let i = 0; i < position.shape[0]; ++i) points.push(Array.from(flat.slice(i * this.n, (i + 1) * this.n)));
      return { points, trains, seconds };
    });
  }

  normal(x) {
    return x.map((value, i) => (value - this.goal[i]) / this.scale);
  }

  velocity(x) {
    return this.f.value(this.normal(x)).map((value) => value * this.speed);
  }

  barrier(x) {
    return this.B.value(this.normal(x))[0];
  }

  lyapunov(x) {
    return this.V.value(this.normal(x))[0];
  }

  inWorkspace(x) {
    return x.every((value, i) => value >= this.lower[i] && value <= this.upper[i]);
  }

  // As the exported policies have it: never true where the exact B is positive.
  safe(x) {
    return this.inWorkspace(x) && this.barrier(x) <= -this.run.certificate.barrier_error;
  }

  // One step of length dt in seconds, by the classical Runge-Kutta method.
  step(x, dt) {
    const add = (a, b, h) => a.map((value, i) => value + h * b[i]);
    const k1 = this.velocity(x);
    const k2 = this.velocity(add(x, k1, dt / 2));
    const k3 = this.velocity(add(x, k2, dt / 2));
    const k4 = this.velocity(add(x, k3, dt));
    return x.map((value, i) => value + (dt / 6) * (k1[i] + 2 * k2[i] + 2 * k3[i] + k4[i]));
  }

  arrived(x) {
    return Math.hypot(...x.map((value, i) => value - this.goal[i])) < 0.01 * this.scale;
  }

  // The motion from x until it arrives, leaves the workspace or `seconds` are over, as points.
  path(x, seconds = 60) {
    const points = [x];
    const dt = (0.01 * this.scale) / this.speed;
    for (let t = 0; t < seconds && points.length < 6000; t += dt) {
      x = this.step(x, dt);
      points.push(x);
      if (this.arrived(x) || !this.inWorkspace(x) || x.some((value) => !Number.isFinite(value))) break;
    }
    return points;
  }

  // Of the counterexamples that training has found, those that the networks of now still violate, in the data's frame.
  counterexamples() {
    const found = [];
    const band = this.run.certificate.level_band;
    const bad = {
      workspace: (z) => {
        const along = this.f.value(z);
        if (Math.hypot(...z) < 1e-3) return false;
        const [[v], [dv]] = this.V.valueAndDerivative(z, along);
        if (v <= 0 || dv >= 0) return true;
        const [[b], [db]] = this.B.valueAndDerivative(z, along);
        return Math.abs(b) <= band && db >= 0;
      },
      initial: (z) => this.B.value(z)[0] > 0,
      unsafe: (z) => this.B.value(z)[0] <= 0,
    };
    for (const [kind, packed] of Object.entries(this.run.counterexamples)) {
      if (!bad[kind]) continue;
      const flat = unpack(packed);
      for (let i = 0; i < packed.shape[0]; ++i) {
        const z = Array.from(flat.slice(i * this.n, (i + 1) * this.n));
        if (bad[kind](z)) found.push(z.map((value, k) => this.goal[k] + this.scale * value));
      }
    }
    for (const { witness } of this.run.certificate.conditions) if (witness) found.push(witness);
    return found;
  }

  // Values at side^2 points of the plane of axes i and j over the workspace, x of axis i slowest; `at`: the other axes.
  grid(side, value, axes = [0, 1], at = null) {
    const [i, j] = axes;
    const x = at ? [...at] : [...this.goal];
    const values = new Float32Array(side * side);
    for (let a = 0; a < side; ++a) {
      x[i] = this.lower[i] + ((this.upper[i] - this.lower[i]) * a) / (side - 1);
      for (let b = 0; b < side; ++b) {
        x[j] = this.lower[j] + ((this.upper[j] - this.lower[j]) * b) / (side - 1);
        values[a * side + b] = value(x);
      }
    }
    return values;
  }
}
