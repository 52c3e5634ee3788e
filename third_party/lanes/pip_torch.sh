#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# pip's newest torch on the present system, in build/lanes/venv; everything else is the system's. Then a wheel, built and
# tested in an environment of its own.
# S2NNDS_VENV names another virtual environment, which may hold a torch already.
# Usage: bash third_party/lanes/pip_torch.sh [-DOPTION=VALUE]...
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
export S2NNDS_VENV=${S2NNDS_VENV:-$PWD/build/lanes/venv} S2NNDS_TORCH=pip
bash third_party/lanes/lane.sh pip_torch "$@"
bash tests/python/wheel.sh build/lanes/wheel_venv
