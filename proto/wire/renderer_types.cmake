# SPDX-License-Identifier: Apache-2.0
# haptic_renderer_types(target folder Kind): makes the header <folder>/any_<kind>.h for a target: the variant
# Any<Kind> of all types …Kind that the lines of renderers.def name, and the headers *_<kind>.h of the folder,
# where these are.
set(haptic_renderers ${CMAKE_CURRENT_LIST_DIR}/renderers.def)
function(haptic_renderer_types target folder Kind)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${haptic_renderers})
  string(TOLOWER ${Kind} kind)
  file(STRINGS ${haptic_renderers} lines REGEX "^[^/]")  # no comments
  string(REGEX MATCHALL "[A-Za-z0-9]+${Kind}[,)]" types "${lines}")
  list(TRANSFORM types REPLACE "[,)]" "")
  list(REMOVE_DUPLICATES types)
  list(JOIN types ", " types)
  file(GLOB headers CONFIGURE_DEPENDS RELATIVE ${PROJECT_SOURCE_DIR}
    ${PROJECT_SOURCE_DIR}/${folder}/*_${kind}.h)
  list(TRANSFORM headers REPLACE "(.+)" "#include \"\\1\"\n")
  list(JOIN headers "" headers)
  file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/generated/${folder}/any_${kind}.h @ONLY CONTENT
"#pragma once
#include <variant>

@headers@
namespace haptic {
using Any@Kind@ = std::variant<std::monostate, @types@>;
}
")
  target_include_directories(${target} PUBLIC ${PROJECT_BINARY_DIR}/generated)
endfunction()
