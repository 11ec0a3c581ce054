// SPDX-License-Identifier: GPL-3.0-or-later
// The twins of torque of the faults that `hapt torture` injects: a handle that turns, with the tool
// off it, presses into a block and is twisted by it. The plant and the promises are computed here;
// the server is servo_step alone.
#include <functional>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "tests/support/servo_tick.h"

using namespace haptic;
using namespace haptic::test;

namespace {

constexpr double kStiffness = 500, kLever = 0.05, kDepth = 4e-3;  // [N/m], [m], [m]
constexpr double kDt = 1e-3;
constexpr double kSlew = 200, kTorqueSlew = 4, kSoftStart = 0.1;  // [N/s], [N·m/s], [s]
constexpr double kMaxForce = 3.6, kMaxTorque = 0.15;
constexpr double kDamping = 2, kTurningDamping = 0.01;  // of the passivity controller

/// A handle held at a point; the hand lets it turn about y like a spring with a damper.
struct Wrist {
  double inertia = 1e-4, damping = 5e-3, stiffness = 1;  // [kg·m²], [N·m·s/rad], [N·m/rad]
  double angle = 0, speed = 0;

  void advance(double torque) {
    constexpr int kSteps = 50;
    for (int i = 0; i < kSteps; ++i) {
      speed += kDt / kSteps * (torque - damping * speed - stiffness * angle) / inertia;
      angle += kDt / kSteps * speed;
    }
  }
  double depth() const { return std::max(0.0, kDepth + kLever * std::sin(angle)); }
  /// Of the block on the handle: the force at the tool by its lever.
  double wall() const { return -kLever * std::cos(angle) * kStiffness * depth(); }
};

/// What one tick was told and did.
struct Tick {
  Vec3 torque;
  double wall = 0;       // torque of the block where the device said the handle is
  double turned = 0;     // since the last sample, as the device said [rad]
  double speed = 0;      // of the handle [rad/s]
  double seconds = kDt;  // since the last tick
  uint32_t fault = 0;
};

/// A fault: what it makes of the inputs of a tick.
struct Spoil {
  std::function<void(ServoInput& input, ContactSet& set, int since)> how;
  int age = 0;          // of the contacts, in ticks more than one for each tick of the fault
  bool frozen = false;  // no new contacts at all
  double late = 0;      // of the first tick [s]
};

class Session {
 public:
  Session() {
    model_ = plain_model(kStiffness);
    model_.map.X_HT.p = {kLever, 0, 0};
    SafetyLimits& limits = model_.limits;
    limits.max_force = kMaxForce;
    limits.max_torque = kMaxTorque;
    limits.slew = kSlew;
    limits.torque_slew = kTorqueSlew;
    limits.soft_start = kSoftStart;
    limits.max_damping = kDamping;
    limits.max_rotational_damping = kTurningDamping;
    control_.armed = 1;
    control_.translational_stiffness = kStiffness;
    run(1500);
  }

  void run(int ticks, const Spoil& spoil = {}) {
    for (int k = 0; k < ticks; ++k) step(spoil, k);
  }
  void clear() { ++control_.fault_clears; }
  const std::vector<Tick>& ticks() const { return ticks_; }
  size_t now() const { return ticks_.size(); }
  const Wrist& wrist() const { return wrist_; }

 private:
  void step(const Spoil& spoil, int since) {
    const double seconds = kDt + (since == 0 ? spoil.late : 0);
    t_ns_ += static_cast<int64_t>(1e9 * seconds);
    if (!spoil.frozen) {
      fresh_ = set_of({plane({0, 0, 1}, {}, 0.2)});
      fresh_->seq = ++seq_;
      fresh_->answers_t_ns = t_ns_ - kMs * (1 + spoil.age);
    }
    auto set = std::make_unique<ContactSet>(*fresh_);
    ServoInput input = input_at(t_ns_ / kMs, {0, 0, -kDepth}, set.get());
    input.t_ns = input.device.t_ns = t_ns_;
    input.control = &control_;
    input.device.X_BH.q = from_rotation_vector({0, wrist_.angle, 0});
    input.device.V_BH.w = {0, wrist_.speed, 0};
    if (spoil.how) spoil.how(input, *set, since);
    const ServoFrame frame = servo_step(model_, state_, input);
    const Quat turn = input.device.X_BH.q * conjugate(said_);
    ticks_.push_back({frame.F_device_B.t, wrist_.wall(), norm(to_rotation_vector(turn)),
                      wrist_.speed, seconds, frame.fault});
    said_ = input.device.X_BH.q;
    wrist_.advance(frame.F_device_B.t.y);
  }

