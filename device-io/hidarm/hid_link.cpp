// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/hidarm/hid_link.h"

#include <array>

#include "proto/ipc/process.h"
#include "proto/os/realtime.h"

namespace haptic {
namespace {

constexpr int kWaitMs = 2;        // for a report, which is due each millisecond
constexpr int kMostReports = 64;  // the kernel keeps as many for a late reader
constexpr int64_t kFirstNs =
    1'000'000'000;  // [ns], for the first report; an arm that is awake sends a thousand a second

}  // namespace

HidLink::HidLink(const std::string& path, MotorMailbox& mailbox)
    : TransferThread(mailbox), node_(path), exchange_(mailbox) {
  const int64_t until_ns = now_ns() + kFirstNs;
  while (exchange_.heard() == 0 && now_ns() < until_ns) {
    if (!hear_all(kWaitMs)) break;
  }
  if (exchange_.heard() == 0) {
    throw DeviceError(path +
                      ": reports nothing; check that it is a WoodenHaptics with its HID firmware, "
                      "plug it out and in again");
  }
  start([this] { run(); });
}

/// Takes all reports that wait; false: the device has gone.
bool HidLink::hear_all(int wait_ms) {
  std::array<uint8_t, 64> report;
  for (int i = 0; i < kMostReports; ++i) {
    const int n = node_.read(report, i == 0 ? wait_ms : 0);
    if (n < 0) return false;
    if (n == 0) return true;
    const std::span<const uint8_t> heard{report.data(), static_cast<size_t>(n)};
    const int64_t t_ns = now_ns();
    tell(true, heard, t_ns);
    exchange_.hear(heard, t_ns);
  }
  return true;
}

void HidLink::run() {
  while (!ending_ && hear_all(kWaitMs)) {
    const int64_t t_ns = now_ns();
    const auto command = exchange_.command(t_ns);
    if (!command) continue;
    follow_servo();
    tell(false, *command, t_ns);
    if (!node_.write(*command)) break;
    note_sent();
  }
  node_.write(encode_hid_arm({}));
  mailbox_.set_gone();
}

}  // namespace haptic
