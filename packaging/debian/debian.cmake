# SPDX-License-Identifier: GPL-3.0-or-later
# Debian packages by `cpack`, one a component; the components bear the packages' names
set(here ${CMAKE_CURRENT_SOURCE_DIR}/debian)
set(CPACK_GENERATOR DEB)
set(CPACK_COMPONENTS_ALL hapticd libhaptic-client1 libhaptic-client-dev hapticd-doc)
set(CPACK_PACKAGE_CONTACT "hapticd maintainers <maintainers@hapticd.invalid>" CACHE STRING "")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
  OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(CPACK_DEBIAN_PACKAGE_SOURCE hapticd)

set(CPACK_DEBIAN_HAPTICD_PACKAGE_SECTION science)
set(CPACK_DEBIAN_HAPTICD_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_HAPTICD_PACKAGE_SUGGESTS hapticd-doc)
set(CPACK_DEBIAN_HAPTICD_PACKAGE_CONTROL_EXTRA
  ${here}/postinst ${here}/prerm ${here}/postrm)
set(CPACK_DEBIAN_HAPTICD_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_HAPTICD_DESCRIPTION "haptics server: renders the touch of virtual objects at 1 kHz
Reads a force-feedback device a thousand times a second and answers with the
force of what its virtual tool touches. Collision detection, simulation and
viewers run in processes of their own, none of which can delay that force.
`hapt demo` plays a scene with a simulated hand; no device is needed.")

# a package that is linked with the library needs no older one
file(WRITE ${CMAKE_CURRENT_BINARY_DIR}/shlibs
  "libhaptic-client 1 libhaptic-client1 (>= ${PROJECT_VERSION})\n")
set(CPACK_DEBIAN_LIBHAPTIC-CLIENT1_PACKAGE_SECTION libs)
set(CPACK_DEBIAN_LIBHAPTIC-CLIENT1_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_LIBHAPTIC-CLIENT1_PACKAGE_CONTROL_EXTRA ${CMAKE_CURRENT_BINARY_DIR}/shlibs)
set(CPACK_DEBIAN_LIBHAPTIC-CLIENT1_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_LIBHAPTIC-CLIENT1_DESCRIPTION "client library of the haptics server hapticd, for C
Watches a running session, changes it, moves its objects and is told what the
hand pushes them with.")

set(CPACK_DEBIAN_LIBHAPTIC-CLIENT-DEV_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_LIBHAPTIC-CLIENT-DEV_PACKAGE_DEPENDS libboost-dev)
set(CPACK_DEBIAN_LIBHAPTIC-CLIENT-DEV_PACKAGE_RECOMMENDS "libhaptic-client1 (= ${PROJECT_VERSION}-1)")
set(CPACK_DEBIAN_LIBHAPTIC-CLIENT-DEV_DESCRIPTION "client library of the haptics server hapticd
Maps the shared-memory rings of a running session read-only: poses, forces,
contacts and events of every tick. For C++, with a CMake package, and for C;
with pkg-config files and examples.")

set(CPACK_DEBIAN_HAPTICD-DOC_PACKAGE_ARCHITECTURE all)
set(CPACK_DEBIAN_HAPTICD-DOC_PACKAGE_SECTION doc)
set(CPACK_DEBIAN_HAPTICD-DOC_DESCRIPTION "documentation of the haptics server hapticd
Architecture, conventions, the reference of session files, decisions and
measurements, as Markdown.")

# where pybind11 is
if(TARGET haptic_python)
  list(APPEND CPACK_COMPONENTS_ALL python3-hapticd)
  math(EXPR next_minor "${PYTHON_VERSION_MINOR} + 1")
  set(CPACK_DEBIAN_PYTHON3-HAPTICD_PACKAGE_SECTION python)
  set(CPACK_DEBIAN_PYTHON3-HAPTICD_PACKAGE_SHLIBDEPS ON)
  set(CPACK_DEBIAN_PYTHON3-HAPTICD_PACKAGE_DEPENDS
    "python3 (>= 3.${PYTHON_VERSION_MINOR}), python3 (<< 3.${next_minor}), python3-numpy")
  set(CPACK_DEBIAN_PYTHON3-HAPTICD_PACKAGE_RECOMMENDS hapticd)
  set(CPACK_DEBIAN_PYTHON3-HAPTICD_PACKAGE_CONTROL_EXTRA ${here}/python/postinst ${here}/python/prerm)
  set(CPACK_DEBIAN_PYTHON3-HAPTICD_PACKAGE_CONTROL_STRICT_PERMISSION ON)
  set(CPACK_DEBIAN_PYTHON3-HAPTICD_DESCRIPTION "Python module of the haptics server hapticd
Watches a running session as NumPy arrays, changes it, moves its objects and is
told what the hand pushes them with, starts sessions and reads recordings.")
endif()

configure_file(${here}/changelog.in changelog @ONLY)
execute_process(COMMAND gzip -9nc ${CMAKE_CURRENT_BINARY_DIR}/changelog
  OUTPUT_FILE ${CMAKE_CURRENT_BINARY_DIR}/changelog.Debian.gz)
foreach(package IN LISTS CPACK_COMPONENTS_ALL)
  string(TOUPPER ${package} name)
  set(CPACK_DEBIAN_${name}_PACKAGE_NAME ${package})
  install(FILES ${here}/copyright ${CMAKE_CURRENT_BINARY_DIR}/changelog.Debian.gz
    DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${package} COMPONENT ${package})
endforeach()
include(CPack)
