// SPDX-License-Identifier: GPL-3.0-or-later
// Tests for proto/math/assert.h.
#include "proto/math/assert.h"

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <csignal>

#include "proto/wire/renderer.h"

#ifdef NDEBUG
TEST_CASE("assert: nothing is evaluated in a build without assertions") {
  [[maybe_unused]] bool evaluated = false;
  HAPTIC_ASSERT((evaluated = true));
  CHECK_FALSE(evaluated);
}
#else
namespace {

/// How a process ends that does this: its status, as wait reports it.
template <typename Do>
int end_of(Do do_it) {
  const pid_t child = fork();
  REQUIRE(child >= 0);
  if (child == 0) {
    // the end is meant: no report of the test framework, no text, no core file
    std::signal(SIGABRT, SIG_DFL);
    const rlimit none{0, 0};
    setrlimit(RLIMIT_CORE, &none);
    close(STDERR_FILENO);
    do_it();
    _exit(0);
  }
  int status = 0;
  REQUIRE(waitpid(child, &status, 0) == child);
  return status;
}

bool is_abort(int status) {
  return WIFSIGNALED(status) && WTERMSIG(status) == SIGABRT;
}

}  // namespace

TEST_CASE("assert: a broken precondition ends the process, one that holds does not") {
  CHECK(is_abort(end_of([] { HAPTIC_ASSERT(sizeof(int) == 0); })));
  CHECK(end_of([] { HAPTIC_ASSERT(sizeof(int) > 0); }) == 0);
  volatile uint32_t number = 99;
  CHECK(is_abort(end_of([&] { row_of(static_cast<haptic::Renderer>(number)); })));
  number = 0;
  CHECK(end_of([&] { row_of(static_cast<haptic::Renderer>(number)); }) == 0);
}
#endif
