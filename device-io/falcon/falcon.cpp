// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/falcon/falcon.h"

#include <algorithm>
#include <utility>

#include "device-io/falcon/kinematics.h"
#include "device-io/falcon/packet.h"
#include "device-io/falcon/usb_link.h"

namespace haptic {
namespace {

constexpr uint8_t kReadyLight = 0x02;  // green in the firmware that libnifalcon describes
// 100 m/s² at the handle, where a count is at least 10 µm [counts/ns²]
constexpr double kMostAcceleration = 100 / 10e-6 * 1e-18;

DeviceRelease zero_force() {
  const FalconBytes zero = encode_falcon({{}, kFalconHoming});
  DeviceRelease release{};
  release.by = static_cast<uint32_t>(ReleaseBy::kUsbBulk);
  release.interface = kFalconInterface;
  release.endpoint = kFalconOut;
  release.size = zero.size();
  std::copy(zero.begin(), zero.end(), release.bytes.begin());
  return release;
}

}  // namespace

ThreeMotorArm falcon_arm(const FalconConfig& config) {
  const FalconGeometry geometry;
  const auto pose = std::make_shared<FalconPose>();  // of the last sample
  ThreeMotorArm arm;
  arm.name = "Novint Falcon";
  arm.max_force = kFalconMaxForce;
  arm.velocity_cutoff = config.velocity_cutoff;
  arm.most_acceleration = {kMostAcceleration, kMostAcceleration, kMostAcceleration};
  arm.place = [geometry, pose](const MotorCounts& counts, bool follows, Vec3& p_B) {
    const Vec3 angles{falcon_angle(geometry, counts[0]), falcon_angle(geometry, counts[1]),
                      falcon_angle(geometry, counts[2])};
    Vec3 p = follows ? p_B : Vec3{};
    if (!find_falcon_handle(geometry, angles, p) || !solve_falcon(geometry, p, *pose)) {
      return false;
    }
    p_B = p;
    return true;
  };
  arm.drive = [pose](const Vec3& F_B, std::array<int16_t, 3>& motors, bool& clipped) {
    Vec3 torques;
    if (!falcon_torques(*pose, F_B, torques)) return false;
    motors = falcon_words({torques.x, torques.y, torques.z}, clipped);
    return true;
  };
  arm.is_homed = [](uint8_t flags) { return (flags & kFalconLegs) == kFalconLegs; };
  arm.buttons = [](uint8_t flags) { return uint32_t{flags} & kFalconButtons; };
  arm.command_flags = [](bool ready) -> uint8_t {
    return ready ? kFalconHoming | kReadyLight : kFalconHoming;
  };
  arm.not_homed = "pull its grip fully out, then push it fully in";
  arm.release = zero_force();
  return arm;
}

std::unique_ptr<Device> open_falcon(const DeviceConfig& config, FileDescriptor node) {
  auto mailbox = std::make_shared<MotorMailbox>();
  auto link = std::make_shared<FalconLink>(config, std::move(node), *mailbox);
  FalconLink* const thread = link.get();
  return std::make_unique<ThreeMotorDevice>(
      falcon_arm(config.falcon), config, mailbox,
      MotorLink{std::move(link), [thread] { thread->stop(); }, &thread->tap()});
}

}  // namespace haptic
