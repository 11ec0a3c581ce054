// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/falcon/falcon.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "device-io/falcon/usb_link.h"
#include "device-io/sensing/handle_velocity.h"
#include "proto/math/assert.h"

namespace haptic {
namespace {

constexpr int64_t kSilenceNs = 20'000'000;  // without an answer the device is lost
constexpr uint8_t kReadyLight = 0x02;       // green in the firmware that libnifalcon describes
// 100 m/s² at the handle, where a count is at least 21 µm [counts/ns²]
constexpr double kMostAcceleration = 100 / 21e-6 * 1e-18;

}  // namespace

Falcon::Falcon(const DeviceConfig& config, std::unique_ptr<MotorMailbox> mailbox,
               std::unique_ptr<FalconLink> link)
    : max_force_(std::min(config.max_force, kMaxForce)),
      velocity_cutoff_(config.falcon.velocity_cutoff),
      mailbox_(std::move(mailbox)),
      link_(std::move(link)),
      noise_({kMostAcceleration, kMostAcceleration, kMostAcceleration}) {
  HAPTIC_ASSERT(mailbox_ && velocity_cutoff_ > 0);
}

Falcon::~Falcon() = default;

DeviceCaps Falcon::caps() const {
  return {.max_force = max_force_, .max_torque = 0};
}

std::string Falcon::description() const {
  const std::optional<MotorSample> sample = mailbox_->newest();
  const bool homed = sample && (sample->flags & kFalconLegs) == kFalconLegs;
  return std::string("Novint Falcon, 3 axes, ") +
         (homed ? "homed" : "NOT HOMED: pull its grip fully out, push it fully in");
}

/// The counts, unwrapped; false: the same sample as before.
bool Falcon::take(const MotorSample& sample) {
  if (sampled_ && sample.number == number_) return false;
  number_ = sample.number;
  heard_ns_ = sample.heard_ns;
  flags_ = sample.flags;
  for (size_t i = 0; i < sample.counts.size(); ++i) {
    // the shorter way round: no leg turns by half of the 16 bits within a tick
    const auto step = static_cast<int16_t>(sample.counts[i] - counts_[i]);
    counts_[i] = sampled_ && reachable_ ? counts_[i] + step : sample.counts[i];
  }
  return true;
}

void Falcon::move_to(const MotorSample& sample) {
  const Pose before_B = last_.X_BH;
  const double dt = 1e-9 * static_cast<double>(sample.asked_ns - last_.t_ns);
  const bool follows = sampled_ && reachable_ && dt > 0;
  const Vec3 angles{falcon_angle(geometry_, counts_[0]), falcon_angle(geometry_, counts_[1]),
                    falcon_angle(geometry_, counts_[2])};
  sampled_ = true;
  Vec3 p_B = follows ? before_B.p : Vec3{};
  reachable_ = find_falcon_handle(geometry_, angles, p_B) && solve_falcon(geometry_, p_B, pose_);
  last_.t_ns = sample.asked_ns;
  if (!reachable_) return;
  last_.X_BH.p = p_B;
  if (follows) {
    low_pass_velocity(before_B, last_.X_BH, dt, velocity_cutoff_, last_.V_BH);
  } else {
    last_.V_BH = {};
    noise_.restart();
  }
  noise_.add(counts_, sample.asked_ns, sample.heard_ns);
}

uint32_t Falcon::flags(bool fresh, int64_t t_ns) const {
  uint32_t flags = fresh ? kDeviceFresh : kDeviceHeld;
  if (mailbox_->is_gone() || !sampled_ || t_ns - heard_ns_ > kSilenceNs) flags |= kDeviceLost;
  // where no place of the handle fits the counts, they are not those of a homed device
  if ((flags_ & kFalconLegs) == kFalconLegs && reachable_) flags |= kDeviceHomed;
  if (mailbox_->is_stale()) flags |= kDeviceStale;
  if (noise_.is_noisy()) flags |= kDeviceNoisy;
  if (saturated_) flags |= kDeviceSaturated;
  return flags;
}

bool Falcon::read(const TickTime& tick, DeviceState& state) {
  now_ns_ = tick.now_ns;
  const std::optional<MotorSample> sample = mailbox_->newest();
  const bool fresh = sample && take(*sample);
  if (fresh) move_to(*sample);
  last_.buttons = flags_ & kFalconButtons;
  last_.flags = flags(fresh, tick.now_ns);
  state = last_;
  return fresh;
}

void Falcon::write(const Wrench& F_B) {
  MotorCommand command;
  const bool ready = (last_.flags & (kDeviceLost | kDeviceHomed)) == kDeviceHomed;
  command.flags = ready ? kFalconHoming | kReadyLight : kFalconHoming;
  Vec3 force_B = F_B.f;
  saturated_ = !is_finite(force_B);
  if (saturated_ || !ready) force_B = {};
  const double size = norm(force_B);
  saturated_ |= size > max_force_;
  if (size > max_force_) force_B = max_force_ / size * force_B;
  Vec3 torques;
  const bool regular = falcon_torques(pose_, force_B, torques);
  bool clipped = false;
  if (regular) command.motors = falcon_words({torques.x, torques.y, torques.z}, clipped);
  saturated_ |= clipped || (size > 0 && !regular);
  mailbox_->post(command, now_ns_);
}

void Falcon::stop() {
  write({});
  if (link_) link_->stop();
}

DeviceRelease Falcon::release() const {
  const FalconBytes zero = encode_falcon({{}, kFalconHoming});
  DeviceRelease release{};
  release.by = static_cast<uint32_t>(ReleaseBy::kUsbBulk);
  release.interface = kFalconInterface;
  release.endpoint = kFalconOut;
  release.size = zero.size();
  std::copy(zero.begin(), zero.end(), release.bytes.begin());
  return release;
}

std::unique_ptr<Device> open_falcon(const DeviceConfig& config, FileDescriptor node) {
  auto mailbox = std::make_unique<MotorMailbox>();
  auto link = std::make_unique<FalconLink>(config, std::move(node), *mailbox);
  return std::make_unique<Falcon>(config, std::move(mailbox), std::move(link));
}

}  // namespace haptic
