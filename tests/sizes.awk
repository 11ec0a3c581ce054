# SPDX-License-Identifier: GPL-3.0-or-later
# Sizes from which on a reader asks for a reason: files, folders, functions, and classes with the methods
# outside of their body. What is larger and has no row in tests/sizes.csv is printed, as is a row whose
# place has become small; either fails.
# The source is as clang-format leaves it. Run: tests/sizes.cmake
BEGIN {
  FS = ","
  most["file"] = 600
  most["folder"] = 30
  most["function"] = 60
  most["class"] = 150  # beyond it a class names its states
}
FILENAME == ARGV[1] {
  if (FNR > 1) reason[$1 " " $2] = $3
  next
}
FNR == 1 {
  measure("file", before, lines)
  before = FILENAME
  folder = FILENAME
  sub("/[^/]*$", "", folder)
  if (FILENAME ~ /\.(h|cpp)$/) ++files[folder]
  begin = 0
}
{ lines = FNR }
FILENAME !~ /\.(h|cpp)$/ { next }
/^(class|struct) [A-Za-z0-9_]+.*\{$/ { begin_part("class", $0) }
/^[A-Za-z].*[) ](const |noexcept |try )*\{$/ && !/^(class|struct|enum|union|namespace|extern) / { begin_part("function", $0) }
/^    [^ ].*\) (const |noexcept )*\{$/ && !begin { begin_part("function", opening) }
/^[A-Za-z][^;]*\($/ || /^[A-Za-z][^;{}]*,$/ { opening = $0 }
/^\};?$/ && begin {
  n = FNR - begin + 1
  if (part == "function" && name != "TEST_CASE") measure("function", before ":" name, n)
  if (part == "class") {
    body[name] = n
    place[name] = before
  } else if (name ~ /::/) {
    owner = name
    sub(/::[^:]*$/, "", owner)
    sub(/.*::/, "", owner)
    outside[owner] += n
  }
  begin = 0
}
function begin_part(kind, text) {
  part = kind
  name = text
  if (kind == "class") {
    sub(/^(class|struct) /, "", name)
    sub(/[^A-Za-z0-9_].*/, "", name)
  } else {
    sub(/\(.*/, "", name)
    sub(/.*[ &*]/, "", name)
  }
  begin = FNR
}
function limit_of(kind, path) {
  if (kind == "file" && path == "CMakeLists.txt") return 100
  if (kind == "file" && path ~ /CMakeLists\.txt$/) return 25
  return most[kind]
}
function measure(kind, path, n) {
  if (n <= limit_of(kind, path)) return
  key = kind " " path
  if (key in reason) {
    used[key] = 1
    return
  }
  printf "%s: %s of %d; %d are advised: split what has two subjects, or say in tests/sizes.csv why it has one\n",
    path, kind, n, limit_of(kind, path)
  found = 1
}
END {
  measure("file", before, lines)
  for (each in body) if (place[each] !~ /^tests/) measure("class", place[each] ":" each, body[each] + outside[each])
  for (each in files) measure("folder", each, files[each])
  for (key in reason) {
    if (used[key]) continue
    printf "tests/sizes.csv: %s is not large any more; delete its row\n", key
    found = 1
  }
  exit found
}
