// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/falcon/bring_up.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>

#include "device-io/falcon/packet.h"
#include "proto/ipc/process.h"
#include "proto/math/units.h"
#include "proto/os/message.h"

namespace haptic {
namespace {

// requests of the chip and their values (libftdi)
constexpr uint8_t kReset = 0, kModem = 1, kFlow = 2, kBaud = 3, kFormat = 4, kLatency = 9;
constexpr uint16_t kPurgeIn = 1, kPurgeOut = 2;
constexpr uint16_t kDtrOn = 0x0101, kDtrOff = 0x0100, kRtsOff = 0x0200;
constexpr uint16_t kNoFlow = 0, kEightBits = 8;
constexpr uint16_t kBaud9600 = 0x4138, kBaud142857 = 0x0015, kBaud1500000 = 0x0002;
constexpr uint16_t kBootLatency = 16, kLatencyMs = 1;

// the boot loader's greeting and answers
constexpr std::array<uint8_t, 3> kHello{0x0a, 0x43, 0x0d};
constexpr std::array<uint8_t, 4> kHelloBack{0x0a, 0x44, 0x2c, 0x0d};
constexpr std::array<uint8_t, 1> kBootBegin{'A'};

constexpr size_t kChunk = 62;  // a packet of the chip without its status
constexpr size_t kLargestImage =
    64 * 1024;  // [bytes]; bounds what is read of a file that is no firmware
constexpr int64_t kAnswerNs = 30 * kMs;  // of the firmware; it takes 1 ms
constexpr int kQuestions = 5;            // some are lost while the line settles
constexpr int64_t kHelloNs = 100 * kMs;  // at 9600 baud 7 ms, and the latency timer
constexpr int kHellos = 3;               // attempts
constexpr int64_t kEchoNs = 200 * kMs;   // 62 bytes at 142,857 baud: 4 ms, and the timer

/// Collects what comes until `enough` bytes are there or nothing came for `wait_ns`.
std::vector<uint8_t> collect(const FtdiPort& port, size_t enough, int64_t wait_ns) {
  std::vector<uint8_t> all;
  while (all.size() < enough) {
    const std::vector<uint8_t> some = port.receive(wait_ns);
    if (some.empty()) break;
    all.insert(all.end(), some.begin(), some.end());
  }
  return all;
}

void purge(const FtdiPort& port) {
  port.control(kReset, kPurgeIn);
  port.control(kReset, kPurgeOut);
}

void set_normal_mode(const FtdiPort& port) {
  port.control(kLatency, kLatencyMs);
  port.control(kBaud, kBaud1500000);
  port.control(kFormat, kEightBits);
  port.control(kFlow, kNoFlow);
  purge(port);
}

/// Some hosts see a zero before the answer, so that only its end counts.
bool ends_with_hello(const std::vector<uint8_t>& bytes) {
  return bytes.size() >= kHelloBack.size() &&
         std::equal(kHelloBack.rbegin(), kHelloBack.rend(), bytes.rbegin());
}

/// Starts the boot loader; false: it does not answer.
bool greet(const FtdiPort& port) {
  purge(port);
  port.control(kLatency, kBootLatency);
  port.control(kBaud, kBaud9600);
  port.control(kFormat, kEightBits);
  port.control(kFlow, kNoFlow);
  port.control(kModem, kRtsOff);
  port.control(kModem, kDtrOff);
  port.control(kModem, kDtrOn);
  bool answered = false;
  for (int n = 0; n < kHellos && !answered; ++n) {
    port.send(kHello);
    answered = ends_with_hello(collect(port, kHelloBack.size(), kHelloNs));
  }
  if (!answered) return false;
  port.control(kModem, kDtrOff);
  port.control(kBaud, kBaud142857);
  port.send(kBootBegin);
  const std::vector<uint8_t> echo = collect(port, kBootBegin.size(), kEchoNs);
  return !echo.empty() && echo.back() == kBootBegin.front();
}

/// Sends the image; false: an echo differs.
bool send_image(const FtdiPort& port, std::span<const uint8_t> image) {
  for (size_t at = 0; at < image.size(); at += kChunk) {
    const auto chunk = image.subspan(at, std::min(kChunk, image.size() - at));
    port.send(chunk);
    const std::vector<uint8_t> echo = collect(port, chunk.size(), kEchoNs);
    if (!std::equal(chunk.begin(), chunk.end(), echo.begin(), echo.end())) return false;
  }
  return true;
}

}  // namespace

bool is_running(const FtdiPort& port) {
  set_normal_mode(port);
  const FalconBytes zero = encode_falcon({});
  FalconReader reader;
  MotorSample answer;
  for (int n = 0; n < kQuestions; ++n) {
    port.send(zero);
    for (const uint8_t byte : collect(port, kFalconPacket, kAnswerNs)) {
      if (reader.push(byte, answer)) return true;
    }
  }
  return false;
}

FalconBoot bring_up(const FtdiPort& port, std::span<const uint8_t> image, const std::string& name) {
  if (is_running(port)) return FalconBoot::kWasRunning;
  if (image.empty()) {
    throw DeviceError(
        "the Falcon has no firmware since it was switched on; name its image, from Novint's own "
        "driver, with 'firmware' in [device.falcon]");
  }
  bool greeted = false;
  for (int n = 0; n < kMostAttempts; ++n) {
    if (!greet(port)) continue;
    greeted = true;
    if (send_image(port, image) && is_running(port)) return FalconBoot::kLoaded;
  }
  if (!greeted) {
    throw DeviceError(
        "the Falcon's boot loader does not answer; check its power supply, switch it off and on, "
        "and plug it into a port of the computer itself");
  }
  throw DeviceError("the Falcon does not run with " + shown(name) + ", sent " +
                    std::to_string(kMostAttempts) +
                    " times; check that this is its firmware, and the cable");
}

std::vector<uint8_t> read_firmware(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  const std::vector<uint8_t> image{std::istreambuf_iterator<char>(file), {}};
  if (!file.is_open() || file.bad()) {
    throw InputError(shown(path) + ": cannot be read: " + std::strerror(errno) +
                     "; correct 'firmware' in [device.falcon]");
  }
  if (image.empty() || image.size() > kLargestImage) {
    throw InputError(shown(path) + ": has " + std::to_string(image.size()) +
                     " bytes, and is no firmware of a Falcon, which has 7 to 9 thousand; correct "
                     "'firmware' in [device.falcon]");
  }
  return image;
}

}  // namespace haptic
