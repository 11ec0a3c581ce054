# SPDX-License-Identifier: GPL-3.0-or-later
# Installed pages lie without the source tree: their links into it become plain text.
set(folder $ENV{DESTDIR}${CMAKE_INSTALL_PREFIX}/share/doc/hapticd-doc)
file(GLOB_RECURSE pages ${folder}/*.md)
set(rooms "proto|contact|servo|sim|device-io|clients|tests|configs|packaging")
foreach(page IN LISTS pages)
  file(READ ${page} text)
  # the words of a link never hold a bracket
  string(REGEX REPLACE "\\[([^][]*)\\]\\((\\.\\./)*(${rooms}|LICENSE)[^)]*\\)" "\\1" text "${text}")
  file(WRITE ${page} "${text}")
endforeach()
