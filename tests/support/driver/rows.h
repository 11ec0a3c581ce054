// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <memory>
#include <string_view>
#include <vector>

#include "tests/support/driver/bench.h"

namespace haptic::test {

/// A driver with its emulated device, and what is expected of it. Each shared test runs over all
/// rows; a driver that is new gets one.
struct DriverRow {
  struct Body {
    double mass, damping, friction;  // at the handle; guesses, as in the session files
  };
  /// What a hand presses into.
  struct Pressed {
    double stiffness;             // [N/m]
    double depth = 0.02;          // how far behind the wall the hand aims [m]
    double too_stiff = 6000;      // for a wall without limit cycle [N/m]
    double swing = 0.08;          // of the force of a wall without one: a count or two [N]
    Vec3 at_B{}, out_B{0, 0, 1};  // a place on the wall, its normal
  };
  struct Limits {
    double force, torque = 0;  // the device's own [N, N·m]
    double effort;             // of a motor, in the device's unit
    double working;            // of a motor of a hand that presses, at least
    bool is_motors = false;    // the motors yield before that force is reached
    double misled = 2;  // force by wrong counts, over the limit that holds where they are right
  };
  struct Steps {
    double place = 150e-6;                   // of some counts, at the handle [m]
    double turn = 0;                         // the same [rad]; 0: it does not turn
    double force = 0.05;                     // of some units of the motors, and the delay [N]
    double unit_force = 0, unit_torque = 0;  // of a unit of the motors of one with torque
    double share = 0;                        // of a wrench, by the counts of its pose
  };

  const char* name;
  std::unique_ptr<DriverBench> (*open)(const SimulatedHandConfig& hand, const DeviceConfig& config);
  Body body;
  Pressed wall;
  Limits limits;
  Steps steps{};
  std::string_view release;  // the zero of hapticd
  ReleaseBy release_by = ReleaseBy::kWrite;
  const char* describes = " axes";  // in its description
  bool has_currents = false;        // in its line, limited by the config
  bool is_flat = false;             // it moves in the plane z = 0 of B
  bool has_thread = false;          // of transfers, which goes on without the servo
  bool hears_in_silence = false;    // what it is told
  int fewest_samples = 1490;        // of 1500 ticks
  int gone_within = 22;             // ticks without power or plug
  int64_t lets_go_ms = 105;         // after the last write; 0: not at all
  int64_t most_delay_ms = 0;        // of its line, each way; 0: it is not delayed here
  uint32_t stale = kDeviceStale;    // flags of a device whose answers are old
  uint64_t fewest_odd = 0;          // answers that are old, of one that says old ones

  std::vector<Lie> old_answers{Lie::kFrozen, Lie::kOldFirst, Lie::kDelayed};
  std::vector<Lie> noises{Lie::kNoise};
  std::vector<Lie> silences{Lie::kSilent};
  std::vector<Lie> wrong_counts{Lie::kFlipped, Lie::kSlipped};  // honest to the protocol
  std::vector<size_t> wrong_encoders{1};                        // that count wrong
  std::vector<Lie> losses{};                                    // that cost samples, not sense
};

/// One of each driver.
const std::vector<DriverRow>& driver_rows();
/// And others of the same drivers: other lengths, signs, ports, boards.
const std::vector<DriverRow>& driver_variants();
/// The row of a driver.
const DriverRow& driver_row(std::string_view name);

/// A hand of this name that aims `depth` behind the wall, with a tremor of 0.1 mm.
SimulatedHandConfig pressing(const DriverRow& row, const char* hand, double depth);
/// A typical hand that keeps a handle at rest aside of the middle, turned by `turn`.
SimulatedHandConfig holding(const DriverRow& row, double turn = 0);

/// A driver, and a wall under the hand that holds its device.
struct Wall {
  const DriverRow row;
  std::unique_ptr<DriverBench> bench;
  double stiffness = row.wall.stiffness;
  Wrench also_B{};  // beside the wall's force
  DeviceState state{};
  int64_t t_ns = bench->t_ns();
  uint32_t seen = 0;  // flags since the first sample
  int fresh = 0;      // samples

  /// With limits that are the device's own.
  Wall(const DriverRow& of, const SimulatedHandConfig& hand);
  Wall(const DriverRow& of, const SimulatedHandConfig& hand, const DeviceConfig& config);
  /// Of a device with particular options.
  Wall(const DriverRow& of, std::unique_ptr<DriverBench> opened)
      : row(of), bench(std::move(opened)) {}
  /// Pressed by a typical hand until it is well in contact, and believed.
  explicit Wall(const DriverRow& of);

  /// Force of the wall, by the last sample [N].
  double wall_force() const {
    return stiffness * std::max(0.0, -dot(row.wall.out_B, state.X_BH.p - row.wall.at_B));
  }
  template <typename Bench>
  Bench& as() {
    return static_cast<Bench&>(*bench);
  }
  void read();
  void step();
  void run(int ticks);
  /// Ticks until a flag is set; −1: not within so many.
  int ticks_until(uint32_t flags, int most);
  bool has(uint32_t flags) const { return (state.flags & flags) != 0; }
  bool is_working() const { return bench->effort() > row.limits.working; }
  /// Of the force on the hand, over so many ticks [N].
  double swing(int ticks);
};

inline constexpr uint32_t kDoubt = kDeviceStale | kDeviceNoisy;

}  // namespace haptic::test
