# SPDX-License-Identifier: GPL-3.0-or-later
# Fails on functions of one name in unnamed namespaces of two files that may be compiled together: of one
# area (packaging/fast_compile.cmake). One could be called for the other, and no compiler would say so.
# The source is as clang-format leaves it.
FNR == 1 {
  inside = 0
  room = FILENAME
  sub("^tests/", "", room)
  area = match(room, "^(clients/lab/[^/]+/|[^/]+/[^/]+/)") ? substr(room, 1, RLENGTH) : substr(room, 1, index(room, "/"))
  if (room != FILENAME) area = "tests/" area
}
/^namespace \{/ { inside = 1 }
/^\}  \/\/ namespace$/ { inside = 0 }
inside && /std::function</ { gsub("<[^<>]*[(][^<>]*>", "<>") }
inside && /^[A-Za-z][^={[]*\(/ && !/operator|^TEST_CASE|^static_assert|^constexpr [^ ]+ k[A-Z]/ {
  name = substr($0, 1, index($0, "(") - 1)
  sub(".*[ &*>]", "", name)
  if (first[area, name] == "") first[area, name] = FILENAME
  if (first[area, name] == FILENAME) next
  printf "%s:%d: %s() is also in %s; give one of them another name\n", FILENAME, FNR, name, first[area, name]
  found = 1
}
END { exit found }
