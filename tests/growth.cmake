# SPDX-License-Identifier: GPL-3.0-or-later
# Fails when a program of the package has come to need a file of the laboratory or of a device's emulator,
# or when the demo compiles a tenth more files than tests/growth.csv says.
# Run: cmake -DROOT=<repository> -DBUILD=<build folder> -DNINJA=<ninja> -P tests/growth.cmake
cmake_minimum_required(VERSION 3.25)

if(NOT DEFINED PROGRAMS)  # the check is shown to fail on others
  set(PROGRAMS hapt hapticd haptic-servo haptic-contact haptic-sim haptic-lockstep)
endif()
set(not_for_a_session "^(clients/lab|device-io/emulator)/")

# a folder may be called c++
string(REGEX REPLACE "([][+.*()^$?|])" "\\\\\\1" root "${ROOT}")
string(REGEX REPLACE "([][+.*()^$?|])" "\\\\\\1" build "${BUILD}")

# sources that a target of ninja is made of, named from the root
function(sources_of target found)
  execute_process(COMMAND ${NINJA} -C ${BUILD} -t inputs ${target}
    OUTPUT_VARIABLE inputs ERROR_VARIABLE error RESULT_VARIABLE status)
  if(status)
    message(FATAL_ERROR "ninja does not know ${target} in ${BUILD}: ${error}; build it: ./run build")
  endif()
  string(REPLACE "\n" ";" inputs "${inputs}")
  # files that are compiled together are named in one of the build folder
  set(together ${inputs})
  list(FILTER together INCLUDE REGEX "^/.*/together/.*\\.cpp$")
  foreach(file IN LISTS together)
    file(STRINGS ${file} lines REGEX "^#include")
    list(TRANSFORM lines REPLACE "#include \"(.+)\"" "${ROOT}/\\1" OUTPUT_VARIABLE lines)
    list(APPEND inputs ${lines})
  endforeach()
  list(FILTER inputs INCLUDE REGEX "\\.cpp$")
  list(FILTER inputs EXCLUDE REGEX "^${build}/|^[^/]")
  list(TRANSFORM inputs REPLACE "^${root}/" "")
  set(${found} "${inputs}" PARENT_SCOPE)
endfunction()

foreach(program IN LISTS PROGRAMS)
  sources_of(bin/${program} sources)
  if(NOT sources)
    message(SEND_ERROR "${program}: ninja names no source of it")
  endif()
  list(FILTER sources INCLUDE REGEX "${not_for_a_session}")
  foreach(source IN LISTS sources)
    message(SEND_ERROR "${program} is linked with ${source}; a session needs nothing of the laboratory")
  endforeach()
endforeach()

sources_of(demo sources)
list(LENGTH sources files)
file(STRINGS ${ROOT}/tests/growth.csv row REGEX "^files of the demo,")
string(REGEX REPLACE ".*," "" committed "${row}")
math(EXPR most "${committed} * 11 / 10")
if(files LESS 100 OR files GREATER most)
  message(SEND_ERROR "the demo compiles ${files} files, ${committed} stand in tests/growth.csv: leave"
    " out what a simulated hand does not need, or commit the new figure and say why")
endif()
message(STATUS "growth: the demo compiles ${files} files (${committed} committed)")
