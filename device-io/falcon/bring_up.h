// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace haptic {

/// The chip between USB and the device, as bring_up() needs it. All of it may block, and throws
/// DeviceError if the device is gone.
struct FtdiPort {
  /// A vendor request without data.
  std::function<void(uint8_t request, uint16_t value)> control;
  std::function<void(std::span<const uint8_t> bytes)> send;
  /// The payload of the packets that have come, without modem status; empty: none came within
  /// `wait_ns`.
  std::function<std::vector<uint8_t>(int64_t wait_ns)> receive;
};

/// The findings of bring_up().
enum class FalconBoot {
  kWasRunning,  // the firmware of an earlier program; it stays until the power is cut
  kLoaded,      // the image was sent
};

/// Prepares a Falcon for 16-byte packets: asks for its firmware; if there is none, starts the boot
/// loader (latency timer 16 ms, 9600 baud, then 142,857), sends `image` and compares the echo of
/// each byte; then the normal mode, latency timer 1 ms and 1.5 Mbaud. An echo that differs begins
/// it anew, at most kMostAttempts times. Takes up to 0.3 s, with an image about 2 s.
///
/// Throws DeviceError in one line: no firmware runs and `image` is empty; no answer of the boot
/// loader; the echo is never right. `name` is the file of the image, for messages.
/// Source: libnifalcon's FalconComm and FalconFirmware (facts only).
FalconBoot bring_up(const FtdiPort& port, std::span<const uint8_t> image, const std::string& name);

inline constexpr int kMostAttempts = 10;  // as libnifalcon

/// Only asks whether the firmware runs, in the normal mode.
bool is_running(const FtdiPort& port);

/// Reads an image. Throws InputError: cannot be read, is empty, or above 64 KiB, the memory of the
/// device's processor.
std::vector<uint8_t> read_firmware(const std::string& path);

}  // namespace haptic
