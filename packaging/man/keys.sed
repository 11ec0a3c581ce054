# SPDX-License-Identifier: GPL-3.0-or-later
# A reference in Markdown as scdoc: a row of a table becomes a key with its default and meaning.
/^```/,/^```$/b
/^# /d
/^\|[-|]+$/d
/^\| (key|part|file) /d
/^##/ {
  s/`//g
  s/[_*<>]/\\&/g
  s/^#//
  b
}
s/\[([^]]*)\]\([^)]*\)/\1/g
s/\*\*//g
s/[\\_*<>#~]/\\&/g
s/`([^`]*)`/*\1*/g
s/\| \|/|  |/g
s/^\| ([^|]*) \| ([^|]*) \| ([^|]*) \|$/\n\1 (\2)\n\t\3/
s/^\| ([^|]*) \| ([^|]*) \|$/\n\1\n\t\2/
s/ \(\)\n/\n/
s/\n\t$//
