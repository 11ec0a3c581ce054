// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/support/driver/rows.h"

#include <cmath>
#include <stdexcept>
#include <string>

#include "device-io/hand/impedance.h"
#include "device-io/owndevice/own_device_arm.h"
#include "device-io/polhem/kinematics.h"
#include "device-io/sixmotors/kinematics.h"
#include "device-io/woodenhaptics/kinematics.h"
#include "tests/support/driver/emulated_arm.h"
#include "tests/support/driver/falcon_bench.h"
#include "tests/support/driver/haply_bench.h"
#include "tests/support/driver/hid_arm_bench.h"

namespace haptic::test {
namespace {

using Bench = std::unique_ptr<DriverBench>;

Bench falcon(const SimulatedHandConfig& hand, const DeviceConfig& config) {
  EmulatedFalconOptions options;
  options.hand = hand;
  return std::make_unique<FalconBench>(options, config);
}

Bench hid_arm(const SimulatedHandConfig& hand, const DeviceConfig& config) {
  EmulatedHidArmOptions options;
  options.hand = hand;
  options.arm = config.hid_arm;
  return std::make_unique<HidArmBench>(options, config);
}

Bench other_hid_arm(const SimulatedHandConfig& hand, const DeviceConfig& given) {
  DeviceConfig config = given;
  config.hid_arm.links = {0.111, 0.180, 0.211};
  config.hid_arm.signs = {1, -1, 1};
  config.hid_arm.motor_signs = {-1, 1, -1};
  return hid_arm(hand, config);
}

EmulatedHaplyOptions haply_options(const SimulatedHandConfig& hand, const DeviceConfig& config) {
  EmulatedHaplyOptions options;
  options.hand = hand;
  options.arm = config.pantograph;
  return options;
}

Bench haply(const SimulatedHandConfig& hand, const DeviceConfig& config) {
  return std::make_unique<HaplyBench>(haply_options(hand, config), config);
}

Bench haply_m0(const SimulatedHandConfig& hand, const DeviceConfig& config) {
  EmulatedHaplyOptions options = haply_options(hand, config);
  options.is_m0 = true;
  return std::make_unique<HaplyBench>(options, config);
}

Bench other_haply(const SimulatedHandConfig& hand, const DeviceConfig& config) {
  EmulatedHaplyOptions options = haply_options(hand, config);
  options.arm.sign_1 = -1;
  options.arm.port_1 = 2;
  options.arm.base = 0;
  options.arm.distal = 0.08;
  options.arm.reduction = 2;
  options.home_B = {0, std::sqrt(0.08 * 0.08 - 0.05 * 0.05), 0};
  return std::make_unique<HaplyBench>(options, config);
}

const DriverRow kFalcon{.name = "falcon",
                        .open = falcon,
                        .body = {0.25, 1, 0.3},
                        .wall = {.stiffness = 500, .swing = 0.06},
                        .limits = {.force = 8, .effort = 4095, .working = 200, .misled = 1.01},
                        .steps = {.place = 60e-6, .force = 0.15},
                        .release = "<AAAAAAAAAAAABA>",
                        .release_by = ReleaseBy::kUsbBulk,
                        .has_thread = true,
                        .hears_in_silence = true,
                        .fewest_samples = 1200,  // the chip's millisecond
                        .lets_go_ms = 12,
                        .wrong_counts = {Lie::kFlipped},
                        .losses = {Lie::kHalves, Lie::kLoses}};

const DriverRow kHidArm{.name = "hid arm",
                        .open = hid_arm,
                        .body = {0.15, 0.3, 0.2},
                        .wall = {.stiffness = 500},
                        .limits = {.force = 5, .effort = 3000, .working = 300},
                        .steps = {.force = 0.15},
                        .release = {"\0\0\0\0\0\0\0\0\0", 9},
                        .release_by = ReleaseBy::kHidReport,
                        .has_thread = true,
                        .gone_within = 1,
                        .lets_go_ms = 12,
                        .stale = kDeviceStale | kDeviceLost,
                        .old_answers = {Lie::kFrozen, Lie::kOldFirst, Lie::kDelayed, Lie::kJumps},
                        .silences = {Lie::kSilent, Lie::kHalves},
                        .wrong_counts = {Lie::kFlipped},
                        .losses = {Lie::kLoses}};

const DriverRow kHaply{.name = "haply",
                       .open = haply,
                       .body = {0.1, 0.3, 0.1},
                       .wall = {.stiffness = 300,
                                .depth = 0.008,
                                .swing = 0.04,
                                .at_B = {0, 0.075, 0},
                                .out_B = {0, 1, 0}},
                       .limits = {.force = 5, .effort = 0.123, .working = 0.01, .is_motors = true},
                       .steps = {.force = 0.02},
                       .release = {"\3\3\3\3\3\3\3\3\3\3\2\x11\0\0\0\0\0\0\0\0", 20},
                       .describes = "2 axes",
                       .is_flat = true,
                       .lets_go_ms = 0,
                       .most_delay_ms = 8,
                       .fewest_odd = 8,
                       .wrong_counts = {Lie::kFlipped, Lie::kFrozenCounts},
                       .losses = {Lie::kLoses}};

const DriverRow kPolhem{.name = "polhem",
                        .open = open_line<&polhem_arm>,
                        .body = {0.3, 0.3, 0.2},
                        .wall = {.stiffness = 400, .too_stiff = 8000, .swing = 0.06},
                        .limits = {.force = 5, .effort = 3000, .working = 200},
                        .steps = {.turn = 0.02},
                        .release = "[0,0,0]\n",
                        .describes = "6 axes, 3 of them driven (torque is dropped)",
                        .has_currents = true,
                        .most_delay_ms = 15,
                        .noises = {Lie::kNoise, Lie::kTurnNoise},
                        .wrong_encoders = {1, 2}};

const DriverRow kWoodenHaptics{.name = "woodenhaptics",
                               .open = open_line<&woodenhaptics_arm>,
                               .body = {0.15, 0.3, 0.2},
                               .wall = {.stiffness = 500},
                               .limits = {.force = 5, .effort = 3000, .working = 300},
                               .release = "[0,0,0]\n",
                               .has_currents = true,
                               .most_delay_ms = 15,
                               .wrong_encoders = {0, 1, 2}};

// what half a milliampere in each motor makes at most: the column sums of J⁻ᵀ, from the numbers of
// the description alone: 0.2 m of lever for the arm, the wrist's ratios
const DriverRow kSixMotors{
    .name = "six motors",
    .open = open_line<&six_motors_arm>,
    .body = {0.15, 0.3, 0.2},
    .wall = {.stiffness = 500},
    .limits = {.force = 5, .torque = 0.3, .effort = 3000, .working = 300},
    .steps = {.turn = 1e-3, .unit_force = 5e-3, .unit_torque = 2e-4, .share = 2e-3},
    .release = "[0,0,0,0,0,0]\n",
    .has_currents = true,
    .most_delay_ms = 15,
    .noises = {Lie::kNoise, Lie::kTurnNoise},
    .wrong_encoders = {1, 2, 5}};

// its counts are micrometres: one that jumps by 60 of them is no noise
const DriverRow kOwnDevice{
    .name = "own device",
    .open = open_line<&own_device_arm>,
    .body = {0.15, 0.3, 0.2},
    .wall = {.stiffness = 500},
    .limits = {.force = 30, .torque = 0.6, .effort = 6000, .working = 300},
    .steps = {.place = 10e-6, .turn = 1e-3, .unit_force = 2.5e-3, .unit_torque = 5e-5},
    .release = "[0,0,0,0,0,0]\n",
    .most_delay_ms = 15,
    .noises = {},
    .wrong_encoders = {1, 2, 5}};

DriverRow variant(DriverRow row, const char* name, decltype(DriverRow::open) open) {
  row.name = name;
  row.open = open;
  return row;
}

/// One that leaves the limits to the device.
DeviceConfig unlimited() {
  DeviceConfig config;
  config.max_force = config.max_torque = 100;
  return config;
}

}  // namespace

const std::vector<DriverRow>& driver_rows() {
  static const std::vector<DriverRow> kAll{kFalcon,        kHidArm,    kHaply,    kPolhem,
                                           kWoodenHaptics, kSixMotors, kOwnDevice};
  return kAll;
}

const std::vector<DriverRow>& driver_variants() {
  static const std::vector<DriverRow> kAll{
      variant(kHidArm, "hid arm of other lengths and signs", other_hid_arm),
      variant(kHaply, "haply on an M0", haply_m0),
      variant(kHaply, "haply of other lengths, signs and ports", other_haply)};
  return kAll;
}

const DriverRow& driver_row(std::string_view name) {
  for (const DriverRow& row : driver_rows()) {
    if (row.name == name) return row;
  }
  throw std::logic_error("no driver " + std::string(name));
}

SimulatedHandConfig pressing(const DriverRow& row, const char* hand, double depth) {
  SimulatedHandConfig config;
  config.mass = row.body.mass;
  config.damping = row.body.damping;
  config.coulomb_friction = row.body.friction;
  config.inertia = row.steps.turn > 0 ? 1e-4 : 0;
  put_into_hand(*find_hand(hand), config);
  IntentConfig& intent = config.intent;
  intent.centre_B = row.wall.at_B - depth * row.wall.out_B;
  intent.direction_B = row.wall.out_B;
  intent.hover_radius = intent.press_radius = intent.stroke_angle = 0;
  intent.tremor_amplitude = 1e-4;
  return config;
}

SimulatedHandConfig holding(const DriverRow& row, double turn) {
  SimulatedHandConfig config = pressing(row, "typical", 0);
  config.intent.centre_B = {0.03, 0.05, -0.02};
  config.intent.tremor_amplitude = 0;
  config.intent.turn_angle = turn;
  return config;
}

Wall::Wall(const DriverRow& of, const SimulatedHandConfig& hand) : Wall(of, hand, unlimited()) {}

Wall::Wall(const DriverRow& of, const SimulatedHandConfig& hand, const DeviceConfig& config)
    : Wall(of, of.open(hand, config)) {}

Wall::Wall(const DriverRow& of) : Wall(of, pressing(of, "typical", of.wall.depth)) {
  run(1100);
  if (!is_working() || (seen & kDoubt) != 0) throw std::runtime_error("it is not pressed");
}

void Wall::read() {
  t_ns += 1'000'000;
  fresh += bench->read({t_ns, t_ns}, state) ? 1 : 0;
  if (fresh > 0) seen |= state.flags;
}

void Wall::step() {
  read();
  const Wrench wall_B{wall_force() * row.wall.out_B + also_B.f, also_B.t};
  bench->write(has(kDeviceLost | kDoubt) ? Wrench{} : wall_B);
}

void Wall::run(int ticks) {
  for (int i = 0; i < ticks; ++i) step();
}

int Wall::ticks_until(uint32_t flags, int most) {
  for (int i = 0; i < most; ++i) {
    step();
    if (has(flags)) return i + 1;
  }
  return -1;
}

double Wall::swing(int ticks) {
  double least = 1e9, most = -1e9;
  for (int i = 0; i < ticks; ++i) {
    step();
    const double force = dot(row.wall.out_B, bench->felt_B().f);
    least = std::min(least, force);
    most = std::max(most, force);
  }
  return most - least;
}

}  // namespace haptic::test
