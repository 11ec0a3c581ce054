// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/emulator/emulated_haply.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>
#include <utility>

namespace haptic {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;  // [rad]
constexpr int64_t kLoopNs = 50'000;             // "currentState - lastPublished >= 50" µs
constexpr int64_t kTimeoutNs = 1'000'000'000;   // of Arduino's readBytes
constexpr double kMostTorque = 0.123;           // MAX_TORQUE of 1.5 [N·m]
constexpr double kMostTorqueM0 = 0.156;         // of the M0's
constexpr size_t kQueue = 50;                   // answers that a liar remembers

}  // namespace

/// Reads as the firmware does: read() gives 255 where there is nothing, readBytes() waits.
struct EmulatedHaply::Cursor {
  std::deque<uint8_t>& in;
  bool may_wait;
  size_t at = 0;
  bool is_short = false;

  int read() { return at < in.size() ? in[at++] : 255; }
  Bytes read_bytes(size_t n) {
    Bytes bytes(n);
    is_short = may_wait && in.size() - at < n;
    for (uint8_t& byte : bytes) {
      if (at < in.size()) byte = in[at++];
    }
    return bytes;
  }
  static double number(const Bytes& bytes, size_t at) {
    std::array<uint8_t, 4> raw{};
    std::copy_n(bytes.begin() + static_cast<ptrdiff_t>(at), 4, raw.begin());
    return std::bit_cast<float>(raw);
  }
};

EmulatedHaply::EmulatedHaply(const EmulatedHaplyOptions& options)
    : options_(options),
      ports_(options.is_m0 ? 2 : 4),
      plant_(start_plant(options.hand)),
      intention_(seeded_intention(options.hand)) {}

/// The angle of a driven link: turned outwards from the line to the handle, its elbow goes away
/// from the handle all the way. Bisection, then Newton's method on the squared distance.
double EmulatedHaply::angle(int link, const Vec3& p_B) const {
  const PantographConfig& arm = options_.arm;
  const double side = link == 0 ? 1 : -1;
  const Vec3 v{p_B.x + side * arm.base / 2, p_B.y, 0};
  const double towards = std::atan2(v.y, v.x);
  const auto rod = [&](double turned) {
    const double theta = towards + side * turned;
    return v - arm.proximal * Vec3{std::cos(theta), std::sin(theta), 0};
  };
  double near = 0, far = std::numbers::pi;
  for (int n = 0; n < 8; ++n) {
    const double half = (near + far) / 2;
    (norm(rod(half)) < arm.distal ? near : far) = half;
  }
  double turned = (near + far) / 2;
  for (int n = 0; n < 4; ++n) {
    const Vec3 r = rod(turned);
    const double theta = towards + side * turned;
    const Vec3 slope = side * arm.proximal * Vec3{std::sin(theta), -std::cos(theta), 0};
    turned -= (dot(r, r) - arm.distal * arm.distal) / (2 * dot(r, slope));
  }
  return towards + side * turned;
}

double EmulatedHaply::raw_count(size_t port, const Vec3& p_B) const {
  const PantographConfig& arm = options_.arm;
  const int link = port == arm.port_1 - 1 ? 0 : 1;
  const double sign = link == 0 ? arm.sign_1 : arm.sign_2;
  const double per_turn = arm.counts_per_turn / (options_.is_m0 ? 2 : 1);
  return std::floor(sign * angle(link, p_B) / kTurn * per_turn);
}

/// The force whose work is that of the links' torques.
Vec3 EmulatedHaply::motor_force() const {
  constexpr double kStep = 1e-6;
  const PantographConfig& arm = options_.arm;
  Vec3 force;
  for (int link = 0; link < 2; ++link) {
    const bool first = (link == 0) == (arm.port_1 == 1);
    const double torque =
        (link == 0 ? arm.sign_1 : arm.sign_2) * arm.reduction * torques_[first ? 0 : 1];
    for (int k = 0; k < 2; ++k) {
      Vec3 step;
      step[k] = kStep;
      const double way = angle(link, plant_.p_B + step) - angle(link, plant_.p_B - step);
      force[k] += torque * way / (2 * kStep);
    }
  }
  return force;
}

double EmulatedHaply::largest_torque() const {
  return std::max(std::fabs(torques_[0]), std::fabs(torques_[1]));
}

void EmulatedHaply::cut_power() {
  for (Port& port : ports_) port = {};
  torques_ = {};
  force_B_ = {};
  in_.clear();
  out_.clear();
  said_.clear();
  number_.reset();
}

bool EmulatedHaply::set_up(Cursor& in) {
  const int device = in.read();
  std::array<int, 2> masks{};
  for (int& mask : masks) {
    mask = in.read();
    // directions, one for each bit; this driver leaves them at 0
    for (size_t i = 0; i < ports_.size(); ++i) {
      if ((mask >> i & 1) != 0) in.read();
    }
  }
  // analog pins, PWM pins
  for (int kind = 0; kind < 2; ++kind) {
    const int n = in.read();
    for (int i = 0; i < n; ++i) in.read();
  }
  size_t encoders = 0;
  for (size_t i = 0; i < ports_.size(); ++i) encoders += static_cast<size_t>(masks[1] >> i & 1);
  const Bytes parameters = in.read_bytes(8 * encoders);
  if (in.is_short) return false;
  size_t at = 0;
  for (size_t i = 0; i < ports_.size(); ++i) {
    ports_[i] = {};
    ports_[i].motor = (masks[0] >> i & 1) != 0 ? device : 0;
    if ((masks[1] >> i & 1) == 0) continue;
    Port& port = ports_[i];
    port.encoder = device;
    port.counts_per_turn = Cursor::number(parameters, at + 4) / (options_.is_m0 ? 2 : 1);
    const double start = std::trunc(Cursor::number(parameters, at) * port.counts_per_turn / 360);
    port.base = start - (i < 2 ? raw_count(i, options_.home_B) : 0);
    at += 8;
  }
  ++setups_;
  return true;
}

