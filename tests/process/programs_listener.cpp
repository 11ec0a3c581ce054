// SPDX-License-Identifier: GPL-3.0-or-later
// Before the first test of an executable that starts programs: they must be there, because
// otherwise nothing is tested.
#define CATCH_CONFIG_EXTERNAL_INTERFACES
#include <catch2/catch.hpp>
#include <cstdio>
#include <cstdlib>

#include "tests/process/hapticd_process.h"

namespace haptic::test {
namespace {

/// Ends the run with one line where a program is missing.
struct ProgramsListener : Catch::TestEventListenerBase {
  using TestEventListenerBase::TestEventListenerBase;

  void testRunStarting(const Catch::TestRunInfo&) override {
    for (const char* name :
         {"hapticd", "haptic-sim", "haptic-contact", "haptic-servo", "haptic-emulator"}) {
      const std::filesystem::path path = program_folder() / name;
      if (std::filesystem::exists(path)) continue;
      std::fprintf(stderr, "%s is missing; `cmake --build build/dev` builds it\n", path.c_str());
      std::exit(EXIT_FAILURE);
    }
  }
};

CATCH_REGISTER_LISTENER(ProgramsListener)

}  // namespace
}  // namespace haptic::test
