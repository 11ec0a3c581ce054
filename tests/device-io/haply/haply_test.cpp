// SPDX-License-Identifier: GPL-3.0-or-later
// The driver of a Haply board: its packets and its states. tests/device-io/driver tests what all
// drivers share.
#include "device-io/haply/haply.h"

#include <catch2/catch.hpp>
#include <span>

#include "tests/support/driver/haply_bench.h"
#include "tests/support/driver/rows.h"

using namespace haptic;
using namespace haptic::test;

TEST_CASE("haply: half a question, then the zeros of hapticd: it lets go all the same",
          "[device-io]") {
  constexpr int64_t kPause = 5'000'000;
  // a program is killed in the middle of a question, after any byte, or between two of them
  const size_t cut = GENERATE(range<size_t>(0, 12));
  Wall w(driver_row("haply"));
  const HaplyQuestion question = encode_haply(0x38, 12'000, 12'000);
  w.bench->tell(std::span(question).first(cut));
  w.bench->pass(w.t_ns += kPause);
  w.bench->tell(w.row.release);
  w.bench->pass(w.t_ns += kPause);
  CAPTURE(cut);
  CHECK(w.bench->effort() == 0);
  w.run(300);
  CHECK((w.seen & kDoubt) == 0);
  CHECK(w.is_working());
  const EmulatedHaply& board = w.as<HaplyBench>().emulated();
  CHECK(board.setups() == 1);
  CHECK(board.resets() == 1);
}