bool EmulatedHaply::exert(Cursor& in) {
  const int device = in.read();
  size_t motors = 0;
  for (const Port& port : ports_) motors += port.motor == device ? 1 : 0;
  const Bytes values = in.read_bytes(4 * motors);
  if (in.is_short) return false;
  size_t at = 0;
  std::array<double, 2> wanted = torques_;
  for (size_t i = 0; i < ports_.size(); ++i) {
    if (ports_[i].motor != device) continue;
    if (i < 2) wanted[i] = Cursor::number(values, at);
    at += 4;
  }
  const double most = options_.is_m0 ? kMostTorqueM0 : kMostTorque;
  const double largest = std::max(std::fabs(wanted[0]), std::fabs(wanted[1]));
  for (double& torque : wanted) {
    torque =
        options_.is_m0 ? torque * std::min(1.0, most / largest) : std::clamp(torque, -most, most);
  }
  if (motors > 0) {
    torques_ = wanted;
    force_B_ = motor_force();
    ++commands_;
  }
  answer(device);
  return true;
}

void EmulatedHaply::answer(int device) {
  Bytes bytes{static_cast<uint8_t>(device)};
  for (size_t i = 0; i < ports_.size(); ++i) {
    const Port& port = ports_[i];
    if (port.encoder != device) continue;
    double count = port.base + (i < 2 ? raw_count(i, plant_.p_B) : 0);
    if (i == 1) {
      if (lie_ == EmulatorFault::kNoise) count += static_cast<int>(random_() % 61) - 30;
      if (lie_ == EmulatorFault::kFlipped) count = 2 * mirror_[i] - count;
      if (lie_ != EmulatorFault::kFlipped) mirror_[i] = count;
    }
    if (i < 2 && lie_ != EmulatorFault::kFrozenCounts) frozen_[i] = count;
    if (i < 2) count = frozen_[i];
    const auto raw = std::bit_cast<std::array<uint8_t, 4>>(
        static_cast<float>(360.0 * count / port.counts_per_turn));
    bytes.insert(bytes.end(), raw.begin(), raw.end());
  }
  say(bytes);
}

/// A liar keeps and repeats answers with the number before them.
void EmulatedHaply::say(const Bytes& bytes) {
  if (bytes.size() == 1) {
    if (number_) out_.push_back(*number_);
    number_ = bytes[0];
    return;
  }
  Bytes whole;
  if (number_) whole.push_back(*number_);
  number_.reset();
  whole.insert(whole.end(), bytes.begin(), bytes.end());
  if (lie_ == EmulatorFault::kFrozen && !said_.empty()) whole = said_.back();
  said_.push_back(whole);
  if (said_.size() > kQueue) said_.pop_front();
  const auto send = [&](const Bytes& all) {
    for (const uint8_t byte : all) {
      if (lie_ != EmulatorFault::kLoses || random_() % 100 != 0) out_.push_back(byte);
    }
  };
  if (lie_ == EmulatorFault::kOldFirst) send(said_.front());
  send(lie_ == EmulatorFault::kDelayed ? said_.front() : whole);
}

/// One turn of the firmware's loop; false: it waits for the rest of a command.
bool EmulatedHaply::run_command() {
  const bool timed_out = waits_since_ns_ != 0 && t_ns_ - waits_since_ns_ > kTimeoutNs;
  Cursor in{in_, !timed_out};
  bool done = true;
  switch (in.read()) {
    case 0:
      in.read();
      for (Port& port : ports_) port = {};
      ++resets_;
      break;
    case 1:
      done = set_up(in);
      break;
    case 2:
      done = exert(in);
      break;
    default:
      break;
  }
  if (!done) {
    if (waits_since_ns_ == 0) waits_since_ns_ = t_ns_;
    return false;
  }
  waits_since_ns_ = 0;
  in_.erase(in_.begin(), in_.begin() + static_cast<ptrdiff_t>(in.at));
  return true;
}

void EmulatedHaply::move_to(int64_t t_ns) {
  if (t_ns <= t_ns_) return;
  advance(options_.hand, intention_, plant_, with_load({force_B_, {}}, options_.load, plant_),
          t_ns - t_ns_);
  t_ns_ = t_ns;
  if (largest_torque() > 0) force_B_ = motor_force();
}

void EmulatedHaply::advance_to(int64_t t_ns) {
  if (t_ns_ == 0) t_ns_ = turn_ns_ = t_ns;
  while (!in_.empty() && lie_ != EmulatorFault::kSilent && turn_ns_ + kLoopNs <= t_ns) {
    turn_ns_ += kLoopNs;
    move_to(turn_ns_);
    run_command();
  }
  if (in_.empty() || lie_ == EmulatorFault::kSilent) turn_ns_ = t_ns;
}

void EmulatedHaply::take(std::span<const uint8_t> bytes, int64_t t_ns) {
  advance_to(t_ns);
  move_to(t_ns);
  in_.insert(in_.end(), bytes.begin(), bytes.end());
}

EmulatedHaply::Bytes EmulatedHaply::give(int64_t t_ns) {
  advance_to(t_ns);
  // a number that nothing has followed
  if (number_ && in_.empty()) {
    out_.push_back(*number_);
    number_.reset();
  }
  return std::exchange(out_, {});
}

}  // namespace haptic
