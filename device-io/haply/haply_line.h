// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "device-io/haply/exchange.h"
#include "device-io/motors/serial_line.h"

namespace haptic {

/// The host's side of the serial line to a Haply board. It neither blocks nor allocates once it is
/// open.
class HaplyLine {
 public:
  /// Takes the open node and waits until the board answers. A board that hapticd has set up before
  /// keeps its counts; any other is set up, and counts from where its links are now. Throws
  /// DeviceError if it does not answer within two seconds.
  HaplyLine(const std::string& path, FileDescriptor node, MotorMailbox& mailbox);

  /// Takes what has come: at most 1 KiB.
  void hear(int64_t now_ns);
  /// Asks, with the servo's newest command, if a question is due.
  void say(int64_t now_ns);
  /// Sends the servo's last command until it is answered, for at most SerialLine::kStopNs.
  void stop();

  /// The board was set up here, not by an earlier session.
  bool is_new() const { return new_; }

 private:
  void greet(const std::string& path);
  bool wait_for_answer(int64_t wait_ns);
  void write_all(std::span<const uint8_t> bytes);

  SerialLine line_;
  HaplyExchange exchange_;
  MotorMailbox& mailbox_;
  HaplyQuestion rest_{};  // of a question that the node's full queue has cut off, at the end
  size_t rest_size_ = 0;
  bool new_ = false;
};

}  // namespace haptic
