// SPDX-License-Identifier: GPL-3.0-or-later
// The driver on a terminal, with an emulated board at its other end, in real time.
#include <atomic>
#include <catch2/catch.hpp>
#include <thread>

#include "device-io/emulator/emulated_haply.h"
#include "device-io/hand/impedance.h"
#include "device-io/haply/haply.h"
#include "proto/os/realtime.h"
#include "proto/os/serial_port.h"
#include "tests/support/pty_line.h"

using namespace haptic;
using namespace haptic::test;
using Catch::Matchers::Contains;

namespace {

/// A board that somebody holds at its home, and pulls on.
EmulatedHaplyOptions at_home() {
  EmulatedHaplyOptions options;
  put_into_hand(*find_hand("stiff-arm"), options.hand);
  options.hand.intent.centre_B = options.home_B;
  options.hand.intent.hover_radius = options.hand.intent.press_radius = 0;
  options.hand.intent.tremor_amplitude = 0;
  return options;
}

/// The board's end of the terminal, in a thread.
class Desk {
 public:
  Desk() : board_(at_home()), thread_([this] { run(); }) {}
  ~Desk() { end(); }
  Desk(const Desk&) = delete;
  Desk& operator=(const Desk&) = delete;

  DeviceConfig config() const {
    DeviceConfig config;
    assign(config.serial.path, line_.name());
    return config;
  }
  FileDescriptor node() const { return open_serial_port(line_.name()); }
  /// To the board, as from a program before.
  void tell(EmulatedHaply::Bytes bytes) {
    before_ = std::move(bytes);
    told_ = true;
    while (told_) std::this_thread::yield();
  }
  /// The larger of the motors' [N·m].
  double torque() const { return torque_; }
  void unplug() {
    end();
    line_.unplug();
  }
  /// The board, which has stopped.
  const EmulatedHaply& board() {
    end();
    return board_;
  }

 private:
  void end() {
    ending_ = true;
    if (thread_.joinable()) thread_.join();
  }
  void run() {
    while (!ending_) {
      if (told_) board_.take(before_, now_ns());
      told_ = false;
      const std::string heard = line_.hear(1);
      board_.take({reinterpret_cast<const uint8_t*>(heard.data()), heard.size()}, now_ns());
      // commands take turns of 50 µs
      std::this_thread::sleep_for(std::chrono::microseconds(300));
      const EmulatedHaply::Bytes said = board_.give(now_ns());
      torque_ = board_.largest_torque();
      if (!said.empty()) line_.pass({reinterpret_cast<const char*>(said.data()), said.size()});
    }
  }

  PtyLine line_;
  EmulatedHaply board_;
  EmulatedHaply::Bytes before_;
  std::atomic<double> torque_{0};
  std::atomic<bool> ending_{false}, told_{false};
  std::thread thread_;
};

/// Ticks until a sample is fresh; −1: none within a second.
int ticks_until_fresh(Haply& device, DeviceState& state) {
  for (int i = 0; i < 1000; ++i) {
    const int64_t t_ns = now_ns();
    if (device.read({t_ns, t_ns}, state)) return i;
    device.write({});
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return -1;
}

template <size_t N>
EmulatedHaply::Bytes sent_bytes(const std::array<uint8_t, N>& bytes) {
  return {bytes.begin(), bytes.end()};
}

}  // namespace

TEST_CASE("haply line: a board that is new is set up, and its handle is at home", "[device-io]") {
  Desk desk;
  {
    Haply device(desk.config(), desk.node());
    CHECK_THAT(device.description(),
               Contains("2 axes") && Contains("must be its home") && Contains("out of its plane"));
    DeviceState state{};
    REQUIRE(ticks_until_fresh(device, state) >= 0);
    CHECK(state.X_BH.p.x == Approx(0).margin(1e-4));
    CHECK(state.X_BH.p.y == Approx(0.0360555).margin(1e-4));
    CHECK((state.flags & kDeviceHomed) != 0);
  }
  CHECK(desk.board().setups() == 1);
}

TEST_CASE("haply line: a board that is set up keeps its counts", "[device-io]") {
  Desk desk;
  {
    EmulatedHaply::Bytes before = sent_bytes(encode_haply_setup(kHaplyDevice, {}));
    const HaplyQuestion half = encode_haply(0x20, 9000, 9000);
    // in the middle of a question
    if (GENERATE(false, true)) before.insert(before.end(), half.begin(), half.begin() + 9);
    desk.tell(before);
    Haply device(desk.config(), desk.node());
    CHECK_THAT(device.description(), Contains("an earlier session"));
  }
  CHECK(desk.board().setups() == 1);
  CHECK(desk.board().resets() == 0);
  CHECK(desk.board().largest_torque() == 0);
}

TEST_CASE(
    "haply line: one that another program has set up, or left in the middle of a packet, is "
    "set up anew",
    "[device-io]") {
  Desk desk;
  {
    EmulatedHaply::Bytes before = sent_bytes(encode_haply_setup(5, {{{180, 13824}, {0, 13824}}}));
    if (GENERATE(false, true)) {
      const HaplyTorques half = encode_haply_torques(5, {0.1f, 0.1f});
      before.insert(before.end(), half.begin(), half.begin() + 7);
    }
    desk.tell(before);
    Haply device(desk.config(), desk.node());
    CHECK_THAT(device.description(), Contains("must be its home"));
    DeviceState state{};
    CHECK(ticks_until_fresh(device, state) >= 0);
  }
  CHECK(desk.board().setups() == 2);
  CHECK(desk.board().largest_torque() == 0);
}

TEST_CASE("haply line: stopping ends with zero torques, confirmed", "[device-io]") {
  Desk desk;
  DeviceState state{};
  {
    DeviceConfig config = desk.config();
    config.max_force = 2;
    Haply device(config, desk.node());
    REQUIRE(ticks_until_fresh(device, state) >= 0);
    for (int i = 0; i < 30; ++i) {
      const int64_t t_ns = now_ns();
      device.read({t_ns, t_ns}, state);
      device.write({{0, 1, 0}, {}});
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    device.stop();
  }
  // on a busy machine it gives up after 40 ms; the zero comes all the same
  for (int i = 0; i < 2000 && desk.torque() != 0; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  CHECK(desk.torque() == 0);
  CHECK(desk.board().commands() > 5);
  CHECK(desk.board().largest_torque() == 0);
}

TEST_CASE("haply line: unplugged, it is lost and its node is free", "[device-io]") {
  Desk desk;
  Haply device(desk.config(), desk.node());
  DeviceState state{};
  REQUIRE(ticks_until_fresh(device, state) >= 0);
  desk.unplug();
  const int64_t t_ns = now_ns();
  CHECK_FALSE(device.read({t_ns, t_ns}, state));
  CHECK((state.flags & kDeviceLost) != 0);
  device.write({{0, 1, 0}, {}});
  device.stop();
}

TEST_CASE("haply line: what does not answer is said in a line with its mend", "[device-io]") {
  const PtyLine deaf;
  DeviceConfig config;
  assign(config.serial.path, deaf.name());
  CHECK_THROWS_WITH(Haply(config, open_serial_port(deaf.name())),
                    Contains("no answer within 2 s") && Contains("its handle at home"));
}
