#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Runs the program against two sessions, one of which is killed and started again when it says so.
# Run: live.sh PROGRAM EXAMPLE SOURCE BIN
set -euo pipefail
program=$1 example=$2 source=$3 bin=$4
work=$(mktemp -d /tmp/hapticXXXX)  # short: sockets lie in it
export HAPTICD_RUNTIME_DIR=$work
declare -A pid=()
finish() {
  kill "${pid[@]}" 2>/dev/null || true
  wait
  rm -rf -- "$work"
}
trap finish EXIT

start() {
  sed 's/may = \["move ball"\]/may = ["move ball", "draw"]/' "$source/configs/$1.toml" >"$work/$1.toml"
  "$bin/hapticd" "$work/$1.toml" 2>"$work/$1.log" &
  pid[$1]=$!
}
wait_until_up() {
  for ((i = 0; i < 200; ++i)); do
    [[ -S $work/$1.sock ]] && return
    sleep 0.05
  done
  cat "$work/$1.log"
  exit 1
}

start plane
start give
wait_until_up plane
wait_until_up give
coproc live { "$program" plane give; }
live_pid=$!
while read -r word rest; do
  case $word in
    kill)
      kill -9 "${pid[plane]}"
      { wait "${pid[plane]}" || true; } 2>/dev/null
      ;;
    start) start plane ;;
    *) printf '%s %s\n' "$word" "$rest" ;;
  esac
done <&"${live[0]}"
wait "$live_pid"

line=$("$example" plane | head -n 1 || true)
printf '%s\n' "$line"
[[ $line =~ ^tool\ +-?[0-9.]+\ +-?[0-9.]+\ +-?[0-9.]+\ m\ +force\ +[0-9.]+\ N$ ]]
