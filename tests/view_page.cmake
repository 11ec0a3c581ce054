# SPDX-License-Identifier: GPL-3.0-or-later
# what the page of hapt view decodes, says and concludes; it in a browser: docs/view-protocol.md
if(NOT NODE)
  find_program(NODE node)
endif()
if(NODE)
  add_test(NAME view_page COMMAND ${NODE} --test decode.test.mjs drawings.test.mjs words.test.mjs
    reducers.test.mjs
    WORKING_DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR}/view)
else()
  add_test(NAME view_page COMMAND ${CMAKE_COMMAND} -E echo "SKIPPED: node is needed to test the page")
endif()
set_tests_properties(view_page PROPERTIES SKIP_REGULAR_EXPRESSION "SKIPPED" TIMEOUT 60)

# the page on the real bridge, in chromium; it says SKIPPED and why where one of its parts is missing
if(NODE)
  add_test(NAME view_bridge COMMAND ${NODE} --test bridge.test.mjs
    WORKING_DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR}/view)
else()
  add_test(NAME view_bridge COMMAND ${CMAKE_COMMAND} -E echo "SKIPPED: node is needed to test the page")
endif()
set_tests_properties(view_bridge PROPERTIES SKIP_REGULAR_EXPRESSION "SKIPPED: " TIMEOUT 600 COST 20
  RESOURCE_LOCK session ENVIRONMENT "SHORT=1;BIN=${CMAKE_BINARY_DIR}/bin;VIEW=${CMAKE_BINARY_DIR}/view")
