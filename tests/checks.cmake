# SPDX-License-Identifier: GPL-3.0-or-later
# checks of the source text; each is shown to fail on planted breaches
foreach(check IN ITEMS layering links style)
  set(script ${CMAKE_CURRENT_SOURCE_DIR}/${check}.cmake)
  add_test(NAME ${check} COMMAND ${CMAKE_COMMAND} -DROOT=${CMAKE_SOURCE_DIR} -P ${script})
  add_test(NAME ${check}_catches_breaches COMMAND ${CMAKE_COMMAND} -DCHECK=${script}
    -DWORK=${CMAKE_CURRENT_BINARY_DIR}/${check}_breaches
    -P ${CMAKE_CURRENT_SOURCE_DIR}/checks_selftest.cmake)
endforeach()
