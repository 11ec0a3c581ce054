// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "clients/desk/trial/byte_log.h"
#include "proto/os/file_descriptor.h"

namespace haptic::test {

/// The device's side of a recorded conversation (`hapt devices try`), for a driver on
/// virtual time. Each piece of the device is sent once the host has said all that it had said
/// before it in the recording; a host that says anything else is a mismatch, and hears no more.
class DeviceReplay {
 public:
  explicit DeviceReplay(std::vector<DeviceBytes> pieces) : pieces_(std::move(pieces)) {
    int ends[2];
    if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0, ends) != 0) {
      throw std::runtime_error("no pair of sockets");
    }
    wire_ = FileDescriptor(ends[0]);
    driver_end_ = FileDescriptor(ends[1]);
    // the answer to the greeting, for which a driver waits in real time
    for (; expect_ < pieces_.size() && !pieces_[expect_].by_device; ++expect_) {
      awaited_ += pieces_[expect_].bytes;
    }
    answer();
  }

  /// The driver's node, once.
  FileDescriptor driver_end() { return std::move(driver_end_); }

  /// Hears the host and answers.
  void pass() {
    std::array<char, 1024> bytes;
    const ssize_t n = read(wire_.get(), bytes.data(), bytes.size());
    if (n > 0) said_.append(bytes.data(), static_cast<size_t>(n));
    while (!is_over() && !mismatched_) {
      const size_t common = std::min(said_.size(), awaited_.size());
      mismatched_ = said_.compare(0, common, awaited_, 0, common) != 0;
      if (mismatched_ || said_.size() < awaited_.size()) return;
      if (!pieces_[expect_].by_device) {
        awaited_ += pieces_[expect_++].bytes;
      } else {
        answer();
      }
    }
  }

  bool is_over() const { return expect_ == pieces_.size(); }
  /// The host has said what it had not said in the recording.
  bool is_mismatched() const { return mismatched_; }

 private:
  void answer() {
    for (; expect_ < pieces_.size() && pieces_[expect_].by_device; ++expect_) {
      const std::string& bytes = pieces_[expect_].bytes;
      if (write(wire_.get(), bytes.data(), bytes.size()) != static_cast<ssize_t>(bytes.size())) {
        throw std::runtime_error("the line is full");
      }
    }
  }

  std::vector<DeviceBytes> pieces_;
  size_t expect_ = 0;           // the next piece
  std::string awaited_, said_;  // by the host, from the beginning
  bool mismatched_ = false;
  FileDescriptor wire_, driver_end_;
};

}  // namespace haptic::test
