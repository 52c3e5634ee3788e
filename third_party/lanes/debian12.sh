#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Debian 12: GCC 12, LibTorch 1.13, HDF5 1.10. On another system in a chroot.
# Usage: bash third_party/lanes/debian12.sh [-DOPTION=VALUE]...
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
# shellcheck source=/dev/null
. /etc/os-release
if [[ ${ID:-} == debian && ${VERSION_ID:-} == 12 ]]; then
  exec bash third_party/lanes/lane.sh debian12 "$@"
fi
exec bash third_party/lanes/chroot.sh bookworm http://deb.debian.org/debian debian12.sh "$@"
