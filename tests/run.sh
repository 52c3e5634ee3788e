#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Installs what is missing, builds Release and runs the fast tests.
# Usage: bash tests/run.sh [-DOPTION=VALUE]...   (options for CMake)
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

bash third_party/install.sh build test
echo "tests/run.sh: building into build/release"
cmake --preset release "$@"
cmake --build --preset release
echo "tests/run.sh: running the tests that are not labelled slow"
# Waiting threads sleep: spinning ones would take the other test's core.
OMP_WAIT_POLICY=passive ctest --preset release -j2
