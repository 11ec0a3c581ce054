// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/woodenhaptics/motor_line.h"

#include <algorithm>
#include <cstdlib>
#include <span>
#include <stdexcept>
#include <utility>

#include "proto/ipc/process.h"
#include "proto/math/assert.h"
#include "proto/math/units.h"
#include "proto/os/realtime.h"

namespace haptic {
namespace {

constexpr int64_t kAskAgainNs = 5 * kMs;        // an answer later than this is lost
constexpr int64_t kAskAgainMostNs = 100 * kMs;  // for a silent device, which has to read them all
constexpr int64_t kLetGoNs = kFirmwareWatchdogNs - 10 * kMs;  // margin: a line may be under way
constexpr int64_t kQuietNs = 2 * kMs;       // all errors of colliding lines are in
constexpr int64_t kHeldUpNs = 5 * kMs;      // after it hapticd may have released the device
constexpr int64_t kExcusedNs = 30 * kMs;    // its four lines, 5 ms apart, and their answers
constexpr int32_t kMostCounts = 1'000'000;  // thirty turns of a body: noise, no arm

/// True if a firmware may report this of its first encoder before the button is pressed.
bool may_be_invented(int32_t count) {
  return std::abs(count - kSineMiddle) <= kSineAmplitude;
}

std::span<const uint8_t> bytes_of(const CommandText& command) {
  return {reinterpret_cast<const uint8_t*>(command.text.data()), command.size};
}

/// A firmware may report anything for encoders that are not there.
MotorCounts counts_of(const EncoderReply& reply, size_t encoders) {
  MotorCounts counts{};
  std::copy_n(reply.counts.begin(), encoders, counts.begin());
  return counts;
}

}  // namespace

MotorLine::MotorLine(const Arm& arm, const std::string& path, FileDescriptor node)
    : arm_(arm), line_(std::move(node)) {
  greet(path);
}

bool MotorLine::is_this_arm(const EncoderReply& reply) const {
  return model_of(reply) == arm_.model && buttons_of(reply) >> arm_.buttons == 0;
}

bool MotorLine::is_plausible(const EncoderReply& reply) const {
  return is_this_arm(reply) && std::all_of(reply.counts.begin(), reply.counts.end(), [](int32_t n) {
           return n >= -kMostCounts && n <= kMostCounts;
         });
}

/// Waits for the first answer, before anything is real time.
void MotorLine::greet(const std::string& path) {
  EncoderReply reply;
  const int64_t give_up_ns = haptic::now_ns() + SerialLine::kGreetingNs;
  while (line_.is_open() && haptic::now_ns() < give_up_ns) {
    ask({}, false);
    // an error here is a remnant of an earlier program
    if (!wait_for_answer(haptic::now_ns() + SerialLine::kRoundNs, reply) || reply.error != 0)
      continue;
    if (!is_this_arm(reply)) {
      throw std::runtime_error(path + ": answers as model " + std::to_string(reply.model) +
                               ", not " + std::to_string(arm_.model) + " (" + arm_.name +
                               "); set 'path' in [device.serial] to the right node");
    }
    if (!is_plausible(reply)) continue;
    homed_ = !may_be_invented(reply.counts[0]);
    if (homed_) home_ = counts_of(reply, arm_.encoders);
    return;
  }
  throw DeviceError(path + (line_.is_open() ? ": no answer within 2 s" : ": hung up") +
                    "; check that it is a " + arm_.name +
                    " with its firmware, plug it out and in again");
}

bool MotorLine::wait_for_answer(int64_t until_ns, EncoderReply& newest) {
  while (line_.is_open()) {
    if (receive(newest)) return true;
    if (!line_.wait(until_ns)) return false;
  }
  return false;
}

/// Takes the newest answer to a question; false if none has come. Bounded work.
bool MotorLine::receive(EncoderReply& newest) {
  bool any = false, heard = false;
  EncoderReply reply;
  line_.hear([&](std::span<const uint8_t> bytes) {
    for (const uint8_t byte : bytes) {
      if (!reader_.push(static_cast<char>(byte), reply)) continue;
      heard = true;
      any = !match_.hear(reply.error, now_ns_ < excused_ns_);
      if (any) newest = reply;
    }
  });
  if (heard) patience_ns_ = kAskAgainNs;
  heard_ |= heard;
  if (any && !match_.awaits_echo()) awaiting_ = false;
  return any;
}

/// True if this answer gives the present position of the arm.
bool MotorLine::accept(const EncoderReply& reply) {
  if (reply.error != 0 || !is_plausible(reply)) {
    ++errors_;
    return false;
  }
  // a firmware that waits for its button repeats the current it was sent
  if (!homed_) homed_ = !(may_be_invented(reply.counts[0]) && reply.counts[1] == currents_[0]);
  if (homed_ && !match_.is_settled()) {
    if (doubted_ns_ == 0) doubted_ns_ = now_ns_;
    return false;
  }
  doubted_ns_ = 0;
  answered_ns_ = now_ns_;
  return homed_;
}

bool MotorLine::is_stale() const {
  return match_.is_distrusted() || (doubted_ns_ != 0 && now_ns_ - doubted_ns_ > kDeviceSilenceNs);
}

uint32_t MotorLine::flags() const {
  const auto flag = [](bool holds, DeviceFlag which) { return holds ? uint32_t{which} : 0; };
  return flag(homed_, kDeviceHomed) | flag(lost_, kDeviceLost) | flag(is_stale(), kDeviceStale);
}

std::optional<ArmSample> MotorLine::hear(int64_t now_ns) {
  if (started_ && now_ns - now_ns_ > kHeldUpNs) {
    excused_ns_ = now_ns + kExcusedNs;
    doubted_ns_ = 0;
  }
  now_ns_ = now_ns;
  if (!started_) answered_ns_ = now_ns;
  started_ = true;
  EncoderReply reply;
  const bool answered = receive(reply) && accept(reply);
  // after a silence the first answer may be to an old line; the next is to a zero, so the motors
  // hold zero when the force returns
  const bool fresh = answered && (!lost_ || returning_);
  returning_ = lost_ && !fresh && (returning_ || answered) && match_.is_settled();
  std::optional<ArmSample> sample;
  if (fresh) {
    sample = ArmSample{counts_of(reply, arm_.encoders),
                       buttons_of(reply),
                       first_asked_ns_,
                       asked_ns_,
                       now_ns,
                       sampled_ && !lost_};
    sampled_ = true;
  }
  const bool silent = now_ns - answered_ns_ > kDeviceSilenceNs;
  // after such a delay the firmware has switched the motors off: no step back to full force
  const bool let_go = sampled_ && now_ns - asked_ns_ > kLetGoNs;
  lost_ = silent || !line_.is_open() || let_go || returning_;
  return sample;
}

bool MotorLine::may_say() const {
  const bool owes_zero = lost_ && homed_ && currents_ != Milliamperes{};
  const int64_t patience_ns = owes_zero ? std::min(patience_ns_, kAskAgainNs) : patience_ns_;
  return line_.is_open() && !(awaiting_ && now_ns_ - asked_ns_ < patience_ns);
}

void MotorLine::say(Milliamperes currents) {
  patience_ns_ = awaiting_ ? std::min(2 * patience_ns_, kAskAgainMostNs) : kAskAgainNs;
  // a zero is then the last of the waiting lines, of which the firmware obeys at most the last
  if (lost_) currents = {};
  // an encoder is unlikely to repeat this number twice; the motors are off, and it is at most 13 mN
  if (!homed_) currents = {static_cast<int32_t>(1 + ++probe_ % 7)};
  // no challenge to a silent device, which must find a zero when it wakes, nor before that zero is
  // answered
  ask(currents, homed_ && !returning_ && (!awaiting_ || heard_));
}

bool MotorLine::ask(const Milliamperes& currents, bool may_challenge) {
  const CommandText command = encode_currents(currents, match_.ask(may_challenge), arm_.motors);
  heard_ = false;
  const size_t n = line_.say(bytes_of(command));
  // while one is unanswered, the next answer may be to either question
  if (!awaiting_) first_asked_ns_ = now_ns_;
  // a line truncated by a full queue is dropped by the firmware, as if never sent
  awaiting_ = n > 0;
  asked_ns_ = now_ns_;
  if (n != command.size) return false;
  currents_ = currents;
  return true;
}

/// Colliding lines are dropped and answered with errors: waits for what is under way, then sends
/// zero until it is confirmed.
void MotorLine::stop() {
  EncoderReply reply;
  const int64_t give_up_ns = haptic::now_ns() + SerialLine::kStopNs;
  const auto wait = [&](int64_t patience_ns) {
    return wait_for_answer(std::min(haptic::now_ns() + patience_ns, give_up_ns), reply);
  };
  if (awaiting_) wait(SerialLine::kStopWaitNs);
  do {
    ask({}, false);
    if (wait(SerialLine::kStopWaitNs) && reply.error == 0) return;
    while (wait(kQuietNs)) {
    }
  } while (line_.is_open() && haptic::now_ns() < give_up_ns);
}

DeviceRelease MotorLine::release() const {
  const CommandText zero = encode_currents({}, Challenge::kNone, arm_.motors);
  return release_by(ReleaseBy::kWrite, bytes_of(zero));
}

}  // namespace haptic
