#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Times the peer (eager PyTorch doing the same work) and ours in turns, and prints the ratios as one JSON object on its
# last line. Builds the benchmarks first.
# Usage: compare.sh [--rounds N] [--steps N] [--threads N...] [--peer SCRIPT] [--out FILE.json] [--baseline]
#        compare.sh --growth      prints how step, score, proof and evaluation grow, instead
#   --threads   numbers of threads to try; default 1 2. A round takes some three minutes on two idle cores, most of it the peer's
#   --peer      default ../shared/anchors/pytorch_step.py beside the repository; run by /usr/bin/python3 (python3-torch)
#   --jax       a Python that has JAX (or S2NNDS_JAX_PYTHON): the second peer, ../shared/anchors/jax_step.py (--jax-peer)
#   --baseline  stores the result as tests/benchmarks/baselines/HOST.json
# S2NNDS_OPENBLAS names a libopenblas.so to measure the rate of matrix products with; BUILD the build folder.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
root=$(cd "$here/../.." && pwd)
build=${BUILD:-$root/build/release}

{
  [[ -f $build/build.ninja ]] || cmake -S "$root" -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Release
  cmake --build "$build" --target benchmarks
} >&2
exec /usr/bin/python3 "$here/compare.py" "$build/tests/benchmarks" "$root" "$@"
