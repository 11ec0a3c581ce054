// SPDX-License-Identifier: GPL-3.0-or-later
#include "device-io/emulator/emulated_falcon.h"
#include "device-io/emulator/emulated_usb.h"
#include "proto/math/units.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace haptic {
namespace {

constexpr int64_t kWatchdogNs = 100 * kMs;  // an assumption: nobody has measured it
constexpr size_t kPayload = 62;             // of a packet of the chip
constexpr size_t kSmallestImage = 64;       // bytes; shorter is no program

/// Angle of an upper arm at a place of the handle: bisection on the length of the lower arm.
double angle_at(const Vec3& p_B, int leg) {
  // radii, offsets and lengths of the Falcon [m], azimuths 105°, −15° and −135°
  constexpr double kArm = 0.060, kRod = 0.1025, kPlate = 0.01443, kEnds = 2 * 0.01125;
  const double azimuth = kPi / 180 * (105 - 120 * leg);
  // the handle in the plane of the leg, from the motor's axis
  const double along = p_B.x * std::cos(azimuth) + p_B.y * std::sin(azimuth) - 0.040 + kPlate;
  const double across = p_B.y * std::cos(azimuth) - p_B.x * std::sin(azimuth) + 0.02309 - 0.025;
  const double height = p_B.z + 0.125;
  const double rod = kEnds + std::sqrt(kRod * kRod - across * across);
  const auto too_long = [&](double angle) {
    return std::hypot(along - kArm * std::cos(angle), height - kArm * std::sin(angle)) > rod;
  };
  // from leaning outwards as far as it goes: the rod becomes shorter as the arm rises
  double low = -kPi / 2, high = kPi * 2 / 3;
  constexpr double kScan = 0.15;  // far less than between the two ways to bend the leg
  for (double angle = low; angle < high; angle += kScan) {
    if (too_long(angle)) low = angle;
    if (!too_long(angle) && too_long(angle - kScan)) {
      high = angle;
      break;
    }
  }
  for (int n = 0; n < 36; ++n) {
    const double middle = (low + high) / 2;
    (too_long(middle) ? low : high) = middle;
  }
  return (low + high) / 2;
}

/// Counts of the encoder: 1280 a turn of the motor, a capstan of 14.25 mm on a sector of 110 mm,
/// zero at 35°.
int counts_of(double angle) {
  return static_cast<int>(
      std::floor((angle - 35 * kPi / 180) / (2 * kPi) * 1280 * 110 / 14.25 + 0.5));
}

/// Virtual work: F_k = Σ τ_i ∂θ_i/∂x_k.
Vec3 force_of(const Vec3& p_B, const std::array<int, 3>& words) {
  constexpr double kStep = 1e-5;  // [m]
  Vec3 force;
  for (int i = 0; i < 3; ++i) {
    const double torque = -1e-4 * std::clamp(words[static_cast<size_t>(i)], -4095, 4095);
    if (torque == 0) continue;
    for (int k = 0; k < 3; ++k) {
      Vec3 step;
      step[k] = kStep;
      force[k] += torque * (angle_at(p_B + step, i) - angle_at(p_B - step, i)) / (2 * kStep);
    }
  }
  return force;
}

UsbDescriptors describe_falcon(const std::string& serial) {
  UsbDescriptors all;
  all.vendor = 0x0403;
  all.product = 0xcb48;
  all.device = {18, 1, 0x00, 0x02, 0, 0, 0, 8, 0x03, 0x04, 0x48, 0xcb, 0x00, 0x04, 1, 2, 3, 1};
  all.configuration = {9,    2, 32, 0, 1,    1, 0,  0x80, 45, 9, 4, 0,    0, 2,  0xff, 0xff,
                       0xff, 2, 7,  5, 0x81, 2, 64, 0,    0,  7, 5, 0x02, 2, 64, 0,    0};
  all.strings = {"FTDI (emulated)", "Novint Falcon (emulated)", serial};
  return all;
}

}  // namespace

