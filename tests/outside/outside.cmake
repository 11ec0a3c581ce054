# SPDX-License-Identifier: GPL-3.0-or-later
# Adds one of each kind to a copy of the tree, as docs/adding.md and docs/how-to-add-a-device.md say: by
# its own files and one line of a table. So it fails when anything else lists renderers, devices, motions,
# joints, commands, suites, benches or faults. A session with the renderer and one with the device are
# built and run; ccache knows what does not read the tables. Of the rest, whose tables nearly everything
# reads, the files that make something of a line are compiled.
# Run: cmake -DROOT=<repository> -DWORK=<folder> -P tests/outside/outside.cmake
cmake_minimum_required(VERSION 3.25)

# file of this folder | place in the tree
set(files
  "hold_detector.h   | contact/detect/hold_detector.h"
  "hold_solver.h     | servo/render/hold_solver.h"
  "nod.cpp           | sim/motion/nod.cpp"
  "rail_path.cpp     | sim/joint/rail_path.cpp"
  "hello.cpp         | clients/hapt/hello.cpp"
  "suite.cpp         | clients/lab/eval/outside_suite.cpp"
  "main.cpp          | main.cpp"
  "slider_session.cpp | slider_session.cpp")
# line | table
set(run_lines
  "RENDERER(kFromOutside, \"hold\", HoldDetector, HoldSolver) | proto/wire/renderers.def"
  "DEVICE(kSlider, \"slider\", open_slider, read_serial, .node = NodeKind::kSerial) \
| proto/config/devices.def")
set(compiled_lines
  "MOTION(kNod, \"nod\", nod) | proto/config/motions.def"
  "JOINT(kRail, \"rail\", rail_path, .slides = true) | proto/config/joints.def"
  "COMMAND(hello) | clients/hapt/commands.def"
  "SUITE(outside, \"Nothing\") | clients/lab/eval/suites.def"
  "BENCH(outside, \"Nothing\") | clients/lab/bench/benches.def"
  "FAULT(kContactAgain, \"contact: killed again\", 0, kFade, kill_contact<SIGKILL>) \
| clients/lab/torture/faults.def")
set(compiled_files
  proto/config/read/config_joint.cpp sim/joint/joint.cpp sim/joint/rail_path.cpp sim/scene.cpp
  sim/motion/nod.cpp clients/hapt/main.cpp clients/hapt/hello.cpp clients/lab/main.cpp
  clients/lab/eval/command.cpp clients/lab/eval/outside_suite.cpp clients/lab/bench/command.cpp
  clients/lab/bench/outside_bench.cpp clients/lab/torture/inflict.cpp)

function(run)
  execute_process(COMMAND ${ARGN} WORKING_DIRECTORY ${tree} RESULT_VARIABLE status
    OUTPUT_VARIABLE text ERROR_VARIABLE text)
  if(NOT status EQUAL 0)
    message(FATAL_ERROR "outside: '${ARGN}' failed; each addition is to cost its files and a line:\n\
${text}")
  endif()
  set(said "${text}" PARENT_SCOPE)
endfunction()

function(add_lines)
  foreach(row IN LISTS ARGN)
    string(REGEX MATCH "^(.+) \\| (.+)$" all "${row}")
    set(line "${CMAKE_MATCH_1}")
    set(table ${tree}/${CMAKE_MATCH_2})
    file(READ ${table} text)
    string(FIND "${text}" "\n#undef" end)
    string(SUBSTRING "${text}" 0 ${end} before)
    string(SUBSTRING "${text}" ${end} -1 after)
    file(WRITE ${table} "${before}\n${line}\n${after}")
  endforeach()
endfunction()

set(tree ${WORK}/tree)
set(here ${ROOT}/tests/outside)
# the copies keep their times: what was built before is not built again
foreach(room IN ITEMS proto contact device-io servo sim clients packaging)
  file(REMOVE_RECURSE ${tree}/${room})
  file(COPY ${ROOT}/${room} DESTINATION ${tree})
endforeach()
file(COPY ${ROOT}/CMakeLists.txt ${ROOT}/CMakePresets.json DESTINATION ${tree})
file(READ ${tree}/CMakeLists.txt text)
string(REPLACE "\nif(NOT HAPTICD_DEVELOPER)" "\nadd_executable(outside main.cpp)
target_link_libraries(outside PRIVATE haptic_contact haptic_servo)
add_executable(outside_device slider_session.cpp)
target_link_libraries(outside_device PRIVATE haptic_contact haptic_servo haptic_device)
if(NOT HAPTICD_DEVELOPER)" text "${text}")
file(WRITE ${tree}/CMakeLists.txt "${text}")

foreach(row IN LISTS files)
  string(REGEX MATCH "^([^ ]+) +\\| (.+)$" all "${row}")
  file(COPY_FILE ${here}/${CMAKE_MATCH_1} ${tree}/${CMAKE_MATCH_2})
endforeach()
file(READ ${here}/suite.cpp text)
string(REPLACE suite_ bench_ text "${text}")
file(WRITE ${tree}/clients/lab/bench/outside_bench.cpp "${text}")
file(COPY ${here}/slider DESTINATION ${tree}/device-io)
add_lines(${run_lines})
run(${CMAKE_COMMAND} --preset dev -DBUILD_TESTING=OFF -DHAPTICD_DEVELOPER=OFF)
# on one core: other tests have the rest
run(${CMAKE_COMMAND} --build build/dev --parallel 1 --target outside outside_device)
foreach(program IN ITEMS outside outside_device)
  run(build/dev/bin/${program})
  message(STATUS "${program}: ${said}")
endforeach()

add_lines(${compiled_lines})
run(c++ -std=c++20 -fsyntax-only -I. -Iclients/library -Ibuild/dev/generated -I/usr/include/eigen3
  ${compiled_files})

# a field of a record: one line, and the next number of the layout
file(READ ${tree}/proto/wire/wire.h text)
string(REGEX MATCH "kAbiMajor = ([0-9]+);" all "${text}")
set(layout ${CMAKE_MATCH_1})
math(EXPR next "${layout} + 1")
string(REPLACE "${all}" "kAbiMajor = ${next};" text "${text}")
file(WRITE ${tree}/proto/wire/wire.h "${text}")
set(records ${tree}/proto/wire/records.def)
file(READ ${records} text)
string(REPLACE "END(ControlFrame)" "FIELD(double, from_outside, \"[m] it came here\", \"log\", \
SINCE(${next}, 7, \"nothing was\"))\nEND(ControlFrame)" text "${text}")
file(WRITE ${records} "${text}")
file(COPY_FILE ${here}/record.cpp ${tree}/record.cpp)
run(c++ -std=c++20 -I. -Ibuild/dev/generated record.cpp proto/wire/schema.cpp proto/log/csv.cpp
  proto/log/layout.cpp proto/log/mcap.cpp proto/log/trace.cpp proto/os/message.cpp
  proto/os/regular_file.cpp -lzstd -lz -o record)
run(./record ${ROOT}/tests/proto/log/golden/layout_${layout}.mcap)
message(STATUS "record: ${said}")
