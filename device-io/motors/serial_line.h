// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "proto/os/file_descriptor.h"

namespace haptic {

/// The host's end of a serial line, read and written without waiting. A node that hangs up is
/// closed: its name is free for the device's return only when nobody holds it open.
class SerialLine {
 public:
  explicit SerialLine(FileDescriptor node);

  bool is_open() const { return node_.is_open(); }

  /// Calls take(bytes) with what has come, at most 1 KiB: bounded work.
  template <typename Take>
  void hear(Take take) {
    std::array<uint8_t, kBytesPerRead> bytes;
    for (int i = 0; i < kReads; ++i) {
      const size_t n = read(bytes);
      if (n > 0) take(std::span<const uint8_t>(bytes.data(), n));
      if (n < bytes.size()) return;
    }
  }
  /// Bytes that were taken; a full queue takes none, or a part.
  size_t say(std::span<const uint8_t> bytes);

  /// Waits until something has come; false: not until then [ns], or the node has hung up. Before
  /// and after real time.
  bool wait(int64_t until_ns) const;

  static constexpr int64_t kGreetingNs = 2'000'000'000;  // for a device's first answer
  static constexpr int64_t kRoundNs = 50'000'000;        // of that for one question
  static constexpr int64_t kStopNs = 40'000'000;         // within which zero force is promised
  static constexpr int64_t kStopWaitNs = 5'000'000;      // of that for one question

 private:
  static constexpr int kReads = 4;
  static constexpr size_t kBytesPerRead = 256;

  size_t read(std::span<uint8_t> bytes);

  FileDescriptor node_;
};

}  // namespace haptic
