// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/hapticd/spare.h"

#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <system_error>
#include <utility>

#include "proto/ipc/process.h"
#include "proto/os/programs.h"
#include "proto/os/realtime.h"
#include "servo/hapticd/restart_policy.h"

namespace haptic {
namespace {

constexpr int64_t kFirstWaitNs = 1 * kNsPerSecond;     // doubled with each death in a row
constexpr int64_t kLongestWaitNs = 64 * kNsPerSecond;  // the cause of repeated deaths may pass

}  // namespace

FileDescriptor Spare::connect(int64_t t_ns) {
  std::array<int, 2> ends{};
  if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends.data()) != 0) {
    throw std::system_error(errno, std::generic_category(), "cannot make a socket pair");
  }
  turn_ = FileDescriptor(ends[0]);
  ready_ = false;
  started_ns_ = t_ns;
  return FileDescriptor(ends[1]);
}

int64_t Spare::put_off(int64_t t_ns) noexcept {
  if (t_ns - started_ns_ >= kHealthyNs) deaths_in_a_row_ = 0;
  const int64_t wait_ns = std::min(kFirstWaitNs << std::min(deaths_in_a_row_++, 6), kLongestWaitNs);
  start_at_ns_ = t_ns + wait_ns;
  return wait_ns;
}

bool Spare::is_ready() noexcept {
  char word = 0;
  if (!ready_ && recv(turn_.get(), &word, 1, MSG_DONTWAIT) == 1) ready_ = word == kSpareReady;
  return ready_ && process.is_running();
}

ChildProcess Spare::promote() {
  send(turn_.get(), &kSpareTurn, 1, MSG_NOSIGNAL | MSG_DONTWAIT);
  return std::exchange(process, {});
}

}  // namespace haptic
