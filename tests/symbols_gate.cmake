# SPDX-License-Identifier: GPL-3.0-or-later
# what the servo's step may refer to; sanitizers put calls of their own everywhere
if(NOT HAPTIC_SANITIZE)
  add_library(planted_symbols OBJECT servo/planted_symbols.cpp)
  target_link_libraries(planted_symbols PRIVATE haptic_flags)
  # of the proto room what the step calls: the small solvers and the mapping
  set(of_step "/(math/.*|wire/mapping)[.]cpp[.]o$|/proto_(math|wire)_[0-9]+[.]cpp[.]o$")
  set(proto_objects "$<FILTER:$<TARGET_OBJECTS:haptic_proto>,INCLUDE,${of_step}>")
  set(step_objects "$<TARGET_OBJECTS:haptic_servo>;${proto_objects}")
  add_test(NAME symbols COMMAND ${CMAKE_COMMAND} -DNM=${CMAKE_NM} "-DOBJECTS=${step_objects}"
    -P ${CMAKE_CURRENT_SOURCE_DIR}/symbols.cmake)
  set(planted pthread_mutex_lock printf _Znwm _ZdlPvm __cxa_throw malloc free _ZN6haptic7ring_upEd)
  add_test(NAME symbols_catches_breaches COMMAND ${CMAKE_COMMAND} -DNM=${CMAKE_NM}
    "-DOBJECTS=${step_objects};$<TARGET_OBJECTS:planted_symbols>" "-DEXPECT=${planted}"
    -P ${CMAKE_CURRENT_SOURCE_DIR}/symbols.cmake)
endif()
