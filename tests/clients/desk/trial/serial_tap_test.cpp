// SPDX-License-Identifier: GPL-3.0-or-later
// Tests for clients/desk/trial/serial_tap.cpp, byte_log.cpp, trial_report.cpp and trial_run.cpp.
#include "clients/desk/trial/serial_tap.h"

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "clients/desk/trial/trial_report.h"
#include "clients/desk/trial/trial_run.h"
#include "proto/config/command_line.h"
#include "proto/ipc/process.h"
#include "proto/os/message.h"
#include "proto/os/serial_port.h"
#include "tests/support/pty_line.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/usb/device_bytes.h"

namespace haptic {
namespace {

/// All that one side said, in one piece.
std::string said(const std::vector<DeviceBytes>& pieces, bool by_device) {
  std::string all;
  for (const DeviceBytes& piece : pieces) {
    if (piece.by_device == by_device) all += piece.bytes;
  }
  return all;
}

/// The bytes that can be read within a second.
std::string read_from(int fd, size_t size) {
  std::string text;
  pollfd waiting{fd, POLLIN, 0};
  while (text.size() < size && poll(&waiting, 1, 1000) > 0) {
    char bytes[64];
    const ssize_t n = read(fd, bytes, sizeof bytes);
    if (n <= 0) break;
    text.append(bytes, static_cast<size_t>(n));
  }
  return text;
}

/// Counts what it is told; asks for the end of the program in its 50th tick.
class StoppedDevice final : public Device {
 public:
  explicit StoppedDevice(int& stops) : stops_(stops) {}
  DeviceCaps caps() const override { return {.max_force = 8}; }
  std::string description() const override { return "a device"; }
  bool read(const TickTime& tick, DeviceState& state) override {
    state.t_ns = tick.now_ns;
    state.flags = kDeviceFresh | kDeviceHomed;
    if (++ticks_ == 50) request_stop();
    return true;
  }
  void write(const Wrench&) override {}
  void stop() override { ++stops_; }

