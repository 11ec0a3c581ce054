# SPDX-License-Identifier: GPL-3.0-or-later
# The help text of a command as scdoc: what it is, then each positional and option with its meaning.
function escaped(text) {
  gsub(/[\\_*<>#~]/, "\\\\&", text)
  return text
}
function entry(names, meaning) {
  match(names, /^(-., )?[^ ]+/)
  printf "\n*%s*%s\n", escaped(substr(names, 1, RLENGTH)), escaped(substr(names, RLENGTH + 1))
  # lines of one meaning are joined: one that began with a dash would be a list
  if (meaning != "") printf "\t%s", escaped(meaning)
  is_open = 1
}
function end_entry() {
  if (is_open) print ""
  is_open = 0
}
NR == 1 {
  sub(/^[^:]*: /, "")
  printf "%s.\n", escaped($0)
  next
}
/^[A-Z][a-z]+:/ {
  end_entry()
  part = $1
  next
}
/^ +-h, --help/ || !part || part ~ /^(Usage|Exit)/ {
  next
}
/^                    / {
  sub(/^ +/, "")
  printf "%s%s", is_bare ? "\t" : " ", escaped($0)
  is_bare = 0
  next
}
/^  / {
  end_entry()
  sub(/^ +/, "")
  place = match($0, /  +/)
  is_bare = !place
  if (place) entry(substr($0, 1, place - 1), substr($0, place + RLENGTH))
  else entry($0, "")
}
END { end_entry() }
