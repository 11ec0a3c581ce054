// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/emulator/emulated_hid_arm.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "device-io/emulator/emulated_usb.h"
#include "proto/math/mat3.h"
#include "proto/math/units.h"

namespace haptic {
namespace {

constexpr int64_t kArmReportNs = kMs;          // bInterval 1 at full speed
constexpr int64_t kArmWatchdogNs = 500 * kMs;  // msg_watchdog.attach(…, 0.5)
constexpr int kMostMilliamperes = 3000;        // above it the firmware's signal is full
constexpr size_t kReport = 8;                  // bytes
const Vec3 kMiddle{0.22, 0, 0.08};             // workspace_origin of woodenhaptics_2016ed.json [m]

UsbDescriptors describe_hid_arm(const EmulatedHidArmOptions& options) {
  UsbDescriptors all;
  all.vendor = 0x1234;
  all.product = 0x0006;
  // USBHID::reportDesc of mbed: vendor's page 0xffab, 8 bytes each way, no report numbers
  all.hid_report = {0x06, 0xab, 0xff, 0x0a, 0x00, 0x02, 0xa1, 0x01, 0x75, 0x08,
                    0x15, 0x00, 0x26, 0xff, 0x00, 0x95, 0x08, 0x09, 0x01, 0x81,
                    0x02, 0x95, 0x08, 0x09, 0x02, 0x91, 0x02, 0xc0};
  const auto length = static_cast<uint8_t>(all.hid_report.size());
  all.device = {18, 1, 0x00, 0x02, 0, 0, 0, 64, 0x34, 0x12, 0x06, 0x00, 0x01, 0x00, 1, 2, 3, 1};
  all.configuration = {9, 2,    41, 0,  1, 1,  0,    0x80, 50,   9, 4,    0,      0, 2,
                       3, 0,    0,  0,  9, 33, 0x11, 0x01, 0,    1, 0x22, length, 0, 7,
                       5, 0x81, 3,  64, 0, 1,  7,    5,    0x01, 3, 64,   0,      1};
  all.strings = {"mbed.org", options.product, options.serial};
  return all;
}

/// x with columns · x = b, by Cramer's rule.
Vec3 solved(const std::array<Vec3, 3>& columns, const Vec3& b) {
  const double all = dot(columns[0], cross(columns[1], columns[2]));
  return Vec3{dot(b, cross(columns[1], columns[2])), dot(columns[0], cross(b, columns[2])),
              dot(columns[0], cross(columns[1], b))} /
         all;
}

}  // namespace

EmulatedHidArm::EmulatedHidArm(const EmulatedHidArmOptions& options)
    : options_(options),
      descriptors_(describe_hid_arm(options)),
      intention_(seeded_intention(options.hand)) {
  plant_ = start_plant(options_.hand, intention_);
  sense();
}

/// The three bodies as a chain: the shoulder, the upper arm leaning from the vertical, the forearm
/// risen from hanging, all turned about the vertical.
Vec3 EmulatedHidArm::tip(const Vec3& angles) const {
  const Vec3& links = options_.arm.links;
  const Quat turn = from_rotation_vector({0, 0, angles.x});
  const Quat lean = turn * from_rotation_vector({0, angles.y, 0});
  const Quat rise = turn * from_rotation_vector({0, -angles.z, 0});
  const Vec3 elbow = Vec3{0, 0, links.x} + rotate(lean, {0, 0, links.y});
  return elbow + rotate(rise, {0, 0, -links.z}) - Vec3{kMiddle.x, kMiddle.y, links.x};
}

void EmulatedHidArm::sense() {
  constexpr double kStep = 1e-6;  // [rad]
  for (int n = 0; n < 12; ++n) {
    std::array<Vec3, 3> columns;
    for (int i = 0; i < 3; ++i) {
      Vec3 step;
      step[i] = kStep;
      columns[static_cast<size_t>(i)] = (tip(angles_ + step) - tip(angles_ - step)) / (2 * kStep);
    }
    const Vec3 rest = plant_.p_B - tip(angles_);
    if (norm(rest) < 1e-12) break;
    angles_ += solved(columns, rest);
  }
  const HidArmConfig& arm = options_.arm;
  for (int i = 0; i < 3; ++i) {
    const double turns = (angles_[i] - arm.homes[i]) / (2 * kPi) * arm.bodies[i] / arm.capstans[i];
    counts_[static_cast<size_t>(i)] =
        static_cast<int>(std::floor(arm.signs[i] * turns * arm.counts_per_turn));
  }
}

/// The force whose work along each joint is that of its motor.
Vec3 EmulatedHidArm::motor_force() const {
  constexpr double kStep = 1e-6;
  const HidArmConfig& arm = options_.arm;
  std::array<Vec3, 3> ways;
  Vec3 torques;
  for (int i = 0; i < 3; ++i) {
    Vec3 step;
    step[i] = kStep;
    ways[static_cast<size_t>(i)] = (tip(angles_ + step) - tip(angles_ - step)) / (2 * kStep);
    torques[i] = arm.motor_signs[i] * 1e-3 * milliamperes_[static_cast<size_t>(i)] *
                 arm.torque_constant * arm.bodies[i] / arm.capstans[i];
  }
  // ways as rows: the columns of the transpose
  const std::array<Vec3, 3> columns{Vec3{ways[0].x, ways[1].x, ways[2].x},
                                    Vec3{ways[0].y, ways[1].y, ways[2].y},
                                    Vec3{ways[0].z, ways[1].z, ways[2].z}};
  return solved(columns, torques);
}

bool EmulatedHidArm::control(const UsbSetup& setup, const UsbBytes& out, UsbBytes&, int64_t t_ns) {
  constexpr uint8_t kToInterface = 0x21, kSetReport = 9, kSetIdle = 10;
  if (setup.type != kToInterface) return false;
  if (setup.request == kSetReport) take(1, out.data(), out.size(), t_ns);
  return setup.request == kSetReport || setup.request == kSetIdle;
}

void EmulatedHidArm::take(uint8_t endpoint, const uint8_t* bytes, size_t size, int64_t t_ns) {
  if (endpoint != 1) throw std::logic_error("the arm has one OUT endpoint");
  advance_to(t_ns);
  if (size != kReport || loses()) return;
  for (size_t i = 0; i < 3; ++i) {
    const int word = bytes[2 * i] + 256 * bytes[2 * i + 1];
    milliamperes_[i] =
        std::clamp(word < 32768 ? word : word - 65536, -kMostMilliamperes, kMostMilliamperes);
  }
  enabled_ = true;
  commanded_ns_ = t_ns;
  ++commands_;
  force_B_ = motor_force();
}

void EmulatedHidArm::report() {
  if (lie_ == EmulatorFault::kSilent) return;
  std::array<int, 3> said = counts_;
  if (lie_ == EmulatorFault::kNoise) said[1] += static_cast<int>(random_() % 61) - 30;
  if (lie_ == EmulatorFault::kFlipped) said[1] = 2 * mirror_[1] - said[1];
  if (lie_ != EmulatorFault::kFlipped) mirror_ = counts_;
  ++counter_;
  if (lie_ == EmulatorFault::kJumps) counter_ = static_cast<uint16_t>(random_());
  UsbBytes report;
  for (const int word : {said[0], said[1], said[2], int{counter_}}) {
    const unsigned bits = static_cast<unsigned>(word) & 0xffff;
    report.push_back(static_cast<uint8_t>(bits % 256));
    report.push_back(static_cast<uint8_t>(bits / 256));
  }
  if (lie_ == EmulatorFault::kFrozen && !said_.empty()) report = said_.back();
  said_.push_back(report);
  if (said_.size() > kRemembered) said_.pop_front();
  if (loses()) return;
  if (lie_ == EmulatorFault::kHalves) {
    to_host_.push_back({report.begin(), report.begin() + 4});
    to_host_.push_back({report.begin() + 4, report.end()});
    return;
  }
  if (lie_ == EmulatorFault::kOldFirst) to_host_.push_back(said_.front());
  to_host_.push_back(lie_ == EmulatorFault::kDelayed ? said_.front() : report);
}

bool EmulatedHidArm::give(uint8_t endpoint, size_t most, UsbBytes& packet, int64_t t_ns) {
  if (endpoint != 0x81) throw std::logic_error("the arm has one IN endpoint");
  advance_to(t_ns);
  if (to_host_.empty() && t_ns - reported_ns_ >= kArmReportNs) {
    reported_ns_ = t_ns;
    report();
  }
  if (to_host_.empty()) return false;
  packet = to_host_.front();
  to_host_.pop_front();
  packet.resize(std::min(packet.size(), most));
  return true;
}

void EmulatedHidArm::advance_to(int64_t t_ns) {
  if (t_ns_ == 0) t_ns_ = t_ns;
  if (t_ns <= t_ns_) return;
  if (t_ns - commanded_ns_ > kArmWatchdogNs) {
    enabled_ = false;
    milliamperes_ = {};
    force_B_ = {};
  }
  advance(options_.hand, intention_, plant_, with_load({force_B_, {}}, options_.load, plant_),
          t_ns - t_ns_);
  t_ns_ = t_ns;
  sense();
  if (enabled_) force_B_ = motor_force();
}

}  // namespace haptic