EmulatedFalcon::EmulatedFalcon(const EmulatedFalconOptions& options)
    : options_(options),
      descriptors_(describe_falcon(options.serial)),
      intention_(options.intention ? options.intention : seeded_intention(options.hand)) {
  if (options.has_firmware) state_ = State::kRunning;
  plant_ = start_plant(options_.hand, intention_);
  sense();
}

void EmulatedFalcon::cut_power() {
  state_ = State::kBoot;
  options_.is_homed = false;
  image_.clear();
  motors_ = {};
  to_host_.clear();
}

bool EmulatedFalcon::loses() {
  return lie_ == EmulatorFault::kLoses && random_() % 100 == 0;
}

bool EmulatedFalcon::control(const UsbSetup& setup, const UsbBytes&, UsbBytes&, int64_t t_ns) {
  advance_to(t_ns);
  if (setup.type != 0x40) return false;
  switch (setup.request) {
    case 0:  // reset, purge towards the host, purge towards the device
      if (setup.value != 2) to_host_.clear();
      if (setup.value != 1) from_host_.clear();
      return true;
    case 1:  // modem lines: a mask, and the values
      if ((setup.value & 0x0100) != 0) dtr_ = (setup.value & 1) != 0;
      return true;
    case 3:
      divisor_ = setup.value;
      // the processor notices the end of an image by the change of speed
      if (state_ == State::kLoading && divisor_ == 2 && image_.size() >= kSmallestImage) {
        state_ = State::kRunning;
      }
      return true;
    case 9:
      latency_ns_ = options_.latency_ns >= 0 ? options_.latency_ns : setup.value * kMs;
      return true;
    case 2:
    case 4:
    case 6:
    case 7:
      return true;
    default:
      return false;
  }
}

void EmulatedFalcon::send(const UsbBytes& bytes) {
  for (const uint8_t byte : bytes) {
    if (!loses()) to_host_.push_back(byte);
  }
}

void EmulatedFalcon::take(uint8_t endpoint, const uint8_t* bytes, size_t size, int64_t t_ns) {
  if (endpoint != 2) throw std::logic_error("the Falcon has one OUT endpoint");
  advance_to(t_ns);
  for (size_t i = 0; i < size; ++i) {
    if (!loses()) take_byte(bytes[i], t_ns);
  }
}

void EmulatedFalcon::take_byte(uint8_t byte, int64_t t_ns) {
  static const UsbBytes kHello{0x0a, 0x43, 0x0d}, kHelloBack{0x0a, 0x44, 0x2c, 0x0d};
  // at another speed than the one it listens with it hears noise
  const uint16_t expected[] = {0x4138, 0x15, 0x15, 2};
  if (divisor_ != expected[static_cast<size_t>(state_)] && state_ != State::kGreeted) return;
  switch (state_) {
    case State::kBoot:
    case State::kGreeted:
      if (state_ == State::kGreeted && divisor_ == 0x15 && !dtr_ && byte == 'A') {
        send({'A'});
        state_ = State::kLoading;
        image_.clear();
        return;
      }
      from_host_.push_back(byte);
      if (from_host_.size() > 3) from_host_.erase(from_host_.begin());
      if (divisor_ == 0x4138 && dtr_ && from_host_ == kHello) {
        send(kHelloBack);
        from_host_.clear();
        state_ = State::kGreeted;
      }
      return;
    case State::kLoading:
      image_.push_back(byte);
      if (image_.size() == 1000 && options_.wrong_echoes > 0) {
        --options_.wrong_echoes;
        send({static_cast<uint8_t>(byte ^ 0x20)});
        // the boot loader listens for a greeting again
        state_ = State::kBoot;
        return;
      }
      send({byte});
      return;
    case State::kRunning:
      if (byte == '<') from_host_.clear();
      from_host_.push_back(byte);
      if (from_host_.size() >= 16) take_packet(t_ns);
      return;
  }
}

