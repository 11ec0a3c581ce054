#!/bin/bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Makes a manual page of a template; what the programs say of themselves is asked of them, so that it
# cannot be out of date. Run: page.sh PROGRAMS VERSION TEMPLATE [EMULATOR…] > page
# A line "@options WORDS" stands for the options of a command, "@commands WORDS" for those of its
# commands, and of theirs, with their options, "@keys FILE" for a reference in Markdown.
set -euo pipefail
programs=$1 version=$2 template=$3
shift 3
emulator=("$@")
here=$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")" && pwd -P)

# `hapt view` is asked of haptic-view: an emulator does not run what `hapt` becomes
help_of() {
  local program=$1
  shift
  if [[ -x $programs/haptic-${1:-} ]]; then program=haptic-$1; fi
  "${emulator[@]}" "$programs/$program" "$@" --help
}

# commands_of WORD…: the names of its sub-commands
commands_of() {
  help_of "$@" | sed -nE '/^Commands:/,/^$/ s/^  ([a-z][a-z0-9-]*)( .*|$)/\1/p'
}

options() {
  help_of "$@" | awk -f "$here/options.awk"
}

commands() {
  local command
  for command in $(commands_of "$@"); do
    printf '\n## %s %s\n\n' "$*" "$command"
    options "$@" "$command"
    commands "$@" "$command"
  done
}

while IFS= read -r line; do
  case $line in
    '@options '*) read -ra words <<<"${line#@options }" && options "${words[@]}" ;;
    '@commands '*) read -ra words <<<"${line#@commands }" && commands "${words[@]}" ;;
    '@keys '*) sed -E -f "$here/keys.sed" "$here/${line#@keys }" ;;
    *) printf '%s\n' "$line" ;;
  esac
done <"$template" | sed "s/@VERSION@/$version/" | scdoc
