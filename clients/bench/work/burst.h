// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "clients/lab/forked_process.h"
#include "clients/library/histogram.h"
#include "clients/report/median.h"
#include "proto/os/realtime.h"

/// Short measurements between forked processes, and what is made of them.
namespace haptic {

inline constexpr size_t kMaxSamples = 20'000;
inline constexpr size_t kReaders = 8;
inline constexpr int kFifo = 50;
inline constexpr uint64_t kWriterProcessor = 0, kReaderProcessor = 1;

/// What the processes of a burst share.
struct Burst {
  std::atomic<uint64_t> taken;      // messages the reader has taken
  std::atomic<uint64_t> n_ready;    // processes that have begun
  std::atomic<uint64_t> n_reading;  // readers that have read a first item
  std::atomic<bool> counts;         // from now on
  std::atomic<bool> stop;
  std::atomic<int> refused;  // errno of SCHED_FIFO or of locked memory
  std::atomic<bool> pin_refused;
  std::atomic<int64_t> end_ns, start_ns;
  std::atomic<uint64_t> n_samples;
  std::array<int64_t, kMaxSamples> samples;  // of one process [ns]

  /// Of a process of this burst: on that processor, real time as far as it may.
  void begin(uint64_t processor) {
    const bool is_pinned = pin_to_processor(processor);
    if (!is_pinned) pin_refused = true;
    // locked: a fork maps shared pages anew, and their faults would be measured
    const RealtimeReport report =
        enter_realtime({.fifo_priority = is_pinned ? kFifo : 0, .lock_memory = true});
    if (report.first_errno() != 0) refused = report.first_errno();
    ++n_ready;
  }
  void wait_for(uint64_t processes) const {
    while (n_ready < processes) std::this_thread::sleep_for(std::chrono::microseconds(50));
  }
  void add_sample(int64_t ns) {
    const uint64_t i = n_samples.load(std::memory_order_relaxed);
    if (i < kMaxSamples) samples[i] = ns;
    n_samples.store(i + 1, std::memory_order_relaxed);
  }
};

/// Lets the others on this machine breathe: two spinning FIFO processes leave them nothing.
inline void pause_after(int64_t start_ns) {
  sleep_until(now_ns() + std::max<int64_t>(20'000'000, (now_ns() - start_ns) / 2));
}

/// One of the processes of a burst, and what to call it.
struct Part {
  ForkedProcess* process;
  const char* what;
};

inline void check_end(const Part& part) {
  const int status = part.process->wait();
  if (status == 0) return;
  const std::string said = part.process->said();
  throw std::runtime_error(
      std::string("bench ring: ") + part.what + " was ended by " +
      (WIFSIGNALED(status) ? strsignal(WTERMSIG(status)) : "an exception: " + said) +
      "; try again when less else runs here");
}

/// Which child of this process has ended and was not waited for yet; 0: none, without `patient`.
inline pid_t ended_child(bool patient) {
  siginfo_t info{};
  const int options = WEXITED | WNOWAIT | (patient ? 0 : WNOHANG);
  return waitid(P_ALL, 0, &info, options) == 0 ? info.si_pid : 0;
}

/// Waits for the end of all of them, in any order. Throws at the first that fails: those that wait
/// for it would never end.
inline void check_ends(std::vector<Part> parts) {
  while (!parts.empty()) {
    const pid_t ended = ended_child(true);
    const auto part = std::find_if(parts.begin(), parts.end(),
                                   [&](const Part& p) { return p.process->pid() == ended; });
    if (part == parts.end()) throw std::logic_error("a child that is no part of the burst ended");
    check_end(*part);
    parts.erase(part);
  }
}

/// Waits until so many are at it. Throws where one ends before.
inline void await(const std::atomic<uint64_t>& count, uint64_t wanted) {
  while (count < wanted) {
    if (ended_child(false) != 0) throw std::runtime_error("bench ring: a process ended too early");
    std::this_thread::sleep_for(std::chrono::microseconds(50));
  }
}

/// What was refused anywhere in the run.
struct Rights {
  bool pin_refused = false;
  int refused = 0;
  bool all() const { return !pin_refused && refused == 0; }
  void take(const Burst& burst) {
    pin_refused = pin_refused || burst.pin_refused;
    if (burst.refused != 0) refused = burst.refused;
  }
};

inline double seconds(int64_t ns) {
  return 1e-9 * static_cast<double>(ns);
}

inline double percentile(const Burst& burst, double percent) {
  Histogram histogram;
  // more may have been counted than were kept
  const uint64_t kept = std::min<uint64_t>(burst.n_samples, kMaxSamples);
  for (uint64_t i = 0; i < kept; ++i) histogram.add(burst.samples[i]);
  return seconds(histogram.percentile(percent));
}

}  // namespace haptic
