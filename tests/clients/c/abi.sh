#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Compares what <hapticd/client_c.h> declares, compiled as a library of empty functions, with what
# clients/c/libhaptic-client.so.1.abi has kept of it, and the symbols of the library with those that are
# declared. Exit code 77: there is no abidiff, or another processor than that of the file.
# Run: abi.sh SOURCE C_COMPILER NM LIBRARY, or abi.sh SOURCE C_COMPILER --write after a change that is meant
set -euo pipefail
source=$1 compiler=$2
kept=$source/clients/c/libhaptic-client.so.1.abi
if ! command -v abidiff >/dev/null; then
  echo "abidiff is not installed (apt install abigail-tools): nothing is compared"
  exit 77
fi
if [[ $(uname -m) != x86_64 ]]; then
  echo "the file is of x86_64, this is $(uname -m): nothing is compared"
  exit 77
fi
work=$(mktemp -d)
trap 'rm -rf -- "$work"' EXIT
map=$source/clients/c/symbols.map

sed 's/);$/) { __builtin_trap(); }/' "$source/clients/c/client_c.h" >"$work/client_c.c"
(cd "$work" && "$compiler" -std=c99 -g -fPIC -shared -o libhaptic-client.so.1 client_c.c \
  -Wl,-soname,libhaptic-client.so.1 "-Wl,--version-script=$map")
declared=$work/libhaptic-client.so.1
show=(--no-corpus-path --no-comp-dir-path --no-show-locs)
if [[ $3 == --write ]]; then
  abidw "${show[@]}" "$declared" >"$kept"
  exit
fi

if ! abidiff "$kept" "$declared"; then
  echo "The interface has changed. What is added, renew with: ${BASH_SOURCE[0]} $source $compiler --write"
  echo "What is gone or is another breaks programs: mend it, or raise the library's number."
  exit 1
fi

nm=$3 library=$4
symbols_of() { "$nm" -D --defined-only "$1" | awk '$2 != "A" && $2 != "a" { print $3 }' | sort; }
if ! diff <(symbols_of "$declared") <(symbols_of "$library"); then
  echo "The symbols of the library (right) differ from what is declared and in $map (left)."
  exit 1
fi
