// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/haply/haply_line.h"

#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <utility>

#include "proto/ipc/process.h"
#include "proto/math/units.h"
#include "proto/os/realtime.h"

namespace haptic {
namespace {

constexpr int64_t kGreetingNs = 2000 * kMs;
constexpr int64_t kRoundNs = 50 * kMs;  // for an answer of a board that may be busy
// A board that waits for the rest of a packet, which a killed program has cut off, gives up after
// 1 s (the timeout of Arduino's streams).
constexpr int kAskedBefore = 2;   // rounds before it is set up
constexpr int kSetupRounds = 12;  // between two attempts
constexpr int64_t kStopWaitNs = 5 * kMs;
constexpr int kReadsPerTick = 4;  // together at most 1 KiB: bounded work
constexpr size_t kBytesPerRead = 256;

}  // namespace

HaplyLine::HaplyLine(const std::string& path, FileDescriptor node, MotorMailbox& mailbox)
    : node_(std::move(node)), exchange_(mailbox), mailbox_(mailbox) {
  greet(path);
}

/// Asks first, with zero torques: to a board that is not set up, that is a reset.
void HaplyLine::greet(const std::string& path) {
  const int64_t give_up_ns = now_ns() + kGreetingNs;
  write_all(kHaplyPadding);
  for (int round = 0; !mailbox_.is_gone() && now_ns() < give_up_ns; ++round) {
    if (round >= kAskedBefore && (round - kAskedBefore) % kSetupRounds == 0) {
      write_all(kHaplyReset);
      write_all(encode_haply_setup(kHaplyDevice, {}));
      new_ = true;
    }
    write_all(exchange_.ask(now_ns()));
    if (wait_for_answer(kRoundNs)) return;
  }
  throw DeviceError(path + (mailbox_.is_gone() ? ": hung up" : ": no answer within 2 s") +
                    "; check that it is a Haply board with its firmware, plug it out and in again, "
                    "its handle at home");
}

bool HaplyLine::wait_for_answer(int64_t wait_ns) {
  const uint64_t before = exchange_.answered();
  const int64_t until_ns = now_ns() + wait_ns;
  while (!mailbox_.is_gone()) {
    hear(now_ns());
    if (exchange_.answered() != before) return true;
    const int64_t left_ns = until_ns - now_ns();
    if (left_ns <= 0) return false;
    pollfd waiting{node_.get(), POLLIN, 0};
    poll(&waiting, 1, static_cast<int>((left_ns + kMs - 1) / kMs));
  }
  return false;
}

/// Closes the node: its name is free for the device's return only when nobody holds it open.
void HaplyLine::hang_up() {
  mailbox_.set_gone();
  node_.reset();
}

void HaplyLine::hear(int64_t now_ns) {
  std::array<uint8_t, kBytesPerRead> bytes;
  for (int i = 0; i < kReadsPerTick && node_.is_open(); ++i) {
    const ssize_t n = ::read(node_.get(), bytes.data(), bytes.size());
    if (n < 0 && (errno == EAGAIN || errno == EINTR)) return;
    // neither data nor EAGAIN: the node has hung up
    if (n <= 0) return hang_up();
    exchange_.hear({bytes.data(), static_cast<size_t>(n)}, now_ns);
    if (n < static_cast<ssize_t>(bytes.size())) return;
  }
}

/// What does not fit waits for the next time: the board takes the bytes behind half a question for
/// its end.
void HaplyLine::write_all(std::span<const uint8_t> bytes) {
  const ssize_t n = ::write(node_.get(), bytes.data(), bytes.size());
  if (n < 0 && errno != EAGAIN && errno != EINTR) return hang_up();
  if (n <= 0) return;
  rest_size_ = bytes.size() - static_cast<size_t>(n);
  if (rest_size_ > rest_.size()) rest_size_ = 0;
  std::copy(bytes.end() - static_cast<ptrdiff_t>(rest_size_), bytes.end(),
            rest_.end() - static_cast<ptrdiff_t>(rest_size_));
}

void HaplyLine::say(int64_t now_ns) {
  if (!node_.is_open()) return;
  if (rest_size_ > 0) {
    const HaplyQuestion rest = rest_;
    write_all({rest.end() - static_cast<ptrdiff_t>(rest_size_), rest_size_});
    return;
  }
  if (exchange_.may_ask(now_ns)) write_all(exchange_.ask(now_ns));
}

void HaplyLine::stop() {
  const int64_t give_up_ns = now_ns() + kStopNs;
  if (exchange_.awaits()) wait_for_answer(kStopWaitNs);
  while (node_.is_open() && now_ns() < give_up_ns) {
    say(now_ns());
    if (rest_size_ == 0 && wait_for_answer(kStopWaitNs)) return;
  }
}

}  // namespace haptic
