#!/bin/bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Releases a copy and looks at its changelog. Run: release.sh ROOT WORK
set -euo pipefail
root=$1 work=$2
rm -rf "$work"
mkdir -p "$work/changes" "$work/packaging"
cp "$root/packaging/release" "$work/packaging/"
cd "$work"
release() { packaging/release "$@"; }
refused() { if release "$@" 2>said; then echo "not refused: $*" && exit 1; fi; }

printf '# Changelog\n\nNewest first.\n\n## 0.2.0\n\n### Fixed\n\n- Old.\n' >CHANGELOG.md
cp CHANGELOG.md before
refused 0.3.0
refused 0.3
refused
cmp before CHANGELOG.md

echo "How." >changes/README.md
echo "New; with a [link](docs/a.md) and 100 % of it." >changes/added-new.md
echo "Mended." >changes/fixed-b.md
echo "Mended too." >changes/fixed-a.md
refused 0.2.0
release 0.3.0
diff CHANGELOG.md - <<'TEXT'
# Changelog

Newest first.

## 0.3.0

### Added

- New; with a [link](docs/a.md) and 100 % of it.

### Fixed

- Mended too.
- Mended.

## 0.2.0

### Fixed

- Old.
TEXT
[[ $(ls changes) == README.md ]]
refused 0.3.0
