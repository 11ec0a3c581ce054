// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/desk/trial/serial_tap.h"

#include <fcntl.h>
#include <poll.h>
#include <pty.h>
#include <termios.h>

#include <array>
#include <cerrno>
#include <stdexcept>

#include "proto/os/priorities.h"
#include "proto/os/realtime.h"

namespace haptic {
namespace {

constexpr int kLookMs = 20;  // whether to end

}  // namespace

SerialTap::SerialTap(FileDescriptor node) : node_(std::move(node)), begin_ns_(now_ns()) {
  int master = -1, slave = -1;
  termios raw{};
  cfmakeraw(&raw);
  // as open_serial_port sets a node up
  raw.c_cc[VMIN] = 1;
  if (openpty(&master, &slave, nullptr, &raw, nullptr) != 0) {
    throw std::runtime_error("no pseudo-terminal to record the bytes with; leave --output away");
  }
  master_ = FileDescriptor(master);
  slave_ = FileDescriptor(slave);
  for (const int fd : {master, slave}) {
    fcntl(fd, F_SETFL, fcntl(fd, F_GETFL) | O_NONBLOCK);
    fcntl(fd, F_SETFD, FD_CLOEXEC);
  }
  pieces_.reserve(kMostPieces);
  thread_ = std::thread([this] { run(); });
}

SerialTap::~SerialTap() {
  finish();
}

const std::vector<DeviceBytes>& SerialTap::finish() {
  ending_ = true;
  if (thread_.joinable()) thread_.join();
  return pieces_;
}

/// Passes on what is there; false: that end is gone.
bool SerialTap::pass(int from, int to, bool by_device) {
  std::array<char, 1024> bytes;
  const ssize_t n = read(from, bytes.data(), bytes.size());
  if (n < 0) return errno == EAGAIN;
  if (n == 0) return false;
  const auto size = static_cast<size_t>(n);
  // a full queue loses them, as a slow line does; the record has them
  const ssize_t sent = write(to, bytes.data(), size);
  if (sent < 0 && errno != EAGAIN) return false;
  cut_ = pieces_.size() == kMostPieces;
  if (!cut_) pieces_.push_back({now_ns() - begin_ns_, by_device, {bytes.data(), size}});
  return true;
}

void SerialTap::run() {
  enter_realtime({.fifo_priority = kLineTapPriority});
  while (!ending_) {
    std::array<pollfd, 2> ends{{{node_.get(), POLLIN, 0}, {master_.get(), POLLIN, 0}}};
    if (poll(ends.data(), ends.size(), kLookMs) <= 0) continue;
    const bool device_there = ends[0].revents == 0 || pass(node_.get(), master_.get(), true);
    const bool driver_there = ends[1].revents == 0 || pass(master_.get(), node_.get(), false);
    if (!device_there || !driver_there) break;
  }
  // so that the driver sees that the device is gone
  master_.reset();
}

}  // namespace haptic