  ServoModel model_;
  ServoState state_;
  ControlFrame control_{};
  Wrist wrist_;
  std::unique_ptr<ContactSet> fresh_;
  std::vector<Tick> ticks_;
  Quat said_;
  uint64_t seq_ = 0;
  int64_t t_ns_ = 0;
};

/// What holds in every tick, with or without a fault: the first promise that is broken.
std::string broken_always(const std::vector<Tick>& ticks) {
  for (size_t i = 1; i < ticks.size(); ++i) {
    const Tick& tick = ticks[i];
    const std::string at = " in tick " + std::to_string(i);
    if (!is_finite(tick.torque)) return "not finite" + at;
    if (norm(tick.torque) > kMaxTorque) return "above the largest torque" + at;
    // the place of the handle is fixed: the force grows by slew and by the turn of the lever
    const double force = kSlew * kDt + kLever * kStiffness * tick.turned;
    const double most = kTorqueSlew * kDt + kLever * force;
    const Vec3& last = ticks[i - 1].torque;
    const double length2 = norm_squared(last);
    const double share = length2 > 0 ? std::clamp(dot(tick.torque, last) / length2, 0.0, 1.0) : 0;
    if (norm(tick.torque - share * last) > most * (1 + 1e-9)) return "rises too fast" + at;
  }
  return {};
}

bool is_zero(const Tick& tick) {
  return tick.torque == Vec3{};
}

/// Within what the passivity controller may add.
bool is_wall(const Tick& tick) {
  const double damper = (kTurningDamping + kLever * kLever * kDamping) * std::fabs(tick.speed);
  return norm(tick.torque - Vec3{0, tick.wall, 0}) <= damper + 1e-9;
}

/// Zero in each of these ticks.
bool all_zero(const std::vector<Tick>& ticks, size_t from, size_t to) {
  for (size_t i = from; i < to; ++i) {
    if (!is_zero(ticks[i])) return false;
  }
  return true;
}

/// From the tick `from` on no more than the share of the soft start, and at its end the wall.
void check_soft_start(const std::vector<Tick>& ticks, size_t from) {
  for (size_t i = from; i < ticks.size(); ++i) {
    const double gain = std::min(1.0, static_cast<double>(i - from + 1) * kDt / kSoftStart);
    const double damper =
        (kTurningDamping + kLever * kLever * kDamping) * std::fabs(ticks[i].speed);
    CAPTURE(i - from, ticks[i].wall, gain);
    REQUIRE(norm(ticks[i].torque) <= gain * std::fabs(ticks[i].wall) + damper + 1e-9);
  }
  CHECK(is_wall(ticks.back()));
  CHECK(norm(ticks.back().torque) > 0.02);
}

}  // namespace

TEST_CASE("torque faults: without a fault the handle feels the block's torque", "[servo]") {
  Session session;
  session.run(300);
  CHECK(broken_always(session.ticks()).empty());
  CHECK(is_wall(session.ticks().back()));
  CHECK(session.ticks().back().torque.y < -0.04);
  CHECK(std::fabs(session.wrist().speed) < 1e-3);
}

TEST_CASE("torque faults: the promises are seen to break", "[servo]") {
  Session session;
  std::vector<Tick> ticks = session.ticks();
  REQUIRE(broken_always(ticks).empty());
  const size_t last = ticks.size() - 1;
  SECTION("a torque that is no number") {
    ticks[last].torque.x = std::numeric_limits<double>::quiet_NaN();
    CHECK(broken_always(ticks).find("not finite") == 0);
  }
  SECTION("a torque above the limit") {
    ticks[last].torque = {0, -0.1501, 0};
    CHECK(broken_always(ticks).find("above") == 0);
  }
  SECTION("a torque that grows along, or across") {
    const double step = 1.01 * (kTorqueSlew + kLever * kSlew) * kDt;
    ticks[last] = ticks[last - 1];
    ticks[last].turned = 0;
    ticks[last].torque += GENERATE(Vec3{0, -1, 0}, Vec3{1, 0, 0}) * step;
    CHECK(broken_always(ticks).find("rises") == 0);
  }
}

