# SPDX-License-Identifier: GPL-3.0-or-later
# tests of one room; a test name must not contain ';' (CTest would split it).
# ALONE: what is measured suffers from others. SESSION: it runs sessions, and those with real-time
# priority leave no time for another one on two cores. COST: who takes long begins early
function(haptic_tests room)
  cmake_parse_arguments(ARG "ALONE;SESSION" "NAME;COST" "SOURCES;LIBRARIES" ${ARGN})
  set(target test_${room})
  if(ARG_NAME)
    set(target test_${ARG_NAME})
  endif()
  add_executable(${target} ${ARG_SOURCES})
  target_link_libraries(${target} PRIVATE test_support ${ARG_LIBRARIES})
  set(lock)
  if(ARG_SESSION)
    set(lock RESOURCE_LOCK session)
  endif()
  catch_discover_tests(${target} TEST_PREFIX "${room}: " PROPERTIES
    FAIL_REGULAR_EXPRESSION "No test cases matched" TIMEOUT 600 RUN_SERIAL ${ARG_ALONE}
    COST "0${ARG_COST}" ${lock})
endfunction()
