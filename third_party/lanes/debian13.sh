#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Debian 13: GCC 14, LibTorch 2.6, HDF5 1.14. On another system in a chroot.
# Usage: bash third_party/lanes/debian13.sh [-DOPTION=VALUE]...
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
# shellcheck source=/dev/null
. /etc/os-release
if [[ ${ID:-} == debian && ${VERSION_ID:-} == 13 ]]; then
  exec bash third_party/lanes/lane.sh debian13 "$@"
fi
exec bash third_party/lanes/chroot.sh trixie http://deb.debian.org/debian debian13.sh "$@"
