# SPDX-License-Identifier: GPL-3.0-or-later
# Installs the client library, for find_package(hapticd) and pkg-config. The headers keep their folders
# below include/hapticd; what programs include is <hapticd/client.h>.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)
set(client COMPONENT libhaptic-client-dev)

install(TARGETS haptic_client EXPORT hapticdConfig ${client}
  ARCHIVE ${client}
  FILE_SET short DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} ${client}
  FILE_SET HEADERS DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/hapticd ${client})

set(package ${CMAKE_INSTALL_LIBDIR}/cmake/hapticd)
set(generated ${CMAKE_CURRENT_BINARY_DIR}/packaging)
install(EXPORT hapticdConfig NAMESPACE hapticd:: DESTINATION ${package} ${client})
write_basic_package_version_file(${generated}/hapticdConfigVersion.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES ${generated}/hapticdConfigVersion.cmake DESTINATION ${package} ${client})

# found from where the file lies, so that the prefix may be moved
file(RELATIVE_PATH to_prefix ${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig ${CMAKE_INSTALL_PREFIX})
configure_file(packaging/hapticd-client.pc.in ${generated}/hapticd-client.pc @ONLY)
install(FILES ${generated}/hapticd-client.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig ${client})

install(FILES clients/examples/01_watch.cpp clients/examples/02_draw.cpp
  clients/examples/03_own_device.cpp clients/examples/04_give.cpp clients/examples/own_device_line.h
  clients/examples/stand_in_sdk.cpp clients/examples/stand_in_sdk.h
  packaging/example/CMakeLists.txt
  DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/libhaptic-client-dev/examples ${client})
install(DIRECTORY clients/examples/devices
  DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/libhaptic-client-dev/examples ${client}
  FILES_MATCHING PATTERN *.h PATTERN *.cpp)
