// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "device-io/motors/arm_device.h"
#include "device-io/motors/serial_line.h"
#include "device-io/woodenhaptics/answer_match.h"
#include "device-io/woodenhaptics/protocol.h"
#include "proto/wire/wire.h"

namespace haptic {

/// The host's side of the conversation of protocol.h, on a serial node. One line (sometimes with a
/// challenge before it: AnswerMatch) is under way at a time, sent by say() and answered before the
/// next hear().
///
/// Lost, with zero currents whatever say() is given: after kDeviceSilenceNs without a valid answer,
/// until the next one; after a pause in which the firmware has switched the motors off; permanently
/// when the node hangs up. An answer that does not match is not valid. Stale if answers came but
/// none has matched for kDeviceSilenceNs, or if there are surplus answers; until the device has
/// recovered. Not homed while the firmware waits for its calibration button, since its positions
/// are then invented.
class MotorLine {
 public:
  /// Takes the open node and waits until the device answers as this arm. Throws DeviceError if it
  /// does not within two seconds, std::runtime_error if it is another model.
  MotorLine(const Arm& arm, const std::string& path, FileDescriptor node);

  /// Takes what has come up to now: at most 1 KiB; the newest valid answer counts.
  std::optional<ArmSample> hear(int64_t now_ns);

  /// True if a line may be sent: none is under way, or it is older than 5 ms, doubled after each
  /// lost line up to 100 ms: the firmware would drop both. The first zero after a loss is not put
  /// off by that doubling.
  bool may_say() const;
  /// Sends these currents, or those that the state of the line demands. Call it if may_say().
  void say(Milliamperes currents);

  /// Sends zero until it is confirmed, for at most 40 ms.
  void stop();
  /// The bytes of that.
  DeviceRelease release() const;

  /// Counts of the first answer; zero if it was invented.
  const MotorCounts& home() const { return home_; }
  bool is_homed() const { return homed_; }
  /// The bits of DeviceFlag that it knows: homed, lost, stale.
  uint32_t flags() const;

  /// Invalid answers and answers with an error.
  uint64_t rejected() const { return reader_.rejected() + errors_; }
  /// Currents of the last line sent [mA].
  const Milliamperes& currents() const { return currents_; }

 private:
  void greet(const std::string& path);
  bool wait_for_answer(int64_t until_ns, EncoderReply& newest);
  bool ask(const Milliamperes& currents, bool may_challenge);
  bool receive(EncoderReply& newest);
  bool is_this_arm(const EncoderReply& reply) const;
  bool is_plausible(const EncoderReply& reply) const;
  bool accept(const EncoderReply& reply);
  bool is_stale() const;

  const Arm& arm_;
  SerialLine line_;
  ReplyReader reader_;
  AnswerMatch match_;
  MotorCounts home_{};
  Milliamperes currents_{};
  int64_t now_ns_ = 0;          // of the last hear()
  int64_t asked_ns_ = 0;        // of the line under way
  int64_t first_asked_ns_ = 0;  // of the first unanswered line
  int64_t answered_ns_ = 0;     // of the hear() that last found a valid answer
  int64_t doubted_ns_ = 0;      // of the first mismatched one since then; 0: none
  int64_t excused_ns_ = 0;      // until then answers may belong to lines sent by hapticd
  int64_t patience_ns_ = 0;     // for the line under way
  uint64_t errors_ = 0;
  uint32_t probe_ = 0;  // number of questions asked while not homed
  bool heard_ = false;  // an answer has come since the line under way was sent
  bool awaiting_ = false, started_ = false, sampled_ = false;
  bool homed_ = false, lost_ = false;
  bool returning_ = false;  // lost, but it has answered once since
};

}  // namespace haptic
