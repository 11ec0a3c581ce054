// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/woodenhaptics/woodenhaptics.h"

#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "proto/config/devices.h"
#include "proto/ipc/process.h"
#include "proto/math/assert.h"
#include "proto/os/realtime.h"
#include "proto/os/serial_port.h"

namespace haptic {
namespace {

constexpr double kMaxForce = 5;  // [N], limit of the design
constexpr int64_t kMs = 1'000'000;
constexpr int64_t kAskAgainNs = 5 * kMs;        // an answer later than this is lost
constexpr int64_t kAskAgainMostNs = 100 * kMs;  // for a silent device, which has to read them all
constexpr int64_t kLetGoNs = kFirmwareWatchdogNs - 10 * kMs;  // margin: a line may be under way
constexpr int64_t kGreetingNs = 2000 * kMs;                   // limit for the first answer
constexpr int64_t kGreetingRoundNs = 50 * kMs;                // per attempt
constexpr int64_t kStopNs = 40 * kMs;                         // within which zero force is promised
constexpr int64_t kStopWaitNs = 5 * kMs;                      // per attempt
constexpr int64_t kQuietNs = 2 * kMs;  // all errors of colliding lines are in
constexpr int kReadsPerTick = 4;       // together at most 1 KiB: bounded work
constexpr size_t kBytesPerRead = 256;
constexpr int64_t kHeldUpNs = 5 * kMs;      // after it hapticd may have released the device
constexpr int64_t kExcusedNs = 30 * kMs;    // its four lines, 5 ms apart, and their answers
constexpr int32_t kMostCounts = 1'000'000;  // thirty turns of a body: noise, no arm

bool is_plausible(const EncoderReply& reply) {
  return reply.model == kWoodenHapticsModel &&
         std::all_of(reply.counts.begin(), reply.counts.end(),
                     [](int32_t n) { return n >= -kMostCounts && n <= kMostCounts; });
}

/// Whether the first encoder may report this before the calibration button is pressed.
bool may_be_invented(int32_t count) {
  return std::abs(count - kSineMiddle) <= kSineAmplitude;
}

}  // namespace

WoodenHaptics::WoodenHaptics(const DeviceConfig& config, FileDescriptor node)
    : max_force_(std::min(config.max_force, kMaxForce)),
      max_current_(config.serial.max_current),
      velocity_cutoff_(config.serial.velocity_cutoff),
      node_(std::move(node)) {
  HAPTIC_ASSERT(max_current_ > 0 && velocity_cutoff_ > 0);
  greet(std::string(view(config.serial.path)));
}

DeviceCaps WoodenHaptics::caps() const {
  return {.max_force = max_force_, .max_torque = 0, .open_loop = false, .simulated = false};
}

std::string WoodenHaptics::description() const {
  return "WoodenHaptics (Teensy, model 3), 3 axes, " +
         std::string(homed_ ? "homed" : "NOT HOMED: rest the arm at home, press its button");
}

/// Waits for the first answer, before anything is real time.
void WoodenHaptics::greet(const std::string& path) {
  EncoderReply reply;
  const int64_t give_up_ns = now_ns() + kGreetingNs;
  while (!gone_ && now_ns() < give_up_ns) {
    ask({}, false);
    // an error here is a remnant of an earlier program
    if (!wait_for_answer(now_ns() + kGreetingRoundNs, reply) || reply.error != 0) continue;
    if (reply.model != kWoodenHapticsModel) {
      throw std::runtime_error(path + ": answers as model " + std::to_string(reply.model) +
                               ", not 3 (WoodenHaptics); set 'path' in [device.serial] to the "
                               "right node");
    }
    if (!is_plausible(reply)) continue;
    homed_ = !may_be_invented(reply.counts[0]);
    move_to(homed_ ? MotorCounts{reply.counts[0], reply.counts[1], reply.counts[2]}
                   : MotorCounts{});
    last_.V_BH = {};
    last_.flags = kDeviceHeld | (homed_ ? uint32_t{kDeviceHomed} : 0);
    return;
  }
  throw DeviceError(path + (gone_ ? ": hung up" : ": no answer within 2 s") +
                    "; check that it is a WoodenHaptics with the Teensy firmware, plug it "
                    "out and in again");
}

bool WoodenHaptics::wait_for_answer(int64_t until_ns, EncoderReply& newest) {
  while (!gone_) {
    if (receive(newest)) return true;
    const int64_t left_ns = until_ns - now_ns();
    if (left_ns <= 0) return false;
    pollfd waiting{node_.get(), POLLIN, 0};
    poll(&waiting, 1, static_cast<int>((left_ns + kMs - 1) / kMs));
  }
  return false;
}

/// Closes the node: its name is free for the device's return only when nobody holds it open.
void WoodenHaptics::hang_up() {
  gone_ = true;
  node_.reset();
}

/// Takes the newest answer to a question; false if none has come. Bounded work.
bool WoodenHaptics::receive(EncoderReply& newest) {
  bool any = false, heard = false;
  EncoderReply reply;
  std::array<char, kBytesPerRead> bytes;
  for (int i = 0; i < kReadsPerTick && !gone_; ++i) {
    const ssize_t n = ::read(node_.get(), bytes.data(), bytes.size());
    if (n < 0 && (errno == EAGAIN || errno == EINTR)) break;
    // neither data nor EAGAIN: the node has hung up
    if (n <= 0) hang_up();
    for (ssize_t k = 0; k < n; ++k) {
      if (!reader_.push(bytes[static_cast<size_t>(k)], reply)) continue;
      heard = true;
      any = !match_.hear(reply.error, now_ns_ < excused_ns_);
      if (any) newest = reply;
    }
    if (n < static_cast<ssize_t>(bytes.size())) break;
  }
  if (heard) patience_ns_ = kAskAgainNs;
  heard_ |= heard;
  if (any && !match_.awaits_echo()) awaiting_ = false;
  return any;
}

/// Whether this answer gives the present position of the arm.
bool WoodenHaptics::accept(const EncoderReply& reply) {
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

bool WoodenHaptics::is_stale() const {
  return match_.is_distrusted() || (doubted_ns_ != 0 && now_ns_ - doubted_ns_ > kDeviceSilenceNs);
}

void WoodenHaptics::move_to(const MotorCounts& counts) {
  joint_angles_ = joint_angles(geometry_, counts);
  last_.X_BH.p = tip_position(geometry_, joint_angles_);
}

bool WoodenHaptics::read(const TickTime& tick, DeviceState& state) {
  if (started_ && tick.now_ns - now_ns_ > kHeldUpNs) {
    excused_ns_ = tick.now_ns + kExcusedNs;
    doubted_ns_ = 0;
  }
  now_ns_ = tick.now_ns;
  if (!started_) answered_ns_ = tick.now_ns;
  started_ = true;
  EncoderReply reply;
  const bool answered = receive(reply) && accept(reply);
  // after a silence the first answer may be to an old line; the next is to a zero, so the motors
  // hold zero when the force returns
  const bool fresh = answered && (!lost_ || returning_);
  returning_ = lost_ && !fresh && (returning_ || answered) && match_.is_settled();
  if (fresh) {
    const Vec3 before_B = last_.X_BH.p;
    const double dt = 1e-9 * static_cast<double>(asked_ns_ - last_.t_ns);
    move_to({reply.counts[0], reply.counts[1], reply.counts[2]});
    if (moved_ && !lost_ && dt > 0) {
      const double pole = 1 / (2 * std::numbers::pi * velocity_cutoff_);
      const Vec3 raw_B = (last_.X_BH.p - before_B) / dt;
      last_.V_BH.v += dt / (dt + pole) * (raw_B - last_.V_BH.v);
    } else {
      last_.V_BH = {};
      noise_.restart();
    }
    noise_.add({reply.counts[0], reply.counts[1], reply.counts[2]}, first_asked_ns_, now_ns_);
    // the older instant: bounds the hand's motion over the longer time
    last_.t_ns = first_asked_ns_;
    moved_ = true;
  }
  const bool silent = tick.now_ns - answered_ns_ > kDeviceSilenceNs;
  // after such a delay the firmware has switched the motors off: no step back to full force
  const bool let_go = moved_ && tick.now_ns - asked_ns_ > kLetGoNs;
  lost_ = silent || gone_ || let_go || returning_;
  const auto flag = [](bool holds, DeviceFlag which) { return holds ? uint32_t{which} : 0; };
  last_.flags = (fresh ? kDeviceFresh : kDeviceHeld) | flag(homed_, kDeviceHomed) |
                flag(saturated_, kDeviceSaturated) | flag(lost_, kDeviceLost) |
                flag(is_stale(), kDeviceStale) | flag(noise_.is_noisy(), kDeviceNoisy);
  state = last_;
  return fresh;
}

/// Scales the whole vector, so the force keeps its direction.
Milliamperes WoodenHaptics::currents_for(const Vec3& force_B) {
  const double size = norm(force_B);
  saturated_ = !(size <= max_force_);
  if (!std::isfinite(size)) return {};
  const Vec3 kept_B = saturated_ ? max_force_ / size * force_B : force_B;
  Vec3 amperes = motor_currents(geometry_, joint_angles_, kept_B);
  const double largest =
      std::max({std::fabs(amperes.x), std::fabs(amperes.y), std::fabs(amperes.z)});
  if (largest > max_current_) {
    amperes *= max_current_ / largest;
    saturated_ = true;
  }
  const auto whole = [](double a) { return static_cast<int32_t>(std::lround(1000 * a)); };
  return {whole(amperes.x), whole(amperes.y), whole(amperes.z)};
}

void WoodenHaptics::write(const Wrench& F_B) {
  if (gone_ || (awaiting_ && now_ns_ - asked_ns_ < patience_ns_)) return;
  patience_ns_ = awaiting_ ? std::min(2 * patience_ns_, kAskAgainMostNs) : kAskAgainNs;
  Milliamperes currents = currents_for(F_B.f);
  // a zero is then the last of the waiting lines, of which the firmware obeys at most the last
  if (lost_) currents = {};
  // an encoder is unlikely to repeat this number twice; the motors are off, and it is at most 13 mN
  if (!homed_) currents = {static_cast<int32_t>(1 + ++probe_ % 7), 0, 0};
  // no challenge to a silent device, which must find a zero when it wakes, nor before that zero is
  // answered
  ask(currents, homed_ && !returning_ && (!awaiting_ || heard_));
}

bool WoodenHaptics::ask(const Milliamperes& currents, bool may_challenge) {
  const CommandText command = encode_currents(currents, match_.ask(may_challenge));
  heard_ = false;
  const ssize_t n = ::write(node_.get(), command.text.data(), command.size);
  if (n < 0 && errno != EAGAIN && errno != EINTR) hang_up();
  // while one is unanswered, the next answer may be to either question
  if (!awaiting_) first_asked_ns_ = now_ns_;
  // a line truncated by a full queue is dropped by the firmware, as if never sent
  awaiting_ = n > 0;
  asked_ns_ = now_ns_;
  if (n != static_cast<ssize_t>(command.size)) return false;
  currents_ = currents;
  return true;
}

/// Colliding lines are dropped and answered with errors: waits for what is under way, then sends
/// zero until it is confirmed.
void WoodenHaptics::stop() {
  EncoderReply reply;
  const int64_t give_up_ns = haptic::now_ns() + kStopNs;
  const auto wait = [&](int64_t patience_ns) {
    return wait_for_answer(std::min(haptic::now_ns() + patience_ns, give_up_ns), reply);
  };
  if (awaiting_) wait(kStopWaitNs);
  do {
    ask({}, false);
    if (wait(kStopWaitNs) && reply.error == 0) return;
    while (wait(kQuietNs)) {
    }
  } while (!gone_ && haptic::now_ns() < give_up_ns);
}

DeviceRelease WoodenHaptics::release() const {
  DeviceRelease release{.size = kZeroCommand.size(), .bytes = {}};
  kZeroCommand.copy(release.bytes.data(), kZeroCommand.size());
  return release;
}

std::unique_ptr<Device> open_woodenhaptics(const DeviceConfig& config, FileDescriptor node) {
  if (!node.is_open()) node = open_serial_port(std::string(node_of(config)));
  return std::make_unique<WoodenHaptics>(config, std::move(node));
}

}  // namespace haptic
