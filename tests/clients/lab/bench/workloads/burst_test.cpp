// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/bench/workloads/burst.h"

#include <catch2/catch.hpp>
#include <stdexcept>

namespace haptic {

TEST_CASE("bench burst: where one process fails the others are not waited for, and it says why") {
  Shared<Burst> burst;
  ForkedProcess writer([&] {
    while (burst->taken == 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  });
  ForkedProcess reader([] { throw std::runtime_error("the reader has had enough"); });
  CHECK_THROWS_WITH(
      check_ends({{&writer, "a writer"}, {&reader, "a reader"}}),
      Catch::Contains("a reader was ended by an exception: the reader has had enough"));
}

TEST_CASE("bench burst: all of them may end in any order") {
  Shared<Burst> burst;
  ForkedProcess first([&] {
    while (burst->taken == 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  });
  ForkedProcess second([&] { burst->taken = 1; });
  CHECK_NOTHROW(check_ends({{&first, "the first"}, {&second, "the second"}}));
}

TEST_CASE("bench burst: nobody waits for the beginning of a process that has ended") {
  Shared<Burst> burst;
  ForkedProcess reader([] { throw std::runtime_error("too early"); });
  CHECK_THROWS_WITH(await(burst->n_ready, 1), Catch::Contains("ended too early"));
}

TEST_CASE("bench burst: more samples than there is room for are counted, not looked at") {
  Shared<Burst> burst;
  for (size_t i = 0; i < kMaxSamples + 100'000; ++i) burst->add_sample(200);
  CHECK(percentile(*burst, 99) == Approx(200e-9));
}

TEST_CASE("median: the middle, or the mean of the middle two") {
  CHECK(median({3, 1, 2}) == 2);
  CHECK(median({4, 1, 3, 2}) == 2.5);
  CHECK(median({7}) == 7);
}

}  // namespace haptic
