// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <random>
#include <vector>

namespace haptic::test {

/// The random choices for one input, determined by seed and number.
class FuzzRandom {
 public:
  FuzzRandom(uint64_t seed, uint64_t input) : engine_(seed * 0x9E3779B97F4A7C15u + input) {}

  uint64_t bits() { return engine_(); }
  size_t below(size_t n) { return static_cast<size_t>(engine_() % n); }
  template <typename T>
  const T& pick(const std::vector<T>& from) {
    return from[below(from.size())];
  }

 private:
  std::mt19937_64 engine_;
};

/// The inputs of a run: the environment's HAPTIC_FUZZ_SEED and HAPTIC_FUZZ_FIRST, so that a long
/// run can go on where another ended, and an input can be run again alone.
struct FuzzInputs {
  FuzzInputs(uint64_t given_seed, size_t n)
      : seed(from_environment("HAPTIC_FUZZ_SEED", given_seed)),
        first(from_environment("HAPTIC_FUZZ_FIRST", 0)),
        end(first + n) {}

  uint64_t seed, first, end;

 private:
  static uint64_t from_environment(const char* name, uint64_t otherwise) {
    const char* text = std::getenv(name);
    return text != nullptr ? std::strtoull(text, nullptr, 10) : otherwise;
  }
};

}  // namespace haptic::test
