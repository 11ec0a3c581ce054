// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/haply/haply.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "proto/os/serial_port.h"

namespace haptic {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;
// of the handle, as kTipAcceleration; near the edge an elbow moves twice as fast as the handle
constexpr double kMostAcceleration = 2 * 100;  // [m/s²]

DeviceRelease zero_force() {
  const HaplyTorques zero = encode_haply_torques(kHaplyDevice, {});
  DeviceRelease release{};
  release.by = static_cast<uint32_t>(ReleaseBy::kWrite);
  release.size = kHaplyPadding.size() + zero.size();
  // zeros behind half a question would be a reset, after which the board knows no motors and holds
  // its torques
  auto* const after = std::copy(kHaplyPadding.begin(), kHaplyPadding.end(), release.bytes.begin());
  std::copy(zero.begin(), zero.end(), after);
  return release;
}

struct Joints {
  PantographAngles angles{};
  Vec3 p_B;
};

/// A pantograph behind the ports of its board.
struct WiredPantograph {
  PantographGeometry geometry;
  PantographAngles offsets, signs;
  std::array<size_t, 2> ports;  // from 0, of link 1 and 2
  double counts_per_turn, reduction, max_torque;

  explicit WiredPantograph(const PantographConfig& config)
      : geometry{config.proximal, config.distal, config.base},
        offsets{config.offset_1, config.offset_2},
        signs{config.sign_1, config.sign_2},
        ports{config.port_1 == 1 ? size_t{0} : size_t{1}, config.port_1 == 1 ? size_t{1} : 0},
        counts_per_turn(config.counts_per_turn),
        reduction(config.reduction),
        max_torque(config.max_torque) {}

  PantographAngles angles(const MotorCounts& counts) const {
    PantographAngles out;
    for (size_t i = 0; i < 2; ++i) {
      out[i] = offsets[i] + signs[i] * kTurn * counts[ports[i]] / counts_per_turn;
    }
    return out;
  }

  /// Of the motors, τ = Jᵀ F; where one exceeds max_torque both are scaled by one factor.
  bool drive(const Joints& joints, const Vec3& F_B, std::array<int16_t, 3>& motors,
             bool& clipped) const {
    std::array<Vec3, 2> J;
    if (!pantograph_jacobian(geometry, joints.angles, joints.p_B, J)) return false;
    std::array<double, 2> torques;
    for (size_t i = 0; i < 2; ++i) torques[i] = signs[i] * dot(J[i], F_B) / reduction;
    const double largest = std::max(std::fabs(torques[0]), std::fabs(torques[1]));
    clipped = largest > max_torque;
    const double share = clipped ? max_torque / largest : 1;
    for (size_t i = 0; i < 2; ++i) {
      motors[ports[i]] = static_cast<int16_t>(std::lround(share * torques[i] / kHaplyTorqueUnit));
    }
    return true;
  }
};

}  // namespace

ThreeMotorArm haply_arm(const PantographConfig& config) {
  const WiredPantograph wired(config);
  const auto joints = std::make_shared<Joints>();  // of the last sample
  const double most = kMostAcceleration / config.proximal * config.counts_per_turn / kTurn * 1e-18;
  ThreeMotorArm arm;
  arm.name = "Haply 2-DoF board with a pantograph";
  arm.axes = 2;
  arm.max_force = kHaplyMaxForce;
  arm.velocity_cutoff = config.velocity_cutoff;
  arm.most_acceleration = {most, most};
  arm.place = [wired, joints](const MotorCounts& counts, bool, Vec3& p_B) {
    const PantographAngles angles = wired.angles(counts);
    if (!find_pantograph_handle(wired.geometry, angles, p_B)) return false;
    *joints = {angles, p_B};
    return true;
  };
  arm.drive = [wired, joints](const Vec3& F_B, std::array<int16_t, 3>& motors, bool& clipped) {
    return wired.drive(*joints, F_B, motors, clipped);
  };
  arm.is_homed = [](uint8_t) { return true; };
  arm.buttons = [](uint8_t) { return 0u; };
  arm.command_flags = [](bool) { return uint8_t{0}; };
  arm.release = zero_force();
  return arm;
}

Haply::Haply(const DeviceConfig& config, FileDescriptor node)
    : mailbox_(std::make_shared<MotorMailbox>()),
      line_(std::make_shared<HaplyLine>(std::string(view(config.serial.path)), std::move(node),
                                        *mailbox_)),
      driver_(std::make_unique<ThreeMotorDevice>(
          haply_arm(config.pantograph), config, mailbox_,
          MotorLink{line_, [line = line_.get()] { line->stop(); }})) {}

std::string Haply::description() const {
  return driver_->description() +
         (line_->is_new() ? ", counting from where its handle is now, which must be its home"
                          : ", counting on from an earlier session") +
         "; force out of its plane is dropped";
}

bool Haply::read(const TickTime& tick, DeviceState& state) {
  now_ns_ = tick.now_ns;
  line_->hear(tick.now_ns);
  return driver_->read(tick, state);
}

void Haply::write(const Wrench& F_B) {
  driver_->write(F_B);
  line_->say(now_ns_);
}

std::unique_ptr<Device> open_haply(const DeviceConfig& config, FileDescriptor node) {
  if (!node.is_open()) node = open_serial_port(std::string(view(config.serial.path)));
  return std::make_unique<Haply>(config, std::move(node));
}

}  // namespace haptic
