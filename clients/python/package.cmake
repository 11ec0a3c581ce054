# SPDX-License-Identifier: Apache-2.0
# Puts the extension and the package together, in the build folder and where they are installed.
set(together ${CMAKE_BINARY_DIR}/python/hapticd)
set_target_properties(haptic_python PROPERTIES OUTPUT_NAME _hapticd
  LIBRARY_OUTPUT_DIRECTORY ${together} CXX_VISIBILITY_PRESET hidden)
file(GLOB files CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/hapticd/*.py
  ${CMAKE_CURRENT_SOURCE_DIR}/hapticd/*.pyi ${CMAKE_CURRENT_SOURCE_DIR}/hapticd/py.typed)
file(MAKE_DIRECTORY ${together})
foreach(file IN LISTS files)
  cmake_path(GET file FILENAME name)
  file(CREATE_LINK ${file} ${together}/${name} SYMBOLIC)
endforeach()

set(installed lib/python3/dist-packages/hapticd)
install(TARGETS haptic_python DESTINATION ${installed} COMPONENT python3-hapticd)
install(FILES ${files} DESTINATION ${installed} COMPONENT python3-hapticd)
install(DIRECTORY examples DESTINATION ${CMAKE_INSTALL_DATADIR}/hapticd
  COMPONENT python3-hapticd FILES_MATCHING PATTERN *.py)
