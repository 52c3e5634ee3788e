#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Ubuntu 24.04: GCC 13 and pip's newest torch, since apt has none. On another system in a chroot.
# Usage: bash third_party/lanes/ubuntu2404.sh [-DOPTION=VALUE]...
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
# shellcheck source=/dev/null
. /etc/os-release
if [[ ${ID:-} == ubuntu && ${VERSION_ID:-} == 24.04 ]]; then
  exec bash third_party/lanes/lane.sh ubuntu2404 "$@"
fi
exec bash third_party/lanes/chroot.sh noble http://archive.ubuntu.com/ubuntu ubuntu2404.sh "$@"