void EmulatedFalcon::take_packet(int64_t t_ns) {
  const UsbBytes packet = std::move(from_host_);
  from_host_.clear();
  if (packet.front() != '<' || packet.back() != '>') {
    ++rejected_;
    return;
  }
  const bool pushed = std::any_of(motors_.begin(), motors_.end(), [](int w) { return w != 0; });
  for (size_t i = 0; i < 3; ++i) {
    int word = 0;
    for (size_t k = 4; k-- > 0;) word = word * 16 + ((packet[1 + 4 * i + k] - 'A') & 15);
    motors_[i] = word < 32768 ? word : word - 65536;
  }
  homing_ = ((packet[13] - 'A') & 1) != 0;
  constexpr char kZero[] = "<AAAAAAAAAAAABA>";
  if (pushed && std::equal(packet.begin(), packet.end(), kZero)) {
    let_go_ns_.push_back(t_ns - last_packet_ns_);
  }
  force_B_ = force_of(plant_.p_B, motors_);
  if (std::any_of(motors_.begin(), motors_.end(), [](int w) { return w != 0; })) ++pushing_;
  if (packets_++ > 0) longest_gap_ns_ = std::max(longest_gap_ns_, t_ns - last_packet_ns_);
  last_packet_ns_ = t_ns;
  answer();
}

void EmulatedFalcon::answer() {
  if (lie_ == EmulatorFault::kSilent) return;
  ++answers_;
  sense();
  std::array<int, 3> said = counts_;
  if (lie_ == EmulatorFault::kNoise) said[1] += static_cast<int>(random_() % 61) - 30;
  if (lie_ == EmulatorFault::kFlipped) said[1] = 2 * mirror_[1] - said[1];
  if (lie_ != EmulatorFault::kFlipped) mirror_ = counts_;
  UsbBytes packet{'<'};
  for (const int count : said) {
    for (int k = 0; k < 4; ++k) {
      packet.push_back(static_cast<uint8_t>('A' + (static_cast<unsigned>(count) >> (4 * k) & 15)));
    }
  }
  const bool shows = homing_ || options_.shows_homing;
  const int homed = shows && options_.is_homed ? 7 : 0;
  packet.push_back(static_cast<uint8_t>('A' + (homed << 4)));
  packet.insert(packet.end(), {'A', '>'});
  said_.push_back(packet);
  if (said_.size() > kRemembered) said_.pop_front();
  if (lie_ == EmulatorFault::kFrozen) packet = whole_;
  if (lie_ != EmulatorFault::kFrozen) whole_ = packet;
  if (lie_ == EmulatorFault::kOldFirst) send(said_.front());
  send(lie_ == EmulatorFault::kDelayed ? said_.front() : packet);
}

bool EmulatedFalcon::give(uint8_t endpoint, size_t most, UsbBytes& packet, int64_t t_ns) {
  if (endpoint != 0x81) throw std::logic_error("the Falcon has one IN endpoint");
  advance_to(t_ns);
  const bool full = to_host_.size() >= kPayload;
  if (!full && t_ns - given_ns_ < latency_ns_) return false;
  given_ns_ = t_ns;
  size_t n = std::min({to_host_.size(), std::max<size_t>(most, 2) - 2, kPayload});
  if (lie_ == EmulatorFault::kHalves) n = std::min<size_t>(n, 9);
  packet = {0x01, 0x60};  // modem status
  packet.insert(packet.end(), to_host_.begin(), to_host_.begin() + static_cast<ptrdiff_t>(n));
  to_host_.erase(to_host_.begin(), to_host_.begin() + static_cast<ptrdiff_t>(n));
  return true;
}

void EmulatedFalcon::sense() {
  for (int i = 0; i < 3; ++i) {
    counts_[static_cast<size_t>(i)] = counts_of(angle_at(plant_.p_B, i));
  }
}

void EmulatedFalcon::advance_to(int64_t t_ns) {
  if (t_ns_ == 0) t_ns_ = given_ns_ = t_ns;
  if (t_ns <= t_ns_) return;
  bool pushes = std::any_of(motors_.begin(), motors_.end(), [](int w) { return w != 0; });
  if (t_ns - last_packet_ns_ > kWatchdogNs) {
    watchdogs_ += pushes ? 1 : 0;
    motors_ = {};
    pushes = false;
  }
  if (!pushes) force_B_ = {};
  advance(options_.hand, intention_, plant_, with_load({force_B_, {}}, options_.load, plant_),
          t_ns - t_ns_);
  t_ns_ = t_ns;
}

}  // namespace haptic
