# SPDX-License-Identifier: GPL-3.0-or-later
# Fails on what a reviewer should not have to look for: the licence line, lines that grew too long,
# test names that CTest would split in two, config keys and code that the docs do not show as they
# are.
# Run: cmake -DROOT=<repository> -P tests/style.cmake
cmake_minimum_required(VERSION 3.25)

# what others may link is Apache-2.0, the programs are GPL-3.0-or-later
set(apache_files "^(proto/|clients/(c|examples|library|log|python)/)")

# of what clang-format does not wrap
string(REPEAT "." 111 too_long)
function(check_lines source)
  file(STRINGS ${ROOT}/${source} long REGEX "${too_long}")
  if(long)
    message(SEND_ERROR "${source}: a line of more than 110 characters; wrap it: ${long}")
  endif()
endfunction()

function(check_licence source text)
  set(licence "GPL-3.0-or-later")
  if(source MATCHES "${apache_files}")
    set(licence "Apache-2.0")
  endif()
  set(comment "//")
  if(source MATCHES "\\.cmake$")
    set(comment "#")
  endif()
  string(FIND "${text}" "${comment} SPDX-License-Identifier: ${licence}\n" place)
  if(NOT place EQUAL 0)
    message(SEND_ERROR
      "${source}: the first line must be '${comment} SPDX-License-Identifier: ${licence}'")
  endif()
endfunction()

function(check_test_names source text)
  if(text MATCHES "TEST_CASE\\([ \n]*\"[^\"]*;[^\"]*\"")
    message(SEND_ERROR "${source}: ';' in a test name makes two phantom tests that both pass")
  endif()
endfunction()

# every key the config reader asks for is explained to people
function(check_config_keys source text)
  file(READ ${ROOT}/docs/config.md reference)
  string(REGEX MATCHALL "(read_[a-z]+|sections?)\\(\"[a-z_]+\"|{\"[a-z_]+\"," calls "${text}")
  foreach(call IN LISTS calls)
    string(REGEX REPLACE ".*\"([a-z_]+)\",?" "\\1" key "${call}")
    if(NOT reference MATCHES "[^a-z_]${key}[^a-z_]")
      message(SEND_ERROR "${source}: the key '${key}' is missing from docs/config.md")
    endif()
  endforeach()
endfunction()

# files and folders that a page names are there; of `a/b.*` and `a/b` any file that begins so
function(check_paths page)
  file(READ ${ROOT}/${page} text)
  string(REGEX MATCHALL "`(${named_rooms})/[^` ]+`" names "${text}")
  foreach(name IN LISTS names)
    string(REGEX REPLACE "`|\\.?\\*?`$" "" path "${name}")
    file(GLOB found ${ROOT}/${path}*)
    if(NOT found)
      message(SEND_ERROR "${page}: there is no ${path}; name the place where it is now")
    endif()
  endforeach()
endfunction()

# every name in a table of what a config may choose is explained to people
function(check_table table)
  file(READ ${ROOT}/docs/config.md reference)
  file(STRINGS ${ROOT}/${table} rows REGEX "^[A-Z]+\\(.*\"")
  foreach(row IN LISTS rows)
    string(REGEX REPLACE "^[^\"]*\"([^\"]*)\".*" "\\1" name "${row}")
    if(NOT reference MATCHES "[`\"]${name}[`\"]")
      message(SEND_ERROR "${table}: '${name}' is missing from docs/config.md")
    endif()
  endforeach()
endfunction()

set(patterns)
foreach(room IN ITEMS proto contact servo sim device-io clients tests packaging)
  foreach(name IN ITEMS *.h *.cpp *.cmake CMakeLists.txt)
    list(APPEND patterns ${ROOT}/${room}/${name})
  endforeach()
endforeach()
file(GLOB_RECURSE sources RELATIVE ${ROOT} ${patterns})
list(APPEND sources CMakeLists.txt)

foreach(source IN LISTS sources)
  file(READ ${ROOT}/${source} text)
  if(NOT source MATCHES "\\.(h|cpp)$")
    check_lines(${source})
  endif()
  if(NOT source MATCHES "CMakeLists\\.txt$")
    check_licence(${source} "${text}")
  endif()
  if(source MATCHES "^tests/.*\\.cpp$")
    check_test_names(${source} "${text}")
  elseif(source MATCHES "^proto/config/.*\\.cpp$")
    check_config_keys(${source} "${text}")
  endif()
endforeach()

foreach(script IN ITEMS run .ci/run packaging/cross packaging/fetch-meshes packaging/fresh)
  if(EXISTS ${ROOT}/${script})
    check_lines(${script})
  endif()
endforeach()

set(named_rooms "proto|contact|servo|sim|device-io|clients|tests|configs|packaging")
file(GLOB pages RELATIVE ${ROOT} ${ROOT}/README.md ${ROOT}/docs/*.md ${ROOT}/docs/decisions/*.md)
foreach(page IN LISTS pages)
  check_paths(${page})
endforeach()

file(GLOB tables RELATIVE ${ROOT} ${ROOT}/proto/*/*.def)
list(REMOVE_ITEM tables proto/wire/records.def)  # docs/wire.md is made of it
foreach(table IN LISTS tables)
  check_table(${table})
endforeach()

# the README shows the first example as it is compiled
file(READ ${ROOT}/README.md readme)
file(READ ${ROOT}/clients/examples/01_watch.cpp example)
string(FIND "${example}" "#include" start)
string(SUBSTRING "${example}" ${start} -1 example)
string(FIND "${readme}" "\n```cpp\n${example}```\n" place)
if(place EQUAL -1)
  message(SEND_ERROR "README.md: the client differs from clients/examples/01_watch.cpp; copy it")
endif()

list(LENGTH sources count)
message(STATUS "style: ${count} files looked at")
