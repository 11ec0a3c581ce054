# SPDX-License-Identifier: GPL-3.0-or-later
# Runs tests/unnamed.awk on all sources that are compiled together.
# Run: cmake -DROOT=<repository> -P tests/unnamed.cmake
cmake_minimum_required(VERSION 3.25)

set(rooms proto contact device-io servo sim clients tests)
list(TRANSFORM rooms APPEND "/*.cpp")
list(TRANSFORM rooms PREPEND "${ROOT}/")
file(GLOB_RECURSE sources RELATIVE ${ROOT} ${rooms})
# each measure has rows by the same names; programs of few files
list(FILTER sources EXCLUDE REGEX "^(clients/lab/bench/(peers/)?[^/]+|tests/outside/.*)$")
list(LENGTH sources count)
execute_process(COMMAND awk -f ${CMAKE_CURRENT_LIST_DIR}/unnamed.awk ${sources} WORKING_DIRECTORY ${ROOT}
  RESULT_VARIABLE status OUTPUT_VARIABLE said ERROR_VARIABLE said)
if(NOT status EQUAL 0)
  message(SEND_ERROR "${said}")
endif()
message(STATUS "unnamed: ${count} looked at")
