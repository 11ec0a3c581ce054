// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/motors/serial_line.h"

#include <poll.h>
#include <unistd.h>

#include <cerrno>
#include <utility>

#include "proto/math/units.h"
#include "proto/os/realtime.h"

namespace haptic {
namespace {

bool is_busy() {
  return errno == EAGAIN || errno == EINTR;
}

}  // namespace

SerialLine::SerialLine(FileDescriptor node) : node_(std::move(node)) {}

size_t SerialLine::read(std::span<uint8_t> bytes) {
  if (!node_.is_open()) return 0;
  const ssize_t n = ::read(node_.get(), bytes.data(), bytes.size());
  // neither data nor EAGAIN: the node has hung up
  if (n == 0 || (n < 0 && !is_busy())) node_.reset();
  return n > 0 ? static_cast<size_t>(n) : 0;
}

size_t SerialLine::say(std::span<const uint8_t> bytes) {
  const ssize_t n = ::write(node_.get(), bytes.data(), bytes.size());
  if (n < 0 && !is_busy()) node_.reset();
  return n > 0 ? static_cast<size_t>(n) : 0;
}

bool SerialLine::wait(int64_t until_ns) const {
  const int64_t left_ns = until_ns - now_ns();
  if (!is_open() || left_ns <= 0) return false;
  pollfd waiting{node_.get(), POLLIN, 0};
  poll(&waiting, 1, static_cast<int>((left_ns + kMs - 1) / kMs));
  return true;
}

}  // namespace haptic
