// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/usb/devices.h"

#include <stdexcept>

#include "device-io/hand/impedance.h"
#include "proto/os/message.h"
#include "tests/support/usb/emulated_falcon.h"

namespace haptic::test {
namespace {

/// A typical hand that presses on the middle of the workspace, along `down_B`, each 1.2 s.
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
  std::string account() const override {
    return "packets=" + std::to_string(falcon_.packets()) +
           " rejected=" + std::to_string(falcon_.rejected()) +
           " answers=" + std::to_string(falcon_.answers()) +
           " longest_gap_ms=" + std::to_string(falcon_.longest_gap_ns() / 1'000'000) +
           " force_words=" + std::to_string(falcon_.pushing_packets());
  }

 private:
  EmulatedFalcon falcon_;
};

}  // namespace

std::unique_ptr<CountedDevice> make_device(const std::string& kind) {
  if (kind == "falcon") return std::make_unique<CountedFalcon>();
  throw std::runtime_error("there is no emulated '" + shown(kind) + "'; use falcon");
}

}  // namespace haptic::test
