// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/fuzz/fuzz_meter.h"

#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#if defined(__SANITIZE_ADDRESS__)
#include <sanitizer/common_interface_defs.h>
#endif

namespace haptic::test {
namespace {

// written before each input, so that a handler of signals needs to write no more than this
char current[200];
volatile sig_atomic_t is_running = 0;

void name_current() {
  if (is_running != 0) (void)!write(STDERR_FILENO, current, std::strlen(current));
}

void end_late(int) {
  static const char kLate[] = "did not end in time: ";
  (void)!write(STDERR_FILENO, kLate, sizeof kLate - 1);
  name_current();
  abort();
}

void watch_for_the_end() {
  signal(SIGALRM, end_late);
#if defined(__SANITIZE_ADDRESS__)
  __sanitizer_set_death_callback(name_current);
#endif
}

double seconds_since(std::chrono::steady_clock::time_point begin) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

}  // namespace

FuzzMeter::FuzzMeter(std::string name, uint64_t seed, unsigned seconds)
    : name_(std::move(name)), seed_(seed), seconds_(seconds) {
  if (const char* text = std::getenv("HAPTIC_FUZZ_INPUT")) only_ = std::atoll(text);
  begin_ = std::chrono::steady_clock::now();
  watch_for_the_end();
}

FuzzMeter::~FuzzMeter() {
  std::printf(
      "%s, seed %llu: %zu inputs, %zu refused, %zu accepted; %.0f s, the slowest %.3f s "
      "(input %llu)\n",
      name_.c_str(), static_cast<unsigned long long>(seed_), refused_ + accepted_, refused_,
      accepted_, seconds_since(begin_), slowest_, static_cast<unsigned long long>(slowest_input_));
}

void FuzzMeter::run(size_t inputs, const Run& run) {
  if (only_ >= 0) return run_one(static_cast<uint64_t>(only_), run);
  for (uint64_t number = 0; number < inputs; ++number) run_one(number, run);
}

void FuzzMeter::run_one(uint64_t number, const Run& run) {
  std::snprintf(current, sizeof current, "%s, HAPTIC_FUZZ_INPUT=%llu\n", name_.c_str(),
                static_cast<unsigned long long>(number));
  is_running = 1;
  alarm(seconds_);
  const auto begin = std::chrono::steady_clock::now();
  // neighbouring numbers give unrelated inputs: the multiplier of SplitMix64
  Random random((seed_ + number) * 0x9e3779b97f4a7c15u);
  ++(run(random) ? accepted_ : refused_);
  alarm(0);
  is_running = 0;
  if (const double took = seconds_since(begin); took > slowest_) {
    slowest_ = took;
    slowest_input_ = number;
  }
}

}  // namespace haptic::test
