// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <string>
#include <thread>
#include <vector>

#include "clients/desk/trial/byte_log.h"
#include "proto/os/file_descriptor.h"

namespace haptic {

/// Stands between a driver and a serial node, and writes down what each says. The driver sees a
/// terminal as ever. A thread passes each piece on within some tens of microseconds; where it ends,
/// the driver finds its terminal hung up and the firmware's own watchdog lets go.
class SerialTap {
 public:
  /// Takes the open node. Throws std::runtime_error if there is no pseudo-terminal.
  explicit SerialTap(FileDescriptor node);
  ~SerialTap();
  SerialTap(const SerialTap&) = delete;

  /// The driver's node, once.
  FileDescriptor driver_end() { return std::move(slave_); }

  /// Ends the passing on; what was said. Call it after the driver has ended.
  const std::vector<DeviceBytes>& finish();
  /// True if the record is full and its end is missing.
  bool is_cut() const { return cut_; }

 private:
  void run();
  bool pass(int from, int to, bool by_device);

  FileDescriptor node_, master_, slave_;
  int64_t begin_ns_;
  std::vector<DeviceBytes> pieces_;
  bool cut_ = false;
  std::atomic<bool> ending_{false};
  std::thread thread_;
};

}  // namespace haptic
