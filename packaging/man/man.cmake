# SPDX-License-Identifier: GPL-3.0-or-later
# manual pages; where scdoc is missing there are none, nor of programs that a sanitizer watches
find_program(SCDOC scdoc)
if(SCDOC AND NOT HAPTIC_SANITIZE)
  set(man ${CMAKE_CURRENT_SOURCE_DIR}/man)
  # `hapt --help` asks it for its commands
  set(asked "$<$<BOOL:${HAPTICD_DEVELOPER}>:hapt-lab>")
  foreach(page IN ITEMS hapt.1 hapticd.1 haptic-emulator.1 hapticd.toml.5)
    string(REGEX MATCH ".$" section ${page})
    set(gz ${CMAKE_CURRENT_BINARY_DIR}/${page}.gz)
    add_custom_command(OUTPUT ${gz} VERBATIM
      COMMAND bash -c "set -o pipefail; \"$@\" | gzip -9n >${gz}" page
        ${man}/page.sh ${CMAKE_RUNTIME_OUTPUT_DIRECTORY} ${PROJECT_VERSION} ${man}/${page}.scd
        ${CMAKE_CROSSCOMPILING_EMULATOR}
      DEPENDS hapt ${asked} haptic-view hapticd haptic-emulator ${PROJECT_SOURCE_DIR}/docs/config.md
        ${man}/page.sh ${man}/options.awk ${man}/keys.sed ${man}/${page}.scd)
    list(APPEND pages ${gz})
    install(FILES ${gz} DESTINATION ${CMAKE_INSTALL_MANDIR}/man${section} ${hapticd})
  endforeach()
  add_custom_target(haptic_man ALL DEPENDS ${pages})
endif()
