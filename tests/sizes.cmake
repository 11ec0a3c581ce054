# SPDX-License-Identifier: GPL-3.0-or-later
# Runs tests/sizes.awk on all sources and CMake lists.
# Run: cmake -DROOT=<repository> -P tests/sizes.cmake
cmake_minimum_required(VERSION 3.25)

foreach(room IN ITEMS proto contact device-io servo sim clients tests)
  list(APPEND patterns ${ROOT}/${room}/*.h ${ROOT}/${room}/*.cpp ${ROOT}/${room}/*CMakeLists.txt)
endforeach()
file(GLOB_RECURSE sources RELATIVE ${ROOT} ${patterns})
list(LENGTH sources count)
execute_process(COMMAND awk -f ${CMAKE_CURRENT_LIST_DIR}/sizes.awk tests/sizes.csv CMakeLists.txt ${sources}
  WORKING_DIRECTORY ${ROOT} RESULT_VARIABLE status OUTPUT_VARIABLE said ERROR_VARIABLE said)
if(NOT status EQUAL 0)
  message(SEND_ERROR "${said}")
endif()
message(STATUS "sizes: ${count} looked at")
