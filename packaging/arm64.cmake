# SPDX-License-Identifier: GPL-3.0-or-later
# Cross-builds for Debian on arm64, from a Debian of another architecture that has the libraries of arm64
# beside its own (packaging/cross). What runs while it builds is run by an emulator.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(triplet aarch64-linux-gnu)
set(CMAKE_C_COMPILER ${triplet}-gcc)
set(CMAKE_CXX_COMPILER ${triplet}-g++)
set(CMAKE_CROSSCOMPILING_EMULATOR qemu-aarch64)
set(PKG_CONFIG_EXECUTABLE ${triplet}-pkg-config CACHE FILEPATH "")
# GNUInstallDirs says so itself only where it does not cross-build
set(CMAKE_INSTALL_LIBDIR lib/${triplet} CACHE PATH "")
# the native Python then tells pybind11 of that of arm64
set(ENV{_PYTHON_SYSCONFIGDATA_NAME} _sysconfigdata__${triplet})
set(CPACK_DEBIAN_PACKAGE_ARCHITECTURE arm64)
