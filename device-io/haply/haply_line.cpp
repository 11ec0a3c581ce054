// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/haply/haply_line.h"

#include <algorithm>
#include <utility>

#include "proto/ipc/process.h"
#include "proto/os/realtime.h"

namespace haptic {
namespace {

// A board that waits for the rest of a packet, which a killed program has cut off, gives up after
// 1 s (the timeout of Arduino's streams).
constexpr int kAskedBefore = 2;   // rounds before it is set up
constexpr int kSetupRounds = 12;  // between two attempts

}  // namespace

HaplyLine::HaplyLine(const std::string& path, FileDescriptor node, MotorMailbox& mailbox)
    : line_(std::move(node)), exchange_(mailbox), mailbox_(mailbox) {
  greet(path);
}

/// Asks first, with zero torques: to a board that is not set up, that is a reset.
void HaplyLine::greet(const std::string& path) {
  const int64_t give_up_ns = now_ns() + SerialLine::kGreetingNs;
  write_all(kHaplyPadding);
  for (int round = 0; !mailbox_.is_gone() && now_ns() < give_up_ns; ++round) {
    if (round >= kAskedBefore && (round - kAskedBefore) % kSetupRounds == 0) {
      write_all(kHaplyReset);
      write_all(encode_haply_setup(kHaplyDevice, {}));
      new_ = true;
    }
    write_all(exchange_.ask(now_ns()));
    if (wait_for_answer(SerialLine::kRoundNs)) return;
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
    if (!line_.wait(until_ns)) return false;
  }
  return false;
}

void HaplyLine::hear(int64_t now_ns) {
  line_.hear([&](std::span<const uint8_t> bytes) { exchange_.hear(bytes, now_ns); });
  if (!line_.is_open()) mailbox_.set_gone();
}

/// Sends bytes; those that do not fit wait for the next time, since the board takes the bytes
/// behind half a question for its end.
void HaplyLine::write_all(std::span<const uint8_t> bytes) {
  const size_t n = line_.say(bytes);
  if (!line_.is_open()) mailbox_.set_gone();
  if (n == 0) return;
  rest_size_ = bytes.size() - n;
  if (rest_size_ > rest_.size()) rest_size_ = 0;
  std::copy(bytes.end() - static_cast<ptrdiff_t>(rest_size_), bytes.end(),
            rest_.end() - static_cast<ptrdiff_t>(rest_size_));
}

void HaplyLine::say(int64_t now_ns) {
  if (!line_.is_open()) return;
  if (rest_size_ > 0) {
    const HaplyQuestion rest = rest_;
    write_all({rest.end() - static_cast<ptrdiff_t>(rest_size_), rest_size_});
    return;
  }
  if (exchange_.may_ask(now_ns)) write_all(exchange_.ask(now_ns));
}

void HaplyLine::stop() {
  const int64_t give_up_ns = now_ns() + SerialLine::kStopNs;
  if (exchange_.awaits()) wait_for_answer(SerialLine::kStopWaitNs);
  while (line_.is_open() && now_ns() < give_up_ns) {
    say(now_ns());
    if (rest_size_ == 0 && wait_for_answer(SerialLine::kStopWaitNs)) return;
  }
}

}  // namespace haptic
