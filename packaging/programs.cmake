# SPDX-License-Identifier: GPL-3.0-or-later
# The programs lie together and find each other and share/hapticd from where they are; people type the
# links in bin.
set(hapticd COMPONENT hapticd)
set(programs ${CMAKE_INSTALL_LIBEXECDIR}/hapticd)
install(TARGETS hapt haptic-view hapticd haptic-contact haptic-servo haptic-sim haptic-lockstep
  haptic-emulator
  DESTINATION ${programs} ${hapticd})
install(PROGRAMS fetch-meshes DESTINATION ${programs} ${hapticd})
file(RELATIVE_PATH from_bin ${CMAKE_INSTALL_FULL_BINDIR} ${CMAKE_INSTALL_PREFIX}/${programs})
foreach(program IN ITEMS hapt hapticd haptic-emulator)
  file(CREATE_LINK ${from_bin}/${program} ${CMAKE_CURRENT_BINARY_DIR}/${program} SYMBOLIC)
  install(FILES ${CMAKE_CURRENT_BINARY_DIR}/${program} DESTINATION ${CMAKE_INSTALL_BINDIR} ${hapticd})
  install(FILES hapt.bash RENAME ${program}
    DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions ${hapticd})
endforeach()

set(share ${CMAKE_INSTALL_DATADIR})
install(DIRECTORY ${PROJECT_SOURCE_DIR}/configs DESTINATION ${share}/hapticd ${hapticd})
configure_file(hapticd@.service.in hapticd@.service @ONLY)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/hapticd@.service DESTINATION lib/systemd/system ${hapticd})
install(FILES 70-hapticd.rules DESTINATION lib/udev/rules.d ${hapticd})
install(FILES ${PROJECT_SOURCE_DIR}/README.md ${PROJECT_SOURCE_DIR}/CHANGELOG.md
  DESTINATION ${share}/doc/hapticd-doc COMPONENT hapticd-doc)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/docs DESTINATION ${share}/doc/hapticd-doc COMPONENT hapticd-doc)
install(SCRIPT installed-pages.cmake COMPONENT hapticd-doc)
