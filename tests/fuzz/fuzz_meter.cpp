// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/fuzz/fuzz_meter.h"

#include <sys/time.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>

#if defined(__SANITIZE_ADDRESS__)
#include <sanitizer/common_interface_defs.h>
#endif

namespace haptic::test {
namespace {

// written before each input, so that a signal handler only needs to output it
char current[200];
volatile sig_atomic_t is_running = 0;

void name_current() {
  if (is_running != 0) (void)!write(STDERR_FILENO, current, std::strlen(current));
}

/// CPU time of all threads, independent of other programs [s].
double processor_time() {
  timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

void set_limit(unsigned seconds) {
  const itimerval limit{{}, {static_cast<time_t>(seconds), 0}};
  setitimer(ITIMER_PROF, &limit, nullptr);
}

void end_late(int) {
  static const char kLate[] = "did not end in time: ";
  (void)!write(STDERR_FILENO, kLate, sizeof kLate - 1);
  name_current();
  abort();
}

void watch_for_the_end() {
  signal(SIGPROF, end_late);
#if defined(__SANITIZE_ADDRESS__)
  __sanitizer_set_death_callback(name_current);
#endif
}

}  // namespace

FuzzMeter::FuzzMeter(std::string name, uint64_t seed, unsigned seconds)
    : name_(std::move(name)), seed_(seed), seconds_(seconds), begin_(processor_time()) {
  if (const char* text = std::getenv("HAPTIC_FUZZ_INPUT")) only_ = std::atoll(text);
  watch_for_the_end();
}

FuzzMeter::~FuzzMeter() {
  std::printf(
      "%s, seed %llu: %zu inputs, %zu refused, %zu accepted; %.0f s of the processor, the slowest "
      "%.3f s "
      "(input %llu)\n",
      name_.c_str(), static_cast<unsigned long long>(seed_), refused_ + accepted_, refused_,
      accepted_, processor_time() - begin_, slowest_,
      static_cast<unsigned long long>(slowest_input_));
}

void FuzzMeter::run(size_t inputs, const Run& run) {
  if (only_ >= 0) return run_one(static_cast<uint64_t>(only_), run);
  for (uint64_t number = 0; number < inputs; ++number) run_one(number, run);
}

void FuzzMeter::run_one(uint64_t number, const Run& run) {
  std::snprintf(current, sizeof current, "%s, HAPTIC_FUZZ_INPUT=%llu\n", name_.c_str(),
                static_cast<unsigned long long>(number));
  is_running = 1;
  set_limit(seconds_);
  const double begin = processor_time();
  // the multiplier of SplitMix64 gives unrelated inputs for consecutive numbers
  Random random((seed_ + number) * 0x9e3779b97f4a7c15u);
  ++(run(random) ? accepted_ : refused_);
  set_limit(0);
  is_running = 0;
  if (const double took = processor_time() - begin; took > slowest_) {
    slowest_ = took;
    slowest_input_ = number;
  }
}

}  // namespace haptic::test
