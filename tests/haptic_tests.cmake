# SPDX-License-Identifier: GPL-3.0-or-later
# How tests are compiled, in two ways; the code under test is as ever. Catch2 then says which test an
# exception ended, not which assertion
function(haptic_test_flags name optimisation)
  add_library(${name} INTERFACE)
  target_link_libraries(${name} INTERFACE Catch2::Catch2WithMain haptic_proto)
  target_compile_options(${name} INTERFACE ${optimisation})
  target_compile_definitions(${name} INTERFACE CATCH_CONFIG_FAST_COMPILE)
  if(HAPTIC_SANITIZE STREQUAL "thread")
    # g++ 12 warns of its own std::string, as in packaging/fast_compile.cmake
    target_compile_options(${name} INTERFACE
      -Wno-array-bounds -Wno-stringop-overflow -Wno-stringop-overread -Wno-restrict)
  endif()
  if(HAPTIC_FAST_COMPILE)
    haptic_precompile(${name}_common ${name} ${common_headers} <catch2/catch.hpp> <filesystem> <fstream>
      <random> <sstream> "<proto/config/config.h>" "<proto/wire/wire.h>")
  endif()
endfunction()
haptic_test_flags(test_flags -O0)  # two thirds of the time of -O1
haptic_test_flags(test_flags_optimised -O1)

function(haptic_compile_as_test target flags)
  target_link_libraries(${target} PRIVATE ${flags})
  # once its folder has said which files have options of their own
  cmake_language(EVAL CODE "cmake_language(DEFER CALL haptic_compile_together ${target})")
  if(HAPTIC_FAST_COMPILE)
    target_precompile_headers(${target} REUSE_FROM ${flags}_common)
  endif()
endfunction()

# tests of one room; a test name must not contain ';' (CTest would split it).
# ALONE: what is measured suffers from others. SESSION: it runs sessions, and those with real-time
# priority leave no time for another one on two cores. COST: who takes long begins early
function(haptic_tests room)
  cmake_parse_arguments(ARG "ALONE;SESSION;OPTIMISED" "NAME;COST" "SOURCES;LIBRARIES" ${ARGN})
  set(target test_${room})
  if(ARG_NAME)
    set(target test_${ARG_NAME})
  endif()
  add_executable(${target} ${ARG_SOURCES})
  set(flags test_flags)
  if(ARG_OPTIMISED)
    set(flags test_flags_optimised)
  endif()
  haptic_compile_as_test(${target} ${flags})
  target_link_libraries(${target} PRIVATE test_support ${ARG_LIBRARIES})
  set(lock)
  if(ARG_SESSION)
    set(lock RESOURCE_LOCK session)
  endif()
  catch_discover_tests(${target} TEST_PREFIX "${room}: " PROPERTIES
    FAIL_REGULAR_EXPRESSION "No test cases matched" TIMEOUT 600 RUN_SERIAL ${ARG_ALONE}
    COST "0${ARG_COST}" ${lock})
endfunction()