TEST_CASE("torque faults: what closes the force closes the torque, until it is cleared",
          "[servo]") {
  using Cause = std::function<void(ServoInput&, ContactSet&, int)>;
  const auto once = [](const Cause& cause) {
    return [cause](ServoInput& input, ContactSet& set, int since) {
      if (since == 0) cause(input, set, since);
    };
  };
  struct Row {
    const char* name;
    Cause how;
    Fault fault;
  };
  const Row rows[] = {
      {"contact: NaN in an answer", once([](ServoInput&, ContactSet& set, int) {
         set.contacts[0].normal_O.x = std::numeric_limits<double>::quiet_NaN();
       }),
       Fault::kContactsNotFinite},
      {"contact: infinity in an answer", once([](ServoInput&, ContactSet& set, int) {
         set.contacts[0].object_point_O.z = std::numeric_limits<double>::infinity();
       }),
       Fault::kContactsNotFinite},
      {"device: orientation that is no number", once([](ServoInput& input, ContactSet&, int) {
         input.device.X_BH.q.w = std::numeric_limits<double>::quiet_NaN();
       }),
       Fault::kDeviceNotFinite},
      {"device: orientation jumps by one radian", once([](ServoInput& input, ContactSet&, int) {
         input.device.X_BH.q =
             from_rotation_vector(normalized(Vec3{1, -1, 1})) * input.device.X_BH.q;
       }),
       Fault::kPoseJump},
      {"device: the same answer always, or old ones",
       [](ServoInput& input, ContactSet&, int since) {
         if (since < 30) input.device.flags |= kDeviceStale;
       },
       Fault::kDeviceStale},
      {"device: noise",
       [](ServoInput& input, ContactSet&, int since) {
         if (since < 30) input.device.flags |= kDeviceNoisy;
       },
       Fault::kDeviceNoisy},
  };
  for (const Row& row : rows) {
    CAPTURE(row.name);
    Session session;
    const size_t begin = session.now();
    session.run(60, {row.how});
    const size_t cleared = session.now();
    session.clear();
    session.run(600);
    const auto& ticks = session.ticks();
    CHECK(static_cast<Fault>(ticks[cleared - 1].fault) == row.fault);
    // in the tick in which it was seen
    CHECK(all_zero(ticks, begin, cleared));
    // clearing waits for a handle that is calm
    size_t open = cleared;
    while (open < ticks.size() && ticks[open].fault != 0) ++open;
    REQUIRE(open < ticks.size() - 300);
    CHECK(all_zero(ticks, cleared, open + 1));
    check_soft_start(ticks, open);
  }
}

TEST_CASE("torque faults: a handle that spins feels nothing until it is calm", "[servo]") {
  Session session;
  const size_t begin = session.now();
  session.run(30, {[](ServoInput& input, ContactSet&, int since) {
                input.device.V_BH.w = {0, 0, since < 10 ? 21.0 : 2.0};
              }});
  const size_t calm = session.now();
  session.run(600);
  CHECK(all_zero(session.ticks(), begin, calm));
  CHECK(session.ticks()[calm].fault == 0);
  CHECK(is_wall(session.ticks().back()));
  CHECK(broken_always(session.ticks()).empty());
}

TEST_CASE("torque faults: old contacts are held, faded and gone, and come back by a ramp",
          "[servo]") {
  // contact is dead, or a thousand times too slow: held at most 100 ms, faded over 50 ms
  Session session;
  const size_t begin = session.now();
  session.run(300, {{}, 0, true});
  const size_t back = session.now();
  session.run(600);
  const auto& ticks = session.ticks();
  CHECK(is_wall(ticks[begin + 5]));
  for (size_t i = begin; i < back; ++i) {
    const double gone = (150.0 - static_cast<double>(i - begin)) / 50;
    const double left = std::clamp(gone, 0.0, 1.0);
    CAPTURE(i - begin);
    REQUIRE(norm(ticks[i].torque) <= left * kLever * kStiffness * (kDepth + kLever) + 1e-9);
  }
  CHECK(all_zero(ticks, begin + 151, back));
  CHECK(broken_always(ticks).empty());
  CHECK(is_wall(ticks.back()));
}

TEST_CASE("torque faults: a contact that is ten times too slow changes nothing", "[servo]") {
  Session session;
  const size_t begin = session.now();
  session.run(400, {{}, 10, false});
  for (size_t i = begin; i < session.now(); ++i) REQUIRE(is_wall(session.ticks()[i]));
}

TEST_CASE("torque faults: lying planes stay within the limits and the slew", "[servo]") {
  std::mt19937 rng(7);
  std::uniform_real_distribution<double> unit(-1, 1);
  Session session;
  const auto lie = [&](ServoInput&, ContactSet& set, int) {
    set.contacts[0] = plane(normalized(Vec3{unit(rng), unit(rng), 1 + unit(rng)}),
                            0.02 * Vec3{unit(rng), unit(rng), unit(rng)}, 0.2);
  };
  session.run(2000, {lie});
  session.run(600);
  CHECK(broken_always(session.ticks()) == "");
  CHECK(is_wall(session.ticks().back()));
}

TEST_CASE("torque faults: a servo that is late, and was let go, begins at zero", "[servo]") {
  Session session;
  const size_t begin = session.now();
  session.run(600, {[](ServoInput& input, ContactSet&, int since) { input.released = since == 0; },
                    0, false, 0.05});
  const auto& ticks = session.ticks();
  // from zero, whatever was held before
  CHECK(norm(ticks[begin].torque) <= (kTorqueSlew + kLever * kSlew) * kDt +
                                         kLever * kLever * kStiffness * ticks[begin].turned + 1e-9);
  CHECK(broken_always(ticks).empty());
  CHECK(is_wall(ticks.back()));
}

TEST_CASE("torque faults: a device that is away feels nothing, then a soft start", "[servo]") {
  Session session;
  const size_t begin = session.now();
  session.run(200, {[](ServoInput& input, ContactSet&, int) {
                input.device.flags = kDeviceLost | kDeviceHomed;
              }});
  const size_t back = session.now();
  session.run(600);
  CHECK(all_zero(session.ticks(), begin, back + 1));
  check_soft_start(session.ticks(), back);
}
