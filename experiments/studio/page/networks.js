// SPDX-License-Identifier: BSD-3-Clause
// f, V and B in double precision from the weights of a run, as the program computes them but for the order of sums.

// {"shape", "f64" or "f32"}: little-endian numbers in base64.
export function unpack(packed) {
  const bytes = Uint8Array.from(atob(packed.f64 ?? packed.f32), (letter) => letter.charCodeAt(0));
  return packed.f64 === undefined ? new Float32Array(bytes.buffer) : new Float64Array(bytes.buffer);
}

const sigmoid = (z) => 1 / (1 + Math.exp(-z));
// [value, slope] of each activation.
const ACTIVATIONS = {
  identity: (z) => [z, 1],
  tanh: (z) => {
    const a = Math.tanh(z);
    return [a, 1 - a * a];
  },
  elu: (z) => (z > 0 ? [z, 1] : [Math.expm1(z), Math.exp(z)]),
  softplus: (z) => [Math.max(z, 0) + Math.log1p(Math.exp(-Math.abs(z))), sigmoid(z)],
  silu: (z) => [z * sigmoid(z), sigmoid(z) * (1 + z * (1 - sigmoid(z)))],
  sine: (z) => [Math.sin(z), Math.cos(z)],
};

export class Network {
  constructor(json) {
    this.head = json.head;
    this.quadratic = json.quadratic;
    this.layers = json.layers.map((layer) => ({
      outputs: layer.weight.shape[0],
      inputs: layer.weight.shape[1],
      weight: unpack(layer.weight),
      bias: unpack(layer.bias),
      activation: ACTIVATIONS[layer.activation],
      value: new Float64Array(layer.weight.shape[0]),
      slope: new Float64Array(layer.weight.shape[0]),
    }));
    this.origin = Float64Array.from(this.run(new Float64Array(this.layers[0].inputs), null)[0]);
  }

  // N(x) and its derivative along `direction` (null: none), in memory that the next call uses again.
  run(x, direction) {
    let from = x;
    let along = direction;
    for (const { inputs, outputs, weight, bias, activation, value, slope } of this.layers) {
      for (let i = 0, at = 0; i < outputs; ++i) {
        let z = bias.length ? bias[i] : 0;
        let dz = 0;
        for (let j = 0; j < inputs; ++j, ++at) {
          z += weight[at] * from[j];
          if (along) dz += weight[at] * along[j];
        }
        const [a, da] = activation(z);
        value[i] = a;
        slope[i] = da * dz;
      }
      from = value;
      along = along && slope;
    }
    return [from, along];
  }

  // y(x): an array of as many numbers as the network gives.
  value(x) {
    return this.valueAndDerivative(x, null)[0];
  }

  // y(x) and d/ds y(x + s direction) at s = 0.
  valueAndDerivative(x, direction) {
    const [a, da] = this.run(x, direction);
    if (this.head === 'plain') return [Array.from(a), da && Array.from(da)];
    if (this.head === 'zero_at_origin') return [Array.from(a, (v, i) => v - this.origin[i]), da && Array.from(da)];
    let y = 0;
    let dy = 0;
    for (let i = 0; i < a.length; ++i) {
      y += (a[i] - this.origin[i]) ** 2;
      if (da) dy += 2 * (a[i] - this.origin[i]) * da[i];
    }
    for (let i = 0; i < x.length; ++i) {
      y += this.quadratic * x[i] * x[i];
      if (da) dy += 2 * this.quadratic * x[i] * direction[i];
    }
    return [[y], da && [dy]];
  }
}
