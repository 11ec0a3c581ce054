# SPDX-License-Identifier: GPL-3.0-or-later
# checks of the source text; each is shown to fail on planted breaches
foreach(check IN ITEMS layering links sizes style unnamed)
  set(script ${CMAKE_CURRENT_SOURCE_DIR}/${check}.cmake)
  add_test(NAME ${check} COMMAND ${CMAKE_COMMAND} -DROOT=${CMAKE_SOURCE_DIR} -P ${script})
  add_test(NAME ${check}_catches_breaches COMMAND ${CMAKE_COMMAND} -DCHECK=${script}
    -DWORK=${CMAKE_CURRENT_BINARY_DIR}/${check}_breaches
    -P ${CMAKE_CURRENT_SOURCE_DIR}/checks_selftest.cmake)
endforeach()

# what the demo needs, as ninja knows it
if(NOT HAPTIC_SANITIZE AND CMAKE_GENERATOR STREQUAL "Ninja")
  set(growth ${CMAKE_COMMAND} -DROOT=${CMAKE_SOURCE_DIR} -DBUILD=${CMAKE_BINARY_DIR}
    -DNINJA=${CMAKE_MAKE_PROGRAM})
  add_test(NAME growth COMMAND ${growth} -P ${CMAKE_CURRENT_SOURCE_DIR}/growth.cmake)
  foreach(program IN ITEMS hapt-lab haptic-emulator)
    add_test(NAME growth_catches_${program}
      COMMAND ${growth} -DPROGRAMS=${program} -P ${CMAKE_CURRENT_SOURCE_DIR}/growth.cmake)
    set_tests_properties(growth_catches_${program} PROPERTIES PASS_REGULAR_EXPRESSION "is linked with")
  endforeach()
endif()

# the joining of changes/ into CHANGELOG.md, in a copy
add_test(NAME release COMMAND ${CMAKE_CURRENT_SOURCE_DIR}/install/release.sh ${CMAKE_SOURCE_DIR}
  ${CMAKE_CURRENT_BINARY_DIR}/release)
