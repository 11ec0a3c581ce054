#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# The completion offers what the programs understand. Run: completion.sh SOURCE BIN
set -euo pipefail
source "$1/packaging/hapt.bash"
export PATH=$2:$PATH

# expect "LINE" WORD…: what is offered for the last word of a line, in any order
expect() {
  local offered wanted
  read -ra COMP_WORDS <<<"$1"
  [[ $1 != *' ' ]] || COMP_WORDS+=('')
  COMP_CWORD=$((${#COMP_WORDS[@]} - 1))
  shift
  _hapt || true
  offered=$(printf '%s\n' "${COMPREPLY[@]}" | sort)
  wanted=$(printf '%s\n' "$@" | sort)
  [[ $offered == "$wanted" ]] && return
  printf 'for %s\noffered: %s\nwanted:  %s\n' "${COMP_WORDS[*]}" "${offered//$'\n'/ }" "${wanted//$'\n'/ }"
  exit 1
}

expect "hapt d" demo devices diff disarm doctor
expect "hapt demo rigid" rigid-bunnies rigid-peg
expect "hapt demo peg --renderer v" virtual-proxy3 voxel
expect "hapt demo --over" --overwrite
expect "hapt demo --trace " ''
expect "hapt bench r" ring rigid
expect "hapt bench ring --js" --json
expect "hapticd --check" --check-config
# every command of the help text
mapfile -t commands < <(hapt --help | sed -nE '/^Commands:/,/^$/ s/^  ([a-z][a-z0-9-]*)( .*|$)/\1/p')
((${#commands[@]} > 10))
expect "hapt " "${commands[@]}"
