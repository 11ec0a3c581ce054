#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# A program outside of this tree finds the client library and prints where a tool is. The program is
# the example that is installed with the library.
# Run: client.sh find_package|pkg-config|add_subdirectory SOURCE BUILD COMPILER
set -euo pipefail
how=$1 source=$2 build=$3 compiler=$4
work=$build/tests/install/$how  # always the same, so that ccache knows the objects
rm -rf -- "$work" && mkdir -p "$work"
trap 'rm -rf -- "$work"' EXIT
export PATH=/usr/lib/ccache:$PATH
prefix=$work/usr
cmake --install "$build" --component libhaptic-client-dev --prefix "$prefix" >/dev/null
example=$prefix/share/doc/libhaptic-client-dev/examples

build_with_cmake() {
  cmake -G Ninja -S "$example" -B "$work/build" -D CMAKE_CXX_COMPILER="$compiler" \
    -D CMAKE_BUILD_TYPE=Dev -D CMAKE_CXX_FLAGS_DEV=-O0 "$@"
  cmake --build "$work/build"
}

case $how in
  find_package) build_with_cmake -D CMAKE_PREFIX_PATH="$prefix" ;;
  pkg-config)
    file=$(find "$prefix" -name hapticd-client.pc)
    export PKG_CONFIG_PATH=${file%/*}
    mkdir "$work/build"
    # shellcheck disable=SC2046  # several words
    for name in 01_watch 02_draw 04_give; do
      "$compiler" -std=c++20 -o "$work/build/$name" "$example/$name.cpp" \
        $(pkg-config --cflags --libs hapticd-client)
    done
    ;;
  add_subdirectory)
    # nothing but the library: no server and no test is built
    sed -i "s|^find_package.*|add_subdirectory($source hapticd EXCLUDE_FROM_ALL)|" \
      "$example/CMakeLists.txt"
    build_with_cmake
    targets=$(cmake --build "$work/build" --target help)
    ! grep -E 'haptic_(proto|command_line)|hapticd:|test_' <<<"$targets"
    ;;
esac

export HAPTICD_RUNTIME_DIR=$work/run
"$build/bin/hapticd" "$source/configs/plane.toml" --session "$how" 2>"$work/log" &
trap 'kill %1 && wait %1; rm -rf -- "$work"' EXIT
for ((i = 0; i < 200; ++i)); do
  [[ -S $work/run/$how.sock ]] && break
  sleep 0.05
done
pose=$("$work/build/01_watch" | head -n 1 || true)
printf '%s\n' "$pose"
[[ $pose =~ ^tool\ +-?[0-9.]+\ +-?[0-9.]+\ +-?[0-9.]+\ m\ +force\ +[0-9.]+\ N$ ]]

# the second example draws it
"$work/build/02_draw" "$work/now.svg"
grep -q '<path fill="#7fa8d1" d="M' "$work/now.svg"
grep -q '<line id="force"' "$work/now.svg"
