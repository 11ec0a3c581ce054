// SPDX-License-Identifier: GPL-3.0-or-later
// Tests for device-io/motors/serial_line.cpp.
#include "device-io/motors/serial_line.h"

#include <catch2/catch.hpp>

#include "proto/math/units.h"
#include "proto/os/realtime.h"
#include "tests/support/pty_line.h"

using namespace haptic;

TEST_CASE("lines: nothing is waited for on a line that has hung up", "[device-io]") {
  test::PtyLine line;
  SerialLine host(FileDescriptor(open(line.name().c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK)));
  line.say("here");
  CHECK(host.wait(now_ns() + kNsPerSecond));
  line.unplug();
  while (host.is_open()) host.hear([](std::span<const uint8_t>) {});
  const int64_t begin_ns = now_ns();
  CHECK_FALSE(host.wait(begin_ns + 2 * kNsPerSecond));
  CHECK(now_ns() - begin_ns < kNsPerSecond);
}
