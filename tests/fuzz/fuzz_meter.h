// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <functional>
#include <random>
#include <string>

#include "tests/support/torture_scale.h"

namespace haptic::test {

inline constexpr unsigned kMostSeconds = kSlowdown > 1 ? 20 : 2;  // CPU time limit of an input [s]

/// Runs the inputs of a fuzzer one by one and counts the results. An input that exceeds its time or
/// ends the program is named on stderr; with HAPTIC_FUZZ_INPUT=N in the environment only that input
/// is run.
class FuzzMeter {
 public:
  using Random = std::mt19937_64;
  /// Runs an input that depends only on the random numbers; returns whether it was accepted.
  using Run = std::function<bool(Random& random)>;

  /// `seconds`: CPU time limit of an input.
  FuzzMeter(std::string name, uint64_t seed, unsigned seconds);
  ~FuzzMeter();
  FuzzMeter(const FuzzMeter&) = delete;

  void run(size_t inputs, const Run& run);

  size_t refused() const { return refused_; }
  size_t accepted() const { return accepted_; }
  /// Whether all inputs are run, so that the counts are meaningful.
  bool is_whole() const { return only_ < 0; }

 private:
  void run_one(uint64_t number, const Run& run);

  std::string name_;
  uint64_t seed_;
  unsigned seconds_;
  int64_t only_ = -1;  // −1: all of them
  size_t refused_ = 0, accepted_ = 0;
  double slowest_ = 0;  // [s]
  uint64_t slowest_input_ = 0;
  double begin_;  // [s]
};

}  // namespace haptic::test
