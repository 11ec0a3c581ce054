// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <cstdio>
#include <memory>
#include <string>
#include <thread>

#include "device-io/emulator/firmware.h"
#include "proto/ipc/ring.h"

namespace haptic {

/// Calls cell(number) for each cell of a record's row, in the order of the columns.
template <typename Record, typename Cell>
void each_cell(Record& r, Cell cell) {
  const auto vector = [&](auto& a) {
    for (int i = 0; i < 3; ++i) cell(i == 0 ? a.x : i == 1 ? a.y : a.z);
  };
  const auto all = [&](auto& numbers) {
    for (auto& number : numbers) cell(number);
  };
  cell(r.t_ns);
  cell(r.event);
  cell(r.motors_on);
  cell(r.commands);
  cell(r.rejected);
  cell(r.watchdog);
  all(r.currents);
  vector(r.force_B);
  vector(r.torque_B);
  vector(r.p_B);
  vector(r.q_B);
  cell(r.q_B.w);
  all(r.counts);
  all(r.answered);
  all(r.said_first);
}

/// Writes the emulator's records as CSV in a thread of its own, so that the loop never waits for a
/// disk. Rows reach the file within some milliseconds, in whole lines; records are lost, and
/// counted, only if the disk is two seconds behind.
class EmulatorLog {
 public:
  /// An empty path: no file. Throws std::runtime_error if it cannot be written.
  explicit EmulatorLog(const std::string& path);
  ~EmulatorLog();
  EmulatorLog(const EmulatorLog&) = delete;

  /// For the loop: one copy.
  void add(const EmulatorRecord& record) noexcept { ring_->publish(record); }

  /// Writes the rest and closes the file. Returns rows written, records lost, and whether writing
  /// succeeded.
  struct Outcome {
    uint64_t rows, lost;
    bool written;
  };
  Outcome finish();

 private:
  using Records = Ring<EmulatorRecord, 8192>;

  void run();
  void drain();

  std::unique_ptr<Records> ring_ = std::make_unique<Records>();
  Cursor cursor_;
  uint64_t rows_ = 0;
  std::FILE* file_ = nullptr;
  bool good_ = true;
  std::atomic<bool> ending_{false};
  std::thread thread_;
};

}  // namespace haptic
