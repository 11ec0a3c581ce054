// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/falcon/bring_up.h"

#include <catch2/catch.hpp>
#include <fstream>

#include "proto/ipc/process.h"
#include "tests/support/driver/falcon_bench.h"
#include "tests/support/temporary_folder.h"

using namespace haptic;
using namespace haptic::test;
using Catch::Matchers::Contains;

namespace {

constexpr int64_t kSecondNs = 1'000'000'000;

UsbBytes image() {
  UsbBytes bytes(7914);  // as large as Novint's
  for (size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<uint8_t>(i * 7 + (i >> 8));
  return bytes;
}

}  // namespace

TEST_CASE("falcon: an image is sent, and its firmware runs", "[device-io]") {
  const int wrong = GENERATE(0, 1, 3, 9);
  EmulatedFalcon device({.wrong_echoes = wrong});
  int64_t t_ns = kSecondNs;
  CHECK(bring_up(port_of(device, t_ns), image(), "image") == FalconBoot::kLoaded);
  CHECK(device.is_running());
  CHECK(device.image_size() == 7914);
  if (wrong == 0) CHECK(t_ns - kSecondNs < 5 * kSecondNs);
}

TEST_CASE("falcon: a firmware that runs already is left alone", "[device-io]") {
  EmulatedFalcon device({.has_firmware = true});
  int64_t t_ns = kSecondNs;
  CHECK(bring_up(port_of(device, t_ns), {}, "") == FalconBoot::kWasRunning);
  CHECK(device.image_size() == 0);
  CHECK(t_ns - kSecondNs < kSecondNs / 2);
}

TEST_CASE("falcon: what cannot be brought up is said in a line with its mend", "[device-io]") {
  int64_t t_ns = kSecondNs;
  SECTION("no image") {
    EmulatedFalcon device({});
    CHECK_THROWS_WITH(bring_up(port_of(device, t_ns), {}, ""),
                      Contains("no firmware") && Contains("[device.falcon]"));
  }
  SECTION("echoes are never right") {
    EmulatedFalcon device({.wrong_echoes = 1000});
    CHECK_THROWS_WITH(bring_up(port_of(device, t_ns), image(), "a\nb.bin"),
                      Contains("sent 10 times") && Contains("a\\nb.bin"));
  }
  SECTION("nothing answers") {
    EmulatedFalcon device({});
    FtdiPort deaf = port_of(device, t_ns);
    deaf.receive = [&](int64_t wait_ns) {
      t_ns += wait_ns;
      return UsbBytes{};
    };
    CHECK_THROWS_WITH(bring_up(deaf, image(), "image"), Contains("power supply"));
  }
}

TEST_CASE("falcon: with a latency timer that ignores requests it still comes up", "[device-io]") {
  EmulatedFalcon device({.latency_ns = 16'000'000});
  int64_t t_ns = kSecondNs;
  CHECK(bring_up(port_of(device, t_ns), image(), "image") == FalconBoot::kLoaded);
}

TEST_CASE("falcon: a file that is no image is refused", "[device-io]") {
  const TemporaryFolder folder;
  const std::string path = folder.path() + "/image.bin";
  CHECK_THROWS_WITH(read_firmware(path), Contains("cannot be read: No such file"));
  std::ofstream(path, std::ios::binary) << "";
  CHECK_THROWS_WITH(read_firmware(path), Contains("0 bytes"));
  std::ofstream(path, std::ios::binary) << std::string(70'000, 'x');
  CHECK_THROWS_WITH(read_firmware(path), Contains("70000 bytes"));
  std::ofstream(path, std::ios::binary) << std::string(8000, 'x');
  CHECK(read_firmware(path).size() == 8000);
}
