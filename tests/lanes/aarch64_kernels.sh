#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# The kernels of tanh, elu and silu, and of the proof, compute the same, bit for bit, on aarch64 as here: compiled by
# Debian's cross compiler, run by qemu.
# Usage: bash tests/lanes/aarch64_kernels.sh      (exit code 77: no cross compiler, or no qemu)
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
for command in aarch64-linux-gnu-g++ qemu-aarch64-static; do
  if ! command -v "$command" >/dev/null; then
    echo "found no $command (apt-get install g++-aarch64-linux-gnu qemu-user-static)" >&2
    exit 77
  fi
done
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
sources=(tests/lanes/kernel_bytes.cpp s2nnds/networks/dense_kernels_plain.cpp s2nnds/verification/taylor_kernels_plain.cpp)
# As s2nnds/CMakeLists.txt has them.
g++ -std=c++20 -O3 -DNDEBUG -I. "${sources[@]}" -o "$work/here"
aarch64-linux-gnu-g++ -std=c++20 -O3 -DNDEBUG -ffp-contract=off -static -I. "${sources[@]}" -o "$work/there"
"$work/here" | tee "$work/expected"
qemu-aarch64-static "$work/there" | diff "$work/expected" -
echo "aarch64: equal"
