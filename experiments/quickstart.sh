#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# From a clean clone to a learned and verified motion: installs what is missing, builds Release, learns a motion
# that is shipped inside, verifies it, exports the policy and draws the figures. Everything lands in build/.
# Usage: bash experiments/quickstart.sh
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

program=build/release/experiments/s2nnds
out=build/quickstart

say() {
  printf '\nquickstart: %s\n' "$*"
}

bash third_party/install.sh build
say "building into build/release (the first time takes some minutes)"
cmake --preset release
cmake --build --preset release --target s2nnds_program

mkdir -p "$out"
say "learning and verifying the motion Sine"
code=0
"$program" train experiments/configs/handwriting/Sine.toml --out "$out/Sine.h5" || code=$?
# 3: trained, but not verified. The figures show where it fails, so they are drawn all the same.
[[ $code -eq 0 || $code -eq 3 ]] || exit "$code"

say "exporting the policy and drawing the figures"
"$program" export "$out/Sine.h5" --format header --out "$out/Sine.h"
"$program" plot "$out/Sine.h5" --out "$out/figures"

say "done"
echo "  run file  $out/Sine.h5"
echo "  policy    $out/Sine.h    (C++ header; $program export --help lists the other formats)"
echo "  figures   $out/figures/"
printf '            %s\n' "$out"/figures/*
"$program" info "$out/Sine.h5"
exit "$code"
