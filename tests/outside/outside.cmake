# SPDX-License-Identifier: GPL-3.0-or-later
# Adds the renderer "hold" and the device "slider" to a copy of the tree, as docs/adding.md and
# docs/how-to-add-a-device.md say: by new files and one line of a table each. Builds a small session
# with either and runs it. So it fails when anything else lists renderers or devices. ccache knows
# what does not read the tables.
# Run: cmake -DROOT=<repository> -DWORK=<folder> -P tests/outside/outside.cmake
cmake_minimum_required(VERSION 3.25)

function(run)
  execute_process(COMMAND ${ARGN} WORKING_DIRECTORY ${tree} RESULT_VARIABLE status
    OUTPUT_VARIABLE text ERROR_VARIABLE text)
  if(NOT status EQUAL 0)
    message(FATAL_ERROR "outside: '${ARGN}' failed; a renderer is to cost two files and a line, a device a \
folder and a line:\n${text}")
  endif()
  set(said "${text}" PARENT_SCOPE)
endfunction()

# one line more in a table
function(add_line file table)
  file(READ ${here}/${file} line)
  file(READ ${tree}/${table} text)
  string(REPLACE "\n#undef" "${line}\n#undef" text "${text}")
  file(WRITE ${tree}/${table} "${text}")
endfunction()

set(tree ${WORK}/tree)
set(here ${ROOT}/tests/outside)
set(rooms proto contact device-io servo sim clients packaging)
# the copies keep their times: what was built before is not built again
foreach(room IN LISTS rooms)
  file(REMOVE_RECURSE ${tree}/${room})
  file(COPY ${ROOT}/${room} DESTINATION ${tree})
endforeach()
file(COPY ${ROOT}/CMakeLists.txt ${ROOT}/CMakePresets.json ${here}/main.cpp
  ${here}/slider_session.cpp DESTINATION ${tree})
file(APPEND ${tree}/CMakeLists.txt "add_executable(outside main.cpp)
target_link_libraries(outside PRIVATE haptic_contact haptic_servo)
add_executable(outside_device slider_session.cpp)
target_link_libraries(outside_device PRIVATE haptic_contact haptic_servo haptic_device)\n")

# the files and the lines
file(COPY ${here}/hold_detector.h DESTINATION ${tree}/contact/detect)
file(COPY ${here}/hold_solver.h DESTINATION ${tree}/servo/render)
add_line(hold.def proto/wire/renderers.def)
file(COPY ${here}/slider DESTINATION ${tree}/device-io)
add_line(slider.def proto/config/devices.def)

run(${CMAKE_COMMAND} --preset dev -DBUILD_TESTING=OFF)
# on one core: other tests have the rest
run(${CMAKE_COMMAND} --build build/dev --parallel 1 --target outside outside_device)
foreach(program IN ITEMS outside outside_device)
  run(build/dev/bin/${program})
  message(STATUS "${program}: ${said}")
endforeach()
