// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/usb/devices.h"

#include <array>
#include <cmath>
#include <stdexcept>

#include "device-io/emulator/emulated_falcon.h"
#include "device-io/emulator/emulated_hid_arm.h"
#include "device-io/emulator/emulated_spacemouse.h"
#include "device-io/hand/impedance.h"
#include "proto/os/message.h"

namespace haptic::test {
namespace {

/// A typical hand that presses on the middle of the workspace, against `up_B`, each 1.2 s.
SimulatedHandConfig stroking_hand(const Vec3& up_B, double mass, double damping) {
  SimulatedHandConfig hand;
  hand.mass = mass;
  hand.damping = damping;
  put_into_hand(*find_hand("typical"), hand);
  hand.intent.centre_B = {};
  hand.intent.direction_B = up_B;
  hand.intent.hover_radius = 0.010;
  hand.intent.press_radius = -0.008;
  hand.intent.stroke_angle = 0.2;
  return hand;
}

class CountedFalcon final : public CountedDevice {
 public:
  CountedFalcon() : falcon_({.hand = stroking_hand({0, 1, 0}, 0.25, 1), .has_firmware = true}) {}
  EmulatedUsb& usb() override { return falcon_; }
  void end(int64_t t_ns) override { falcon_.let_pass(t_ns); }
  std::string account() const override {
    return "packets=" + std::to_string(falcon_.packets()) +
           " rejected=" + std::to_string(falcon_.rejected()) +
           " answers=" + std::to_string(falcon_.answers()) +
           " longest_gap_ms=" + std::to_string(falcon_.longest_gap_ns() / 1'000'000) +
           " force_words=" + std::to_string(falcon_.pushing_packets()) +
           " watchdogs=" + std::to_string(falcon_.watchdogs()) + " let_go_ms=" + let_go();
  }

 private:
  std::string let_go() const {
    std::string text;
    for (const int64_t t_ns : falcon_.let_go_ns()) {
      text += (text.empty() ? "" : ",") + std::to_string(t_ns / 1'000'000);
    }
    return text;
  }

  EmulatedFalcon falcon_;
};

class CountedHidArm final : public CountedDevice {
 public:
  CountedHidArm() : arm_({.hand = stroking_hand({0, 0, 1}, 0.15, 0.3)}) {}
  EmulatedUsb& usb() override { return arm_; }
  std::string account() const override { return "commands=" + std::to_string(arm_.commands()); }

 private:
  EmulatedHidArm arm_;
};

/// A hand that pushes the knob down for 3 s and pulls it up for 1 s.
class CountedSpaceMouse final : public CountedDevice {
 public:
  CountedSpaceMouse()
      : knob_({.product = 0xc635, .hand = [](double t) {
                 return std::array<int, 6>{0, 0, std::fmod(t, 4) < 3 ? 200 : -200, 0, 0, 0};
               }}) {}
  EmulatedUsb& usb() override { return knob_; }
  std::string account() const override { return "reports=" + std::to_string(knob_.reports()); }

 private:
  EmulatedSpaceMouse knob_;
};

}  // namespace

std::unique_ptr<CountedDevice> make_device(const std::string& kind) {
  if (kind == "falcon") return std::make_unique<CountedFalcon>();
  if (kind == "woodenhaptics-hid") return std::make_unique<CountedHidArm>();
  if (kind == "spacemouse") return std::make_unique<CountedSpaceMouse>();
  throw std::runtime_error("there is no emulated '" + shown(kind) +
                           "'; use falcon, woodenhaptics-hid or "
                           "spacemouse");
}

}  // namespace haptic::test
