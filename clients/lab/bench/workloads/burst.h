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

#include "clients/lab/support/forked_process.h"
#include "clients/lab/support/median.h"
#include "clients/library/histogram.h"
#include "proto/os/realtime.h"

/// Short measurements between forked processes, and their evaluation.
namespace haptic {

inline constexpr size_t kMaxSamples = 20'000;  // of a burst; bounds its memory
inline constexpr size_t kReaders = 8;          // of a slow or stopped audience
inline constexpr int kFifo = 50;               // SCHED_FIFO, below the servo's 80
inline constexpr uint64_t kWriterProcessor = 0, kReaderProcessor = 1;  // each its own core

/// Memory shared by the processes of a burst.
struct Burst {
  std::atomic<uint64_t> taken;      // messages the reader has taken
  std::atomic<uint64_t> n_ready;    // processes that have started
  std::atomic<uint64_t> n_reading;  // readers that have read a first item
  std::atomic<bool> counts;         // samples count from now on
  std::atomic<bool> stop;
  std::atomic<int> refused;  // errno of SCHED_FIFO or of locked memory
  std::atomic<bool> pin_refused;
  std::atomic<int64_t> end_ns, start_ns;
  std::atomic<uint64_t> n_samples;
  std::array<int64_t, kMaxSamples> samples;  // of one process [ns]

  /// Called by each process: pins it to that processor, with real-time rights if granted.
  void begin(uint64_t processor) {
    const bool is_pinned = pin_to_processor(processor);
    if (!is_pinned) pin_refused = true;
    // locked: after a fork shared pages are mapped anew, and the page faults would be measured
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

/// Yields to other programs, for which two spinning FIFO processes leave nothing.
inline void pause_after(int64_t start_ns) {
  sleep_until(now_ns() + std::max<int64_t>(20'000'000, (now_ns() - start_ns) / 2));
}

/// One process of a burst, with its name for messages.
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

/// A child process that has ended and was not waited for; 0 if there is none and not `patient`.
inline pid_t ended_child(bool patient) {
  siginfo_t info{};
  const int options = WEXITED | WNOWAIT | (patient ? 0 : WNOHANG);
  return waitid(P_ALL, 0, &info, options) == 0 ? info.si_pid : 0;
}

/// Waits for the end of all of them, in any order. Throws at the first that fails, because others
/// may be waiting for it for ever.
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

/// Waits until `count` reaches `wanted`. Throws if a process ends before.
inline void await(const std::atomic<uint64_t>& count, uint64_t wanted) {
  while (count < wanted) {
    if (ended_child(false) != 0) throw std::runtime_error("bench ring: a process ended too early");
    std::this_thread::sleep_for(std::chrono::microseconds(50));
  }
}

/// Rights refused at any time during the run.
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
  // more samples may have been counted than stored
  const uint64_t kept = std::min<uint64_t>(burst.n_samples, kMaxSamples);
  for (uint64_t i = 0; i < kept; ++i) histogram.add(burst.samples[i]);
  return seconds(histogram.percentile(percent));
}

}  // namespace haptic
