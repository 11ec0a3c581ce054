// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <sys/resource.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdint>
#include <cstdio>
#include <ctime>
#include <exception>
#include <filesystem>
#include <string>
#include <vector>

#include "tests/fuzz/fuzz_random.h"
#include "tests/support/torture_scale.h"

namespace haptic::test {

/// Whether a text is a proper message: one line without control characters, not a whole file.
inline bool is_one_line(const std::string& text) {
  constexpr size_t kLongest = 4096;
  return !text.empty() && text.size() < kLongest &&
         std::none_of(text.begin(), text.end(), [](char c) {
           return (static_cast<unsigned char>(c) < 0x20 && c != '\t') || c == 0x7f;
         });
}

inline size_t entries_of(const char* folder) {
  const std::filesystem::directory_iterator begin(folder);
  return static_cast<size_t>(std::distance(begin, std::filesystem::directory_iterator()));
}

/// Runs many inputs through one reader and checks each and all: it ends within a second of CPU
/// time; it refuses in one line or accepts; afterwards the numbers of descriptors and threads are
/// as before and memory has not grown by more than a bound.
class FuzzRun {
 public:
  /// `short_form` inputs, times HAPTIC_TORTURE_SCALE, with a sanitizer or without.
  FuzzRun(std::string name, uint64_t seed, size_t short_form)
      : name_(std::move(name)),
        inputs_(static_cast<size_t>(static_cast<double>(short_form) * torture_scale())),
        range_(seed, inputs_) {}

  /// Calls `use` with the choices of each input. It returns whether the input was accepted and
  /// throws std::exception if it was refused.
  template <typename Use>
  void run(const Use& use) {
    const size_t descriptors = entries_of("/proc/self/fd"), threads = entries_of("/proc/self/task");
    const long memory_kib = peak_kib();
    for (uint64_t input = range_.first; input < range_.end; ++input) {
      FuzzRandom random(range_.seed, input);
      const int64_t start_ns = cpu_ns();
      const std::string refusal = refusal_of(use, random);
      const int64_t took_ns = cpu_ns() - start_ns;
      slowest_ns_ = std::max(slowest_ns_, took_ns);
      if (took_ns < kMostNs && (refusal.empty() || is_one_line(refusal))) continue;
      CAPTURE(name_, range_.seed, input, took_ns);
      CHECK(took_ns < kMostNs);
      CHECK("said: " + refusal == "one line");
    }
    CHECK(entries_of("/proc/self/fd") == descriptors);
    CHECK(entries_of("/proc/self/task") == threads);
    grown_kib_ = peak_kib() - memory_kib;
    CHECK(grown_kib_ < kMostKib);
    tell();
  }

  size_t inputs() const { return inputs_; }
  size_t accepted() const { return accepted_; }

 private:
  // fifty times the slowest input seen, a chunk of 16 MiB; a sanitizer is slower
  static constexpr int64_t kMostNs = (kSlowdown > 1 ? 10 : 1) * int64_t{1'000'000'000};
  // the data may be 16 MiB twice; a sanitizer keeps 256 MiB of freed memory
  static constexpr long kMostKib = (kSlowdown > 1 ? 1024 : 128) * 1024;

  template <typename Use>
  std::string refusal_of(const Use& use, FuzzRandom& random) {
    try {
      use(random);
      ++accepted_;
      return "";
    } catch (const std::exception& error) {
      return std::string(error.what()).empty() ? "nothing\n" : error.what();
    }
  }

  static int64_t cpu_ns() {
    timespec t{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return int64_t{t.tv_sec} * 1'000'000'000 + t.tv_nsec;
  }
  static long peak_kib() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return usage.ru_maxrss;
  }
  void tell() const {
    std::printf(
        "%s: %zu inputs from %llu on, seed %llu, %zu accepted, %zu refused, slowest %.1f ms, "
        "memory +%ld MiB, %.0f s of the processor\n",
        name_.c_str(), inputs_, static_cast<unsigned long long>(range_.first),
        static_cast<unsigned long long>(range_.seed), accepted_, inputs_ - accepted_,
        1e-6 * static_cast<double>(slowest_ns_), grown_kib_ / 1024,
        1e-9 * static_cast<double>(cpu_ns()));
  }

  std::string name_;
  size_t inputs_, accepted_ = 0;
  FuzzInputs range_;
  int64_t slowest_ns_ = 0;
  long grown_kib_ = 0;
};

}  // namespace haptic::test
