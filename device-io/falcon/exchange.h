// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "device-io/falcon/packet.h"
#include "device-io/motors/motor_mailbox.h"
#include "device-io/sensing/trust.h"

namespace haptic {

/// The chip of FTDI before the device puts two bytes of modem status before the payload of every
/// packet, and sends them alone where there is nothing.
inline constexpr size_t kModemStatus = 2;
inline constexpr size_t kFtdiPacket = 64;

/// The state of the line to a Falcon: whose turn it is, and how many answers may still come. The
/// states and what leads from one to another:
///
///   state        ask          answer, of all / of some      distrust  brought up
///   kFree        kAsked       kHushed: one too many         kHushed   kFree
///   kAsked       kAskedAgain  kFree                         kHushed   kFree
///   kAskedAgain  kAskedAgain  kFree / kDraining             kHushed   kFree
///   kDraining    kAsked       kFree / kDraining             kHushed   kFree
///   kHushed      kAsked       kHushed: one too many         kHushed   kFree
struct FalconTurn {
  enum class State {
    kFree,        // nothing is under way: the next question at once
    kAsked,       // one question is
    kAskedAgain,  // several are, for none was answered in time
    kDraining,    // some of several are answered; a silence shows that no more will be
    kHushed,      // of what comes nothing is believed; asked again only after a silence
  };
  enum class Event { kAsk, kAnswer, kDistrust, kBroughtUp };

  State state = State::kFree;
  int owed = 0;  // answers that may still come

  FalconTurn after(Event event) const noexcept;
};

/// The exchange with a running Falcon: one question, one answer, then the next question at once.
/// Bytes in, bytes out, no clock of its own.
///
/// A question that is not answered within kAskAgainNs is asked again, then each time after twice as
/// long, but for the first that tells the motors zero; its answer may still come, and counts as one
/// to either.
///
/// Answers carry no number, so two things show that they are old. The firmware answers each
/// question once: one too many means that old ones were queued somewhere; then samples are withheld
/// until the line has been silent for kQuietNs. And from time to time a question is a *challenge*:
/// it takes homing back, and an honest answer to it, and to no other, has no homed bits. A firmware
/// that repeats itself, or answers from a queue, misses four challenges, or meets none for a
/// second, and is stale until it has met sixteen. After a miss the line is left silent, longer each
/// time, since an answer may have come so late that it was taken for that of the next question.
/// While questions had to be asked again, or the chip's packets came late, misses do not count: a
/// busy machine is no lie. Whether a firmware obeys is tried once it is homed; one that does not is
/// not challenged. The zero of its encoders is not touched: programs switch homing on and off with
/// a homed device.
class FalconExchange {
 public:
  explicit FalconExchange(MotorMailbox& mailbox) : mailbox_(mailbox) {}

  /// True if a question is due: the last one is answered, or has waited long enough.
  bool may_ask(int64_t t_ns) const noexcept;
  /// The next question, from the servo's newest command.
  FalconBytes ask(int64_t t_ns) noexcept;
  /// Transfers were cancelled: somebody else may have asked, so that surplus answers are no
  /// evidence for a while. The next question waits until the line is silent.
  void begin_anew(int64_t t_ns) noexcept;
  /// The firmware was brought up anew: nothing is under way, and what was homed before counts no
  /// longer. What is known of its manners stays.
  void restart() noexcept;
  /// A packet of the chip, at most kFtdiPacket bytes, its status included.
  void hear(std::span<const uint8_t> packet, int64_t t_ns) noexcept;

  /// Answers too many.
  uint64_t surplus() const noexcept { return surplus_; }
  int64_t answered_ns() const noexcept { return answered_ns_; }
  /// The firmware obeys challenges.
  bool is_challenged() const noexcept { return challenges_.manners == Manners::kObeys; }

  static constexpr int64_t kAskAgainNs = 5'000'000;  // an answer takes 1 ms; the rest is the bus
  static constexpr int64_t kAskAgainMostNs = 80'000'000;
  static constexpr int64_t kQuietNs = 5'000'000;            // old answers come within a millisecond
  static constexpr int kFewestApart = 16, kMostApart = 31;  // questions between challenges
  static constexpr int kMostDoubt = 16;  // challenges to be met by one that was not believed

 private:
  using Event = FalconTurn::Event;
  using State = FalconTurn::State;
  enum class Manners { kUnknown, kObeys, kIgnores };

  /// The manners of the firmware, as challenges show them.
  struct Challenges {
    Manners manners = Manners::kUnknown;
    bool is_one = false;  // the last question
    int tried = 0;        // before the manners are known
    int until_next = 0;   // questions
    uint32_t random = 1;
    int64_t met_ns = 0;               // the last that was met
    int64_t quiet_ns = kQuietNs / 2;  // twice that after the next that is missed
  };

  bool take(MotorSample& answer, int64_t t_ns) noexcept;
  void judge_challenge(bool met, int64_t t_ns) noexcept;
  void doubt(int weight) noexcept;
  bool is_challenge_due() noexcept;

  MotorMailbox& mailbox_;
  FalconReader reader_;
  FalconTurn turn_;
  Challenges challenges_;
  Trust trust_{kMostDoubt};
  MotorCommand told_;  // with the last question
  uint8_t legs_ = 0;   // homed, by the last answer that was not to a challenge
  uint64_t answered_ = 0, surplus_ = 0;
  int64_t patience_ns_ = kAskAgainNs;
  int64_t asked_ns_ = 0, first_asked_ns_ = 0;  // the last question; the first of those under way
  int64_t answered_ns_ = 0, heard_ns_ = 0, packet_ns_ = 0;  // answer, payload, packet
  int64_t excused_ns_ = 0;  // until then answers too many and misses are no lie
  int64_t busy_ns_ = 0;     // until then misses are none
};

}  // namespace haptic
