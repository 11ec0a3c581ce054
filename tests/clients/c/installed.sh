#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# The example that is installed is compiled by pkg-config and says that no session runs.
# Run: installed.sh BUILD C_COMPILER
set -euo pipefail
build=$1 compiler=$2
work=$(mktemp -d)
trap 'rm -rf -- "$work"' EXIT
for component in libhaptic-client1 libhaptic-client-dev; do
  cmake --install "$build" --component "$component" --prefix "$work/usr" >/dev/null
done
file=$(find "$work" -name hapticd-client-c.pc)
export PKG_CONFIG_PATH=${file%/*} LD_LIBRARY_PATH=${file%/pkgconfig/*} HAPTICD_RUNTIME_DIR=$work
# shellcheck disable=SC2046  # several words
"$compiler" -std=c99 -Wall -Wextra -Wpedantic -Werror -o "$work/01_watch" \
  "$work/usr/share/doc/libhaptic-client-dev/examples/01_watch.c" \
  $(pkg-config --cflags --libs hapticd-client-c) -lm
said=$("$work/01_watch" 2>&1 || true)
printf '%s\n' "$said"
[[ $said == "01_watch: no session is running"* ]]
