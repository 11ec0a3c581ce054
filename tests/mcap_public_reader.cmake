# SPDX-License-Identifier: GPL-3.0-or-later
# our recordings as others read them; npm installs the public reader into the build folder
find_program(NODE node)
find_program(NPM npm)
if(NODE AND NPM)
  add_test(NAME mcap_public_reader COMMAND ${NODE} ${CMAKE_CURRENT_SOURCE_DIR}/clients/library/mcap_reader.mjs
    $<TARGET_FILE:test_proto> ${CMAKE_CURRENT_BINARY_DIR}/mcap_reader)
else()
  add_test(NAME mcap_public_reader COMMAND ${CMAKE_COMMAND} -E echo
    "SKIPPED: node and npm are needed to read a recording with the public MCAP reader")
endif()
set_tests_properties(mcap_public_reader PROPERTIES SKIP_REGULAR_EXPRESSION "SKIPPED" TIMEOUT 300)
