#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Debian 12: GCC 12, LibTorch 1.13. Run on such a machine. Usage: bash third_party/lanes/debian12.sh [-DOPTION=VALUE]...
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
# shellcheck source=/dev/null
. /etc/os-release
if [[ ${ID:-} != debian || ${VERSION_ID:-} != 12 ]]; then
  echo "debian12.sh: found ${PRETTY_NAME:-an unknown system}; expected Debian 12" >&2
  exit 1
fi
exec bash third_party/lanes/lane.sh debian12 "$@"
