// SPDX-License-Identifier: GPL-3.0-or-later
// A session of the device "slider" in lockstep, an emulated one at the other end of its line: the
// handle goes into a plate and out; then the device repeats an old answer; then hapticd lets go of
// it. Says what is wrong, and exits with 1.
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <memory>

#include "contact/shape/mesh/primitives.h"
#include "contact/step.h"
#include "device-io/device.h"
#include "proto/config/config.h"
#include "proto/config/devices.h"
#include "servo/step.h"

namespace {

using namespace haptic;

constexpr double kStiffness = 800;  // [N/m]
constexpr double kTop = 0.01;       // of the plate [m]
constexpr const char* kSession = R"(
[session]
name = "outside"
[device]
kind = "slider"
max_force = "10 N"
[device.serial]
path = "/dev/ttyACM0"
[safety]
soft_start = "50 ms"
[coupling]
stiffness = "800 N/m"
[[object]]
name = "plate"
primitive = "box"
extent = ["200 mm", "200 mm", "20 mm"]
)";

/// The device as its bytes are described, moved by a hand that nothing stops.
class EmulatedSlider {
 public:
  EmulatedSlider() {
    int ends[2];
    if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0, ends) != 0) return;
    wire_ = FileDescriptor(ends[0]);
    node_ = FileDescriptor(ends[1]);
    kept_ = FileDescriptor(dup(ends[1]));
    // the answer to the driver's greeting, which is number 1
    say(1);
  }

  FileDescriptor take_node() { return std::move(node_); }

  void pass() {
    std::array<uint8_t, 4> asked;
    while (read(wire_.get(), asked.data(), asked.size()) > 0) {
      force_ = 1e-3 * static_cast<int16_t>(asked[2] | asked[3] << 8);
      say(repeats_ ? 7 : asked[1]);
    }
  }

  /// As hapticd does it for a servo that is dead, over a duplicate of the node.
  bool is_released(const DeviceRelease& zero) {
    const bool bytes = zero.by == static_cast<uint32_t>(ReleaseBy::kWrite) &&
                       write(kept_.get(), zero.bytes.data(), zero.size) > 0;
    pass();
    return bytes;
  }

  void put(double z) { z_ = z; }
  void repeat_itself() { repeats_ = true; }
  double force() const { return force_; }

 private:
  void say(uint8_t number) const {
    const auto counts = static_cast<uint16_t>(std::lround(z_ / 1e-5));
    const std::array<uint8_t, 4> answer{0x0f, number, static_cast<uint8_t>(counts),
                                        static_cast<uint8_t>(counts >> 8)};
    if (write(wire_.get(), answer.data(), answer.size()) < 0) std::puts("the line is full");
  }

  FileDescriptor wire_, node_, kept_;
  double z_ = 0.02, force_ = 0;  // [m], [N]
  bool repeats_ = false;
};

struct Session {
  SessionConfig config = parse_config(kSession, "outside.toml");
  EmulatedSlider emulated;
  std::unique_ptr<Device> device = open_device(config.device, emulated.take_node());
  MeshShapeData plate = build_shape(make_mesh(config.objects[0].primitive));
  ContactModel contact_model = build_contact_model(config, std::array{plate.view()});
  ServoModel servo_model = build_servo_model(config, {device->caps().max_force, 0});
  ContactState contact{contact_model};
  ServoState servo;
  ControlFrame control{};
  ContactSet set{};
  ServoInput input;
  uint64_t tick = 0;

  Session() {
    control.armed = 1;
    control.translational_stiffness = kStiffness;
    control.renderer = static_cast<uint32_t>(config.renderer);
    input.control = &control;
  }

  ServoFrame step(double z) {
    input.tick = ++tick;
    input.t_ns = static_cast<int64_t>(tick) * 1'000'000;
    emulated.put(z);
    emulated.pass();
    device->read({input.t_ns, input.t_ns}, input.device);
    if (tick > 1) input.contacts = &set;
    const ServoFrame frame = servo_step(servo_model, servo, input);
    device->write(frame.F_device_B);
    set = contact_step(contact_model, contact, frame, nullptr);
    return frame;
  }
};

/// Height of the handle [m]: 1 mm above the plate, 2 mm below its top, and back, 10 µm a tick.
double height_at(int tick) {
  return kTop + 1e-5 * std::abs(300 - tick) - 2e-3;
}

bool is_pushed_out(Session& session) {
  double strongest = 0, worst = 0, told = 0;
  for (int k = 0; k < 600; ++k) {
    const ServoFrame frame = session.step(height_at(k));
    // what the device feels is what it was told in the tick before, to a thousandth of a newton
    worst = std::max(worst, std::fabs(session.emulated.force() - told));
    told = frame.F_device_B.f.z;
    const double depth = std::max(0.0, kTop - frame.X_WT.p.z);
    if ((frame.flags & (kServoSoftStart | kServoDisarmed | kServoNoDevice)) == 0) {
      worst = std::max(worst, std::fabs(frame.F_coupling_W.f.z - kStiffness * depth));
    }
    strongest = std::max(strongest, session.emulated.force());
  }
  std::printf("slider: pushed with %.3f N at most, wrong by at most %.4f N\n", strongest, worst);
  return strongest > 1.5 && worst < 6e-4;
}

/// Brings the handle 1 mm into the plate.
bool presses(Session& session) {
  for (int k = 0; k < 200; ++k) session.step(height_at(k));
  for (int k = 0; k < 100; ++k) session.step(kTop - 1e-3);
  return session.emulated.force() > 0.7;
}

bool is_closed_when_it_lies(Session& session) {
  const bool pushed = presses(session);
  session.emulated.repeat_itself();
  int found = -1;
  for (int k = 0; k < 60; ++k) {
    const ServoFrame frame = session.step(kTop - 1e-3);
    const bool stale = (frame.device.flags & kDeviceStale) != 0;
    if (found < 0 && stale && frame.F_device_B.f.z == 0) found = k;
  }
  std::printf("slider: an old answer was found after %d ms, %.3f N are left\n", found,
              session.emulated.force());
  return pushed && found > 0 && found <= 22 && session.emulated.force() == 0;
}

bool is_let_go() {
  Session session;
  const bool pushed = presses(session);
  const bool released = session.emulated.is_released(session.device->release());
  std::printf("slider: hapticd's zero leaves %.3f N\n", session.emulated.force());
  return pushed && released && session.emulated.force() == 0;
}

}  // namespace

int main() {
  const auto row = std::ranges::find(kDevices, std::string_view("slider"), &DeviceRow::name);
  if (row == kDevices.end() || !row->has_node()) {
    std::puts("the table does not know the device");
    return 1;
  }
  Session session;
  const bool good = is_pushed_out(session) && is_closed_when_it_lies(session) && is_let_go();
  return good ? 0 : 1;
}
