# SPDX-License-Identifier: GPL-3.0-or-later
# The help text of a command as scdoc: what it is, then each positional and option with its meaning.
function escaped(text) {
  gsub(/[\\_*<>#~]/, "\\\\&", text)
  return text
}
function entry(names, meaning) {
  split(names, word, " ")
  sub(/^[^ ]+ ?/, "", names)
  printf "\n*%s* %s\n", escaped(word[1]), escaped(names)
  if (meaning != "") printf "\t%s\n", escaped(meaning)
}
NR == 1 {
  sub(/^[^:]*: /, "")
  printf "%s.\n", escaped($0)
  next
}
/^[A-Z][a-z]+:/ {
  part = $1
  next
}
/^ +-h,--help/ || !part {
  next
}
/^                    / {
  sub(/^ +/, "")
  printf "\t%s\n", escaped($0)
  next
}
/^  / {
  sub(/^ +/, "")
  place = match($0, /  +/)
  if (place) entry(substr($0, 1, place - 1), substr($0, place + RLENGTH))
  else entry($0, "")
}
