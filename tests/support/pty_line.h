// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <fcntl.h>
#include <poll.h>
#include <pty.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <stdexcept>
#include <string>
#include <string_view>

#include "proto/os/file_descriptor.h"

namespace haptic::test {

/// The device's end of a serial line, controlled by a test.
class PtyLine {
 public:
  PtyLine() {
    int master = -1, slave = -1;
    termios raw{};
    cfmakeraw(&raw);
    std::array<char, 64> name{};
    if (openpty(&master, &slave, name.data(), &raw, nullptr) != 0) {
      throw std::runtime_error("no pseudo-terminal");
    }
    master_ = FileDescriptor(master);
    slave_ = FileDescriptor(slave);
    name_ = name.data();
    fcntl(master, F_SETFL, fcntl(master, F_GETFL) | O_NONBLOCK);
  }

  const std::string& name() const { return name_; }

  /// For use in a thread other than the reader's.
  void pass(std::string_view text) const {
    if (write(master_.get(), text.data(), text.size()) != static_cast<ssize_t>(text.size())) {
      throw std::runtime_error("the line is full");
    }
  }

  /// Returns once there is something to read at the other end; the kernel transfers it
  /// asynchronously.
  void say(std::string_view text) const {
    pass(text);
    pollfd arriving{slave_.get(), POLLIN, 0};
    poll(&arriving, 1, 50);
  }

  /// Output of the host since the last call; waits a second for the first byte.
  std::string hear(int wait_ms = 1000) const {
    std::string text;
    std::array<char, 4096> bytes;
    pollfd waiting{master_.get(), POLLIN, 0};
    if (poll(&waiting, 1, wait_ms) <= 0) return text;
    for (ssize_t n; (n = read(master_.get(), bytes.data(), bytes.size())) > 0;) {
      text.append(bytes.data(), static_cast<size_t>(n));
    }
    return text;
  }

  /// Unplugs the device.
  void unplug() {
    slave_.reset();
    master_.reset();
  }

 private:
  FileDescriptor master_, slave_;
  std::string name_;
};

}  // namespace haptic::test
