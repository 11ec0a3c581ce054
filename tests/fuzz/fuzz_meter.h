// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <functional>
#include <random>
#include <string>

namespace haptic::test {

/// Runs the inputs of a fuzzer one by one and counts what became of them. An input that does not
/// end in time, or that ends the program, is named on stderr; with HAPTIC_FUZZ_INPUT=N in the
/// environment the program runs that one alone.
class FuzzMeter {
 public:
  using Random = std::mt19937_64;
  /// Runs an input that depends on nothing but the random numbers; whether it was accepted.
  using Run = std::function<bool(Random& random)>;

  /// `seconds` of the processor is what no input may take.
  FuzzMeter(std::string name, uint64_t seed, unsigned seconds);
  ~FuzzMeter();
  FuzzMeter(const FuzzMeter&) = delete;

  void run(size_t inputs, const Run& run);

  size_t refused() const { return refused_; }
  size_t accepted() const { return accepted_; }
  /// Whether this runs all inputs, so that counts can be judged.
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
