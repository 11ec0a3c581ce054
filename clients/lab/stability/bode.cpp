// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/stability/bode.h"
#include "proto/math/units.h"

#include <algorithm>
#include <cmath>

namespace haptic {
namespace {

using Complex = std::complex<double>;
constexpr Complex kJ{0, 1};

constexpr int kPeriod = 1000;     // ticks of the lowest frequency
constexpr int kSines = 24;        // at most
constexpr int kHighest = 449;     // odd multiple of the lowest frequency; half the rate is 500
constexpr int kApproach = 500;    // ticks from outside to the middle of the motion
constexpr int kSettle = kPeriod;  // ticks before anything is compared

constexpr double kDepth = 1e-3;    // of the middle of the motion that moves [m]
constexpr double kOutside = 1e-4;  // where the approach begins [m]
constexpr double kPeak = 0.5;      // largest excursion, of depth or of the turn that tips the cube
constexpr double kCorner = 50;  // multiple above which the sines have equal velocities, not lengths

/// Odd numbers from 1 to kHighest, about evenly spaced in the logarithm.
std::vector<int> harmonics() {
  std::vector<int> out;
  for (int i = 0; i < kSines; ++i) {
    const double wanted = std::pow(static_cast<double>(kHighest), i / (kSines - 1.0));
    const int odd = 2 * static_cast<int>(std::lround((wanted - 1) / 2)) + 1;
    if (out.empty() || odd > out.back()) out.push_back(odd);
  }
  return out;
}

/// The sum of sines, one period of it, with its largest value 1.
std::vector<double> multi_sine(const std::vector<int>& harmonics) {
  std::vector<double> out(kPeriod, 0.0);
  const double n = static_cast<double>(harmonics.size());
  for (size_t i = 0; i < harmonics.size(); ++i) {
    const double k = harmonics[i], order = static_cast<double>(i + 1);
    const double phase = -kPi * order * (order - 1) / n;
    const double amplitude = 1 / (1 + k / kCorner);
    for (int t = 0; t < kPeriod; ++t) {
      out[static_cast<size_t>(t)] += amplitude * std::cos(2 * kPi * k * t / kPeriod + phase);
    }
  }
  double peak = 0;
  for (const double x : out) peak = std::max(peak, std::fabs(x));
  for (double& x : out) x /= peak;
  return out;
}

/// Fourier coefficient of whole periods at a multiple of the lowest frequency.
Complex coefficient(const std::vector<double>& samples, int multiple) {
  Complex sum = 0;
  for (size_t t = 0; t < samples.size(); ++t) {
    const double turns = static_cast<double>(t % kPeriod * static_cast<size_t>(multiple)) / kPeriod;
    sum += samples[t] * std::exp(-2 * kPi * kJ * turns);
  }
  return 2.0 * sum / static_cast<double>(samples.size());
}

/// The motion of the bench: to the middle of it, then the sines.
class LedPath {
 public:
  LedPath(bool turning, const std::vector<double>& sines, double peak)
      : turning_(turning), sines_(sines), peak_(peak) {}

  /// Excursion from the middle [m or rad].
  double swing(int64_t tick) const { return tick < kApproach ? 0 : shape(tick) * peak_; }
  Pose at(int64_t tick) const {
    const double s = std::min(1.0, static_cast<double>(tick) / kApproach);
    const double depth = turning_ ? kPress / 1000 : kDepth;
    const double z = kOutside - s * s * (3 - 2 * s) * (kOutside + depth);
    if (!turning_) return {{0, 0, z + swing(tick)}, {}};
    return {{0, 0, z}, from_rotation_vector({0, swing(tick), 0})};
  }

 private:
  /// The sines set in over a tenth of a period, for a pose that jumps is a fault.
  double shape(int64_t tick) const {
    const double in = std::min(1.0, static_cast<double>(tick - kApproach) / (0.1 * kPeriod));
    return in * sines_[static_cast<size_t>(tick % kPeriod)];
  }
  bool turning_;
  const std::vector<double>& sines_;
  double peak_;
};

/// The wrench that holds over a tick, as a signal of continuous time.
Complex hold(double omega, double period) {
  const double half = 0.5 * omega * period;
  return std::sin(half) / half * std::exp(-kJ * half);
}

double distortion_of(const std::vector<double>& force, const std::vector<int>& odd) {
  double wanted = 0, stray = 0;
  for (const int k : odd) {
    wanted += std::norm(coefficient(force, k));
    stray += std::norm(coefficient(force, k + 1));
  }
  return wanted > 0 ? std::sqrt(stray / wanted) : 0;
}

}  // namespace

Bode measure_bode(const ProbeScene& scene, const ProbeSetting& setting, int periods) {
  const bool turning = scene.turning();
  const std::vector<int> odd = harmonics();
  const std::vector<double> sines = multi_sine(odd);
  const double reach = turning ? linear_limit(true) / setting.stiffness : kDepth;
  const LedPath path(turning, sines, kPeak * reach);
  const SessionConfig config = scene.session(setting);
  LedHandle handle(
      config.device.hand, [&](int64_t tick) { return path.at(tick); }, setting.delay);
  Lockstep lockstep(config, scene.shapes(), handle, {1, 0});

  // a whole number of periods after the first tick, so that tick 0 of both is the same phase
  constexpr int64_t kBegin = (kApproach + kSettle + kPeriod - 1) / kPeriod * kPeriod;
  std::vector<double> motion, force;
  for (int64_t tick = 0; tick < kBegin + int64_t{periods} * kPeriod; ++tick) {
    lockstep.step();
    if (tick < kBegin) continue;
    motion.push_back(path.swing(tick));
    force.push_back(turning ? handle.held().t.y : handle.held().f.z);
  }
  Bode out;
  for (const int k : odd) {
    const double frequency = k * setting.rate / kPeriod, omega = 2 * kPi * frequency;
    const Complex velocity = kJ * omega * coefficient(motion, k);
    const Complex held = coefficient(force, k) * hold(omega, 1 / setting.rate);
    out.points.push_back(
        {frequency, setting.damping + setting.stiffness / (kJ * omega), -held / velocity});
  }
  out.distortion = distortion_of(force, odd);
  return out;
}

}  // namespace haptic
