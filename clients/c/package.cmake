# SPDX-License-Identifier: Apache-2.0
# Installs the library for programs that run, and its header and link for those that are compiled. The link
# has a name of its own: -lhaptic-client is the static library, for C++.
set(dev COMPONENT libhaptic-client-dev)
install(TARGETS haptic_client_c LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}
  COMPONENT libhaptic-client1 NAMELINK_SKIP)
install(FILES client_c.h DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/hapticd ${dev})
set(link ${CMAKE_CURRENT_BINARY_DIR}/installed/libhaptic-client-c.so)
file(MAKE_DIRECTORY ${CMAKE_CURRENT_BINARY_DIR}/installed)
file(CREATE_LINK libhaptic-client.so.1 ${link} SYMBOLIC)
install(FILES ${link} DESTINATION ${CMAKE_INSTALL_LIBDIR} ${dev})

# found from where the file lies, so that the prefix may be moved
file(RELATIVE_PATH to_prefix ${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig ${CMAKE_INSTALL_PREFIX})
configure_file(hapticd-client-c.pc.in hapticd-client-c.pc @ONLY)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/hapticd-client-c.pc
  DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig ${dev})
install(FILES ${PROJECT_SOURCE_DIR}/clients/examples/01_watch.c
  DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/libhaptic-client-dev/examples ${dev})