 private:
  int& stops_;
  int ticks_ = 0;
};

}  // namespace

TEST_CASE("serial tap: passes all bytes on in both directions and has them in order") {
  test::PtyLine line;
  SerialTap tap(open_serial_port(line.name()));
  const FileDescriptor driver = tap.driver_end();
  const std::string asked("[0,0,0]\n\x00\xff\r\x03\x11", 13), answered("\x01<\n\x7f\x00>\xfe", 7);
  REQUIRE(write(driver.get(), asked.data(), asked.size()) == 13);
  std::string heard;
  while (heard.size() < asked.size()) {
    const std::string more = line.hear();
    REQUIRE_FALSE(more.empty());
    heard += more;
  }
  CHECK(heard == asked);
  line.pass(answered);
  CHECK(read_from(driver.get(), answered.size()) == answered);
  const std::vector<DeviceBytes> pieces = tap.finish();
  CHECK(said(pieces, false) == asked);
  CHECK(said(pieces, true) == answered);
  CHECK_FALSE(pieces.front().by_device);
  CHECK(pieces.back().by_device);
  CHECK_FALSE(tap.is_cut());
}

TEST_CASE("serial tap: a device that is unplugged hangs up on the driver") {
  test::PtyLine line;
  SerialTap tap(open_serial_port(line.name()));
  const FileDescriptor driver = tap.driver_end();
  line.unplug();
  pollfd gone{driver.get(), 0, 0};
  CHECK(poll(&gone, 1, 2000) == 1);
  CHECK((gone.revents & POLLHUP) != 0);
}

TEST_CASE("device bytes: a file is read as it was written, and begins as documented") {
  const std::vector<DeviceBytes> pieces{
      {0, false, "[0]\n"}, {120, true, std::string("\x00\xff\x80", 3)}, {120, false, "x"}};
  std::stringstream file;
  write_device_bytes(pieces, file);
  CHECK(file.str() == "# hapticd device bytes 1\n0 > 5b305d0a\n120 < 00ff80\n120 > 78\n");
  CHECK(test::read_device_bytes(file) == pieces);
}

TEST_CASE("device bytes: a line that is wrong is named") {
  const std::string line = GENERATE("5 > 5b3", "5 > ", "5 = 5b", "x > 5b", "5 > 5g", "5 > 5b 00",
                                    "0 > 5b", "5 > \x1b[2J");
  std::istringstream file(std::string(kDeviceBytesHeader) + "\n# a remark\n3 > 5b\n" + line + "\n");
  try {
    test::read_device_bytes(file);
    FAIL("it was read");
  } catch (const InputError& error) {
    CHECK(std::string(error.what()).starts_with("line 4: "));
    CHECK(one_line(error.what()) == error.what());
  }
  std::istringstream other("t_s,x_m\n");
  CHECK_THROWS_AS(test::read_device_bytes(other), InputError);
}

TEST_CASE("trial report: one file has facts, steps and bytes, and is read as device bytes") {
  const TrialReport report{
      .kind = "falcon",
      .description = "Falcon\x1b[2J, homed",
      .facts = {"kernel: 6.1"},
      .steps = {{"1 of 3", {{"it answers", "1000 samples a second", Verdict::kPassed}}, ""},
                {"2 of 3", {{"pushes along x", "it went -3 mm", Verdict::kFailed}}, ""},
                {"3 of 3", {}, "not wanted"}},
      .bytes = "1 pieces"};
  const test::TemporaryFolder folder;
  const std::string path = folder.path() + "/report.txt";
  const std::vector<DeviceBytes> pieces{{120, true, "[7,0]\n"}};
  save_whole(path, [&](std::ostream& out) { write_device_bytes(pieces, out, remarks_of(report)); });
  std::ifstream in(path);
  CHECK(test::read_device_bytes(in) == pieces);
  std::ifstream again(path);
  const std::string text(std::istreambuf_iterator<char>(again), {});
  CHECK(text.starts_with("# hapticd device bytes 1\n# report of `hapt devices try`"));
  CHECK(
      text.ends_with("# kind: falcon\n# driver: Falcon\\x1b[2J, homed\n# kernel: 6.1\n"
                     "# step 1 of 3\n#   passed   it answers: 1000 samples a second\n"
                     "# step 2 of 3\n#   FAILED   pushes along x: it went -3 mm\n"
                     "# step 3 of 3: not wanted\n# bytes: 1 pieces\n120 < 5b372c305d0a\n"));
}

TEST_CASE("trial report: the file appears whole or not at all") {
  const test::TemporaryFolder folder;
  const std::string path = folder.path() + "/report.txt";
  std::ofstream(path) << "before";
  const auto text = [&] {
    std::ifstream in(path);
    return std::string(std::istreambuf_iterator<char>(in), {});
  };
  CHECK_THROWS_AS(save_whole(path,
                             [&](std::ostream& out) {
                               out << "half";
                               CHECK(text() == "before");
                               out.setstate(std::ios::badbit);
                             }),
                  std::runtime_error);
  CHECK(text() == "before");
  save_whole(path, [](std::ostream& out) { out << "after"; });
  CHECK(text() == "after");
  const std::filesystem::directory_iterator files(folder.path());
  CHECK(std::distance(begin(files), end(files)) == 1);
  CHECK_THROWS_AS(save_whole(folder.path() + "/none/report.txt", [](std::ostream&) {}),
                  std::runtime_error);
}

TEST_CASE("trial run: a signal ends it, and the device is left with zero force") {
  int stops = 0;
  StoppedDevice device(stops);
  const auto run = [&] {
    TrialRun trial(device, {.max_force = 8}, 1000);
    trial.push();
  };
  CHECK_THROWS_AS(run(), ExitCode);
  CHECK(stops == 1);
}

}  // namespace haptic
