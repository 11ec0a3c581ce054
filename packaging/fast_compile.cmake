# SPDX-License-Identifier: GPL-3.0-or-later
# What most files include is compiled once: a file of the product then takes 0.2 s less (of 0.8 s, the
# median), one of the tests a third less; and files of one area are compiled together. A file still includes
# what it uses: the preset `shipped` compiles each file and each header by itself.
option(HAPTIC_FAST_COMPILE "compile common headers once, and files of one area together" ON)
# clang-tidy cannot read what g++ has precompiled
if(NOT CMAKE_CXX_COMPILER_ID STREQUAL "GNU" OR CMAKE_CXX_CLANG_TIDY)
  set(HAPTIC_FAST_COMPILE OFF)
endif()

# no header that a pure file may not see (tests/layering.cmake)
set(common_headers <algorithm> <array> <cmath> <cstdint> <cstring> <functional> <limits> <map> <memory>
  <numeric> <optional> <span> <stdexcept> <string> <string_view> <utility> <vector>)

# haptic_precompile(name library header…): headers for targets that are compiled with the library's flags
function(haptic_precompile name library)
  file(CONFIGURE OUTPUT ${CMAKE_CURRENT_BINARY_DIR}/${name}.cpp CONTENT "")
  add_library(${name} OBJECT ${CMAKE_CURRENT_BINARY_DIR}/${name}.cpp)
  target_link_libraries(${name} PRIVATE ${library})
  target_precompile_headers(${name} PRIVATE ${ARGN})
  # g++ knows a header that it has precompiled by its text, comments too; ccache would give it one of other
  # comments, and every header would then be there twice
  if(CMAKE_CXX_COMPILER_LAUNCHER)
    set_target_properties(${name} PROPERTIES
      CXX_COMPILER_LAUNCHER "env;CCACHE_COMMENTS=1;${CMAKE_CXX_COMPILER_LAUNCHER}")
  endif()
endfunction()

# haptic_compile_together(target): its files six at a time, which halves the time again. Those of one area
# (contact/query, tests/servo) are together, in which names in unnamed namespaces are to differ; a file
# that comes to another area changes nothing here. One with options of its own, or with HAPTIC_APART, is by
# itself. CMake's UNITY_BUILD writes absolute paths, by which ccache would not know them in another clone
function(haptic_compile_together target)
  get_target_property(apart ${target} HAPTIC_APART)
  if(apart OR NOT HAPTIC_FAST_COMPILE)
    return()
  endif()
  get_target_property(sources ${target} SOURCES)
  get_target_property(folder ${target} SOURCE_DIR)
  set(compiled)
  set(groups)
  foreach(source IN LISTS sources)
    cmake_path(ABSOLUTE_PATH source BASE_DIRECTORY ${folder} NORMALIZE OUTPUT_VARIABLE path)
    cmake_path(IS_PREFIX CMAKE_BINARY_DIR ${path} alone)  # generated
    foreach(own IN ITEMS COMPILE_OPTIONS COMPILE_DEFINITIONS COMPILE_FLAGS INCLUDE_DIRECTORIES
        SKIP_PRECOMPILE_HEADERS HAPTIC_APART)
      get_source_file_property(value ${path} TARGET_DIRECTORY ${target} ${own})
      if(value)
        set(alone ON)
      endif()
    endforeach()
    if(alone OR NOT path MATCHES "\\.cpp$")
      list(APPEND compiled ${source})
      continue()
    endif()
    cmake_path(RELATIVE_PATH path BASE_DIRECTORY ${PROJECT_SOURCE_DIR})
    string(REGEX MATCH "^(tests/)?(clients/lab/[^/]+/|[^/]+/([^/]+/)?)" area ${path})
    string(MAKE_C_IDENTIFIER ${area} area)
    math(EXPR files_${area} "0${files_${area}} + 1")
    math(EXPR group "(${files_${area}} - 1) / 6")
    list(APPEND groups ${area}${group})
    string(APPEND text_${area}${group} "#include \"${path}\"\n")
  endforeach()
  list(REMOVE_DUPLICATES groups)
  foreach(group IN LISTS groups)
    file(CONFIGURE OUTPUT ${CMAKE_BINARY_DIR}/together/${target}/${group}.cpp CONTENT "${text_${group}}")
    list(APPEND compiled ${CMAKE_BINARY_DIR}/together/${target}/${group}.cpp)
  endforeach()
  set_target_properties(${target} PROPERTIES SOURCES "${compiled}")
endfunction()

# haptic_use_precompiled(target…): they begin with the common headers; a file with an optimisation of its
# own does not (SKIP_PRECOMPILE_HEADERS): g++ 12 crashes over headers precompiled with another
function(haptic_use_precompiled)
  if(NOT HAPTIC_FAST_COMPILE)
    return()
  endif()
  if(NOT TARGET haptic_common)
    haptic_precompile(haptic_common haptic_flags ${common_headers})
  endif()
  # rooms without threads are compiled without it
  if(HAPTIC_SANITIZE STREQUAL "thread" AND NOT TARGET haptic_common_plain)
    haptic_precompile(haptic_common_plain haptic_flags ${common_headers})
    set_target_properties(haptic_common_plain PROPERTIES HAPTIC_WITHOUT_THREADS ON)
  endif()
  foreach(target IN LISTS ARGN)
    # g++ 12 warns of its own std::string once it is precompiled; the address sanitizer looks at bounds
    target_compile_options(${target} PRIVATE -Wno-array-bounds -Wno-stringop-overflow -Wno-restrict)
    haptic_compile_together(${target})
    get_target_property(without_threads ${target} HAPTIC_WITHOUT_THREADS)
    if(without_threads AND TARGET haptic_common_plain)
      target_precompile_headers(${target} REUSE_FROM haptic_common_plain)
    else()
      target_precompile_headers(${target} REUSE_FROM haptic_common)
    endif()
  endforeach()
endfunction()

# each header by itself, which shows what it forgets to include
file(GLOB_RECURSE headers CONFIGURE_DEPENDS RELATIVE ${PROJECT_SOURCE_DIR} proto/*.h contact/*.h servo/*.h
  sim/*.h device-io/*.h clients/*.h tests/*.h)
list(FILTER headers EXCLUDE REGEX "^tests/.*usb/")  # they need libraries of single tests
foreach(header IN LISTS headers)
  file(CONFIGURE OUTPUT headers/${header}.cpp CONTENT "#include \"${header}\"\n")
  list(APPEND alone ${CMAKE_CURRENT_BINARY_DIR}/headers/${header}.cpp)
endforeach()
add_library(haptic_headers OBJECT EXCLUDE_FROM_ALL ${alone})
target_include_directories(haptic_headers PRIVATE ${PROJECT_BINARY_DIR}/generated)
target_link_libraries(haptic_headers PRIVATE haptic_flags Eigen3::Eigen nlohmann_json::nlohmann_json
  PkgConfig::bullet)
