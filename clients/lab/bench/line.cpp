// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/support/measurement.h"

#include <poll.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "clients/library/histogram.h"
#include "device-io/woodenhaptics/protocol.h"
#include "proto/config/command_line.h"
#include "proto/os/priorities.h"
#include "proto/os/realtime.h"
#include "proto/os/serial_port.h"

namespace haptic {
namespace {

constexpr int64_t kPeriodNs = 1'000'000;     // a tick
constexpr int64_t kPatienceNs = 20'000'000;  // a device that takes longer is lost to the servo

struct Options {
  std::string node;
  double seconds = 5;
  size_t motors = 6;
};

struct Answers {
  Histogram times;  // from before the write of a line to after the read of its answer
  uint64_t lines = 0, late = 0, missing = 0, errors = 0;
};

/// The answer to the line just written; nothing if none comes in time.
std::optional<EncoderReply> wait_for_answer(int node, ReplyReader& reader, int64_t until_ns) {
  EncoderReply reply;
  std::array<char, 256> bytes;
  while (now_ns() < until_ns) {
    pollfd waiting{node, POLLIN, 0};
    poll(&waiting, 1, 1);
    const ssize_t n = read(node, bytes.data(), bytes.size());
    if (n == 0 || (n < 0 && errno != EAGAIN && errno != EINTR)) {
      throw std::runtime_error("bench line: the device hung up");
    }
    bool any = false;
    for (ssize_t i = 0; i < n; ++i) any |= reader.push(bytes[static_cast<size_t>(i)], reply);
    if (any) return reply;
  }
  return std::nullopt;
}

/// Asks with zero currents once a tick.
Answers ask(const Options& options) {
  const FileDescriptor node = open_serial_port(options.node);
  const CommandText zero = encode_currents({}, Challenge::kNone, options.motors);
  const RealtimeReport rights = enter_realtime({.fifo_priority = kServoPriority});
  (void)rights;  // the machine's row says the load; without the right the tail is longer
  ReplyReader reader;
  Answers answers;
  DeadlineClock clock(kPeriodNs);
  const auto n = static_cast<uint64_t>(1e9 * options.seconds / static_cast<double>(kPeriodNs));
  while (answers.lines < n) {
    clock.wait();
    const int64_t asked_ns = now_ns();
    if (write(node.get(), zero.text.data(), zero.size) != static_cast<ssize_t>(zero.size)) {
      throw std::runtime_error("bench line: " + options.node + " takes no line");
    }
    const auto reply = wait_for_answer(node.get(), reader, asked_ns + kPatienceNs);
    const int64_t took_ns = now_ns() - asked_ns;
    ++answers.lines;
    answers.missing += !reply;
    if (!reply) continue;
    answers.errors += reply->error != 0;
    answers.late += took_ns > kPeriodNs;
    answers.times.add(took_ns);
  }
  return answers;
}

void all_rows(const Options& options, const Rows& all) {
  const Answers answers = ask(options);
  Rows rows = all.machine("line");
  rows.add({{"lines asked", answers.lines},
            {"not answered within 20 ms", answers.missing, "", kMustBeZero},
            {"answered with an error", answers.errors, "", kMustBeZero},
            {"answered after the next tick", answers.late}});
  rows.add("answer", answers.times);
}

}  // namespace

/// Measures how long a device on a serial node takes to answer the line of docs/six-motors.md,
/// asked once a tick with zero currents: from before the write to after the read.
Measured bench_line(Command& command) {
  const auto options = std::make_shared<Options>();
  command.option("NODE", options->node, "of the device, or of the program that speaks for it")
      .required();
  command.quantity("--for", options->seconds, Dimension::kTime, {0.1, 3600}, "of asking", "s")
      .show_default();
  add_counts(command, {{"--motors", &options->motors, "numbers in a line", 1, 6}});
  return measured(all_rows, options);
}

}  // namespace haptic
