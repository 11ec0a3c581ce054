// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <string>

#include "device-io/device.h"
#include "device-io/woodenhaptics/answer_match.h"
#include "device-io/woodenhaptics/encoder_noise.h"
#include "device-io/woodenhaptics/kinematics.h"
#include "device-io/woodenhaptics/protocol.h"

namespace haptic {

/// Silence after which a device counts as lost until it answers again [ns]
/// (docs/decisions/0004-a-device-may-be-silent-for-20-ms.md).
inline constexpr int64_t kDeviceSilenceNs = 20'000'000;

/// A WoodenHaptics on a serial node: three sensed and three driven axes, no orientation, no
/// buttons. One line (sometimes with a challenge before it: AnswerMatch) is under way at a time,
/// sent by write() and answered before the next read(), so a sample is one tick old: t_ns is the
/// instant of the write that asked for it. The loop thus has one tick of delay in addition to the
/// hold: a wall is stable for K < (b + B)/(3T/2).
///
/// Pose: tip_position, identity orientation; velocity: backward difference over the time between
/// samples through one pole. Force: motor_currents at the pose of the last sample, at the tip; the
/// whole vector is scaled down if it exceeds max_force or a motor exceeds max_current; one that is
/// not finite is sent as zero; both set kDeviceSaturated in the next state.
///
/// Lost, with zero force whatever write() is given: after kDeviceSilenceNs without a valid answer,
/// until the next one; after a pause of write() in which the firmware has switched the motors off;
/// permanently when the node hangs up. An answer that does not match is not valid. kDeviceStale if
/// answers came but none has matched for kDeviceSilenceNs, or if there are surplus answers;
/// kDeviceNoisy by EncoderNoise; both until the device has recovered. Not homed while the firmware
/// waits for its calibration button, since its positions are then invented.
class WoodenHaptics final : public Device {
 public:
  /// Takes the open node and waits until the device answers. Throws DeviceError if it does not
  /// within two seconds, std::runtime_error if it is another model.
  WoodenHaptics(const DeviceConfig& config, FileDescriptor node);

  DeviceCaps caps() const override;
  std::string description() const override;
  /// Reads at most 1 KiB; the newest answer counts.
  bool read(const TickTime& tick, DeviceState& state) override;
  /// Sends nothing while the last line is unanswered and younger than 5 ms, doubled after each lost
  /// line up to 100 ms: the firmware would drop both.
  void write(const Wrench& F_B) override;
  void stop() override;
  DeviceRelease release() const override;

  /// Invalid answers and answers with an error.
  uint64_t rejected() const { return reader_.rejected() + errors_; }
  /// Currents of the last line sent [mA].
  const Milliamperes& currents() const { return currents_; }

 private:
  void hang_up();
  bool ask(const Milliamperes& currents, bool may_challenge);
  bool receive(EncoderReply& newest);
  bool wait_for_answer(int64_t until_ns, EncoderReply& newest);
  void greet(const std::string& path);
  bool accept(const EncoderReply& reply);
  bool is_stale() const;
  void move_to(const MotorCounts& counts);
  Milliamperes currents_for(const Vec3& force_B);

  WoodenHapticsGeometry geometry_;
  double max_force_, max_current_, velocity_cutoff_;
  FileDescriptor node_;
  ReplyReader reader_;
  AnswerMatch match_;
  EncoderNoise noise_;
  Milliamperes currents_{};
  Vec3 joint_angles_;
  DeviceState last_{};
  int64_t now_ns_ = 0;          // of the last read
  int64_t asked_ns_ = 0;        // of the line under way
  int64_t first_asked_ns_ = 0;  // of the first unanswered line
  int64_t answered_ns_ = 0;     // of the read that last found a valid answer
  int64_t doubted_ns_ = 0;      // of the first mismatched read since then; 0: none
  int64_t excused_ns_ = 0;      // until then answers may belong to lines sent by hapticd
  int64_t patience_ns_ = 0;     // for the line under way
  uint64_t errors_ = 0;
  uint32_t probe_ = 0;  // number of questions asked while not homed
  bool heard_ = false;  // an answer has come since the line under way was sent
  bool awaiting_ = false, started_ = false, moved_ = false, saturated_ = false;
  bool homed_ = false, lost_ = false, gone_ = false;
  bool returning_ = false;  // lost, but it has answered once since
};

}  // namespace haptic
