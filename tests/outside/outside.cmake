# SPDX-License-Identifier: GPL-3.0-or-later
# Adds the renderer "hold" to a copy of the tree as docs/adding.md says, by two new files and one line
# of the table, builds a small session of it and runs that. So it fails when anything else lists
# renderers. ccache knows what does not read the table.
# Run: cmake -DROOT=<repository> -DWORK=<folder> -P tests/outside/outside.cmake
cmake_minimum_required(VERSION 3.25)

function(run)
  execute_process(COMMAND ${ARGN} WORKING_DIRECTORY ${tree} RESULT_VARIABLE status
    OUTPUT_VARIABLE text ERROR_VARIABLE text)
  if(NOT status EQUAL 0)
    message(FATAL_ERROR "outside: '${ARGN}' failed; a renderer is to cost two files and a line:\n${text}")
  endif()
  set(said "${text}" PARENT_SCOPE)
endfunction()

set(tree ${WORK}/tree)
set(here ${ROOT}/tests/outside)
set(rooms proto contact device-io servo sim clients packaging)
# the copies keep their times: what was built before is not built again
foreach(room IN LISTS rooms)
  file(REMOVE_RECURSE ${tree}/${room})
  file(COPY ${ROOT}/${room} DESTINATION ${tree})
endforeach()
file(COPY ${ROOT}/CMakeLists.txt ${ROOT}/CMakePresets.json ${here}/main.cpp DESTINATION ${tree})
file(APPEND ${tree}/CMakeLists.txt "add_executable(outside main.cpp)
target_link_libraries(outside PRIVATE haptic_contact haptic_servo)\n")

# the two files and the line
file(COPY ${here}/hold_detector.cpp DESTINATION ${tree}/contact/detect)
file(COPY ${here}/hold_solver.cpp DESTINATION ${tree}/servo/render)
file(READ ${here}/hold.def line)
file(READ ${tree}/proto/wire/renderers.def table)
string(REPLACE "\n#undef" "${line}\n#undef" table "${table}")
file(WRITE ${tree}/proto/wire/renderers.def "${table}")

run(${CMAKE_COMMAND} --preset dev -DBUILD_TESTING=OFF)
run(${CMAKE_COMMAND} --build build/dev --target outside)
run(build/dev/bin/outside)
message(STATUS "outside: ${said}")
