// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/emulator/firmware.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>

#include "proto/math/assert.h"

namespace haptic {
namespace {

// error codes of the firmware
constexpr int kTrailing = 8, kTooLong = 128, kNoBegin = 256, kNotAsMany = 512, kNoNumbers = 1024;
constexpr int64_t kLongestGapNs = 1'000'000'000;  // longer gaps are skipped
constexpr int64_t kForceStepNs = 250'000;         // the arm turns little in this time

/// Reads as many numbers as there are motors; at the most six.
bool read_currents(const char* line, size_t motors, Milliamperes& n) {
  const int found =
      std::sscanf(line, "[%d,%d,%d,%d,%d,%d]", &n[0], &n[1], &n[2], &n[3], &n[4], &n[5]);
  return found == static_cast<int>(motors);
}

}  // namespace

EmulatedDevice::EmulatedDevice(const EmulatedDeviceOptions& options, int64_t t_ns)
    : options_(options),
      intention_(options.intention ? options.intention : seeded_intention(options.hand)),
      plant_(start_plant(options.hand, intention_)),
      t_ns_(t_ns),
      started_ns_(t_ns),
      last_record_ns_(t_ns),
      joint_angles_(options.arm->angles({})),
      frozen_{.model = options.arm->model},
      calibrated_(options.button_ns == 0) {
  // switched on at home, so the counts are those of the geometry
  solve();
}

void EmulatedDevice::receive(std::span<const char> bytes) {
  const size_t n = std::min(bytes.size(), queue_.size() - queued_);
  std::copy_n(bytes.begin(), n, queue_.begin() + static_cast<std::ptrdiff_t>(queued_));
  queued_ += n;
  HAPTIC_ASSERT(queued_ <= queue_.size());
}

void EmulatedDevice::disturb(const MotorCounts& off_by, uint64_t answers) {
  off_by_ = off_by;
  disturbed_answers_ = answers;
}

void EmulatedDevice::lead(const std::optional<Vec3>& place_B) {
  lead_plant(intention_, plant_, place_B ? std::optional(Pose{*place_B, {}}) : std::nullopt);
}

/// The arm follows its handle; it keeps its angles if the plant leaves its reach.
void EmulatedDevice::solve() {
  options_.arm->solve({plant_.p_B, plant_.q_B}, joint_angles_);
}

MotorEfforts EmulatedDevice::amperes() const {
  MotorEfforts amperes;
  for (size_t i = 0; i < amperes.size(); ++i) amperes[i] = 1e-3 * record_.currents[i];
  return amperes;
}

/// Advances arm and hand under the motors' wrench.
void EmulatedDevice::pass_time(int64_t t_ns) {
  t_ns_ = std::max(t_ns_, t_ns - kLongestGapNs);
  while (t_ns_ < t_ns) {
    const int64_t step_ns = std::min(t_ns - t_ns_, kForceStepNs);
    solve();
    const Wrench F_B =
        with_load(options_.arm->wrench(joint_angles_, amperes()), options_.load, plant_);
    advance(options_.hand, intention_, plant_, F_B, step_ns);
    t_ns_ += step_ns;
  }
}

/// True if a complete line has arrived.
bool EmulatedDevice::has_line() const {
  const auto end =
      queue_.begin() + static_cast<std::ptrdiff_t>(std::min(queued_, line_.size() - 1));
  return queued_ >= line_.size() - 1 || std::find(queue_.begin(), end, ']') != end;
}

/// Takes a line from the queue into line_, from its last '['. What follows the line is taken and
/// checked too: by this fault of the firmware two lines at once are both lost.
int EmulatedDevice::read_line() {
  size_t taken = 0, size = 0;
  size_t commas = 0;
  int error = kTooLong;
  bool begun = false;
  while (taken < queued_ && taken < line_.size() - 1) {
    const char c = queue_[taken++];
    if (c == '[') {
      begun = true;
      size = 0;
    }
    if (c == ',') ++commas;
    line_[size++] = c;
    if (c != ']') continue;
    error = !begun ? kNoBegin : commas + 1 != options_.arm->motors ? kNotAsMany : 0;
    break;
  }
  line_[size] = '\0';
  HAPTIC_ASSERT(size < line_.size());
  while (error == 0 && taken < queued_) {
    const char c = queue_[taken++];
    if (c != '\n' && c != '\r' && c != '\0') error = kTrailing;
  }
  std::copy(queue_.begin() + static_cast<std::ptrdiff_t>(taken),
            queue_.begin() + static_cast<std::ptrdiff_t>(queued_), queue_.begin());
  queued_ -= taken;
  return error;
}

/// Appends an answer.
void EmulatedDevice::put(const EncoderReply& reply) {
  const auto& e = reply.counts;
  char* const at = answer_.data() + answer_size_;
  const int size = std::snprintf(at, answer_.size() - answer_size_, "[%d,%d,%d,%d,%d,%d,%d,%d]\n",
                                 reply.model, e[0], e[1], e[2], e[3], e[4], e[5], reply.error);
  answer_size_ += static_cast<size_t>(size);
  HAPTIC_ASSERT(size > 0 && answer_size_ < answer_.size());
}

/// Answers, truthfully or with the ordered fault. counts_ then holds what was sent last.
void EmulatedDevice::say(int error) {
  const auto buttons = static_cast<int32_t>(buttons_ << kFirstButton);
  const EncoderReply honest{options_.arm->model + buttons, counts_, error};
  // the oldest entry is where the newest will be stored
  EncoderReply& kept = said_[n_said_ % said_.size()];
  const EncoderReply old = n_said_ < said_.size() ? said_.front() : kept;
  said_first_ = counts_;
  switch (lie_) {
    case EmulatorFault::kFrozen:
      put(frozen_);
      counts_ = said_first_ = frozen_.counts;
      return;
    case EmulatorFault::kOldFirst:
      put(old);
      put(honest);
      said_first_ = old.counts;
      break;
    case EmulatorFault::kDelayed:
      put(old);
      counts_ = said_first_ = old.counts;
      break;
    default:
      put(honest);
  }
  if (error == 0) frozen_ = honest;
  kept = honest;
  ++n_said_;
}

void EmulatedDevice::add_noise() {
  if (lie_ != EmulatorFault::kNoise && lie_ != EmulatorFault::kTurnNoise) return;
  const size_t encoder = lie_ == EmulatorFault::kNoise ? 1 : kMostMotors - 1;
  counts_[encoder] += std::uniform_int_distribution<int32_t>(-kNoiseCounts, kNoiseCounts)(noise_);
}

void EmulatedDevice::note(int64_t t_ns, EmulatorEvent event) {
  record_.t_ns = t_ns;
  record_.event = event;
  solve();
  const Wrench F_B = options_.arm->wrench(joint_angles_, amperes());
  record_.force_B = F_B.f;
  record_.torque_B = F_B.t;
  record_.p_B = plant_.p_B;
  record_.q_B = plant_.q_B;
  record_.answered = counts_;
  record_.said_first = said_first_;
  record_.counts = options_.arm->counts(joint_angles_);
  last_record_ns_ = t_ns;
}

/// Obeys the line and answers. False: it was dropped.
bool EmulatedDevice::obey(int error) {
  Milliamperes wanted{};
  if (error == 0 && !read_currents(line_.data(), options_.arm->motors, wanted)) error = kNoNumbers;
  if (error != 0) {
    ++record_.rejected;
    say(error);
    return false;
  }
  ++record_.commands;
  last_command_ns_ = t_ns_;
  for (size_t i = 0; i < wanted.size(); ++i) {
    const bool allowed =
        wanted[i] >= -kFirmwareMaxMilliamperes && wanted[i] <= kFirmwareMaxMilliamperes;
    record_.currents[i] = calibrated_ && allowed ? wanted[i] : 0;
  }
  record_.motors_on = calibrated_ ? 1 : 0;
  // before the new answer: the record shows what the server knew when it sent this line
  note(t_ns_, EmulatorEvent::kCommand);
  counts_ = record_.counts;
  if (disturbed_answers_ > 0) {
    --disturbed_answers_;
    for (size_t i = 0; i < off_by_.size(); ++i) counts_[i] += off_by_[i];
  }
  add_noise();
  if (!calibrated_) {
    const double phase = 0.0002 * static_cast<double>(questions_++);
    counts_[0] = kSineMiddle + static_cast<int32_t>(kSineAmplitude * std::sin(phase));
    counts_[1] = wanted[0];
  }
  say(0);
  return true;
}

bool EmulatedDevice::turn(int64_t t_ns) {
  answer_size_ = 0;
  // the watchdog runs independently of the loop: at its own instant, however late this turn is
  const int64_t cut_ns = last_command_ns_ + kFirmwareWatchdogNs;
  const bool cut = record_.motors_on != 0 && t_ns >= cut_ns;
  if (cut) {
    pass_time(cut_ns);
    record_.currents = {};
    record_.motors_on = 0;
    ++record_.watchdog;
    note(cut_ns, EmulatorEvent::kWatchdog);
    // received bytes are read in the next turn
    return true;
  }
  pass_time(t_ns);
  if (!calibrated_ && t_ns_ - started_ns_ >= options_.button_ns) {
    calibrated_ = true;
    note(t_ns_, EmulatorEvent::kCalibrated);
    return true;
  }
  if (has_line()) {
    if (!obey(read_line())) note(t_ns_, EmulatorEvent::kRejected);
    return true;
  }
  if (t_ns_ - last_record_ns_ < options_.sample_period_ns) return false;
  note(t_ns_, EmulatorEvent::kSample);
  return true;
}

}  // namespace haptic
