# SPDX-License-Identifier: Apache-2.0
# Writes version.cpp when the commit has changed since; run at every build.
# Run: cmake -DROOT=<repository> -DVERSION=<release> -DOUT=<file> -P proto/os/version.cmake
cmake_minimum_required(VERSION 3.25)

find_package(Git QUIET)
if(GIT_FOUND)
  execute_process(COMMAND ${GIT_EXECUTABLE} -C ${ROOT} describe --always --dirty
    OUTPUT_VARIABLE commit OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
endif()
if(NOT commit)
  set(commit "commit unknown")
endif()
file(CONFIGURE OUTPUT ${OUT} @ONLY CONTENT [[
#include "proto/os/version.h"

namespace haptic {

const char* version() {
  return "@VERSION@ (@commit@)";
}

}  // namespace haptic
]])
