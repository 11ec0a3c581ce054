// SPDX-License-Identifier: GPL-3.0-or-later
// The faults that `hapt torture` injects and that reach the servo's step: a handle that turns, with
// the tool off it, presses into a block and is twisted by it. The plant and the promises are
// computed here, for force and torque alike; the server is servo_step alone.
#include <functional>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "proto/math/units.h"
#include "tests/support/servo_tick.h"

using namespace haptic;
using namespace haptic::test;

namespace {

constexpr double kSpringStiffness = 500, kLever = 0.05, kDepth = 4e-3;  // [N/m], [m], [m]
constexpr double kSlew = 200, kTorqueSlew = 4, kSoftStart = 0.1;        // [N/s], [N·m/s], [s]
constexpr double kMaxForce = 3.6, kMaxTorque = 0.15;
constexpr double kDamping = 2, kTurningDamping = 0.01;  // of the passivity controller

/// A handle held at a point; the hand lets it turn about y like a spring with a damper.
struct Wrist {
  double inertia = 1e-4, damping = 5e-3, stiffness = 1;  // [kg·m²], [N·m·s/rad], [N·m/rad]
  double angle = 0, speed = 0;

  void advance(double torque) {
    constexpr int kSteps = 50;
    for (int i = 0; i < kSteps; ++i) {
      speed += kTick / kSteps * (torque - damping * speed - stiffness * angle) / inertia;
      angle += kTick / kSteps * speed;
    }
  }
  double depth() const { return std::max(0.0, kDepth + kLever * std::sin(angle)); }
  /// The wrench of the block on the handle: the force at the tool, and its torque by the lever.
  Wrench wall() const {
    const double force = kSpringStiffness * depth();
    return {{0, 0, force}, {0, -kLever * std::cos(angle) * force, 0}};
  }
};

/// The input and the output of one tick.
struct Tick {
  Wrench felt;
  Wrench wall;        // of the block where the device said the handle is
  double turned = 0;  // since the last sample, as the device said [rad]
  double speed = 0;   // of the handle [rad/s]
  double fade = 0;    // weight of the contacts
  uint32_t fault = 0, flags = 0;
};

/// The promise of a half of the wrench.
struct FaultHalf {
  const char* name;
  Vec3 Wrench::*of;
  double most;    // [N] or [N·m]
  double slew;    // as the place of the handle is fixed: what it may grow by in a tick
  double spring;  // and what it may grow by each radian of the hand's turn
  double damper;  // what the passivity controller may add [N·s/rad] or [N·m·s/rad]
};
constexpr FaultHalf kHalves[]{
    {"force", &Wrench::f, kMaxForce, kSlew* kTick, kLever* kSpringStiffness, kLever* kDamping},
    {"torque", &Wrench::t, kMaxTorque, (kTorqueSlew + kLever * kSlew) * kTick,
     kLever* kLever* kSpringStiffness, kTurningDamping + kLever* kLever* kDamping}};

/// A fault: what it makes of the inputs of a tick.
struct Spoil {
  std::function<void(ServoInput& input, ContactSet& set, int since)> how;
  int age = 0;          // of the contacts, in ticks more than one for each tick of the fault
  bool frozen = false;  // no new contacts at all
  double late = 0;      // of the first tick [s]
  int every = 1;        // ticks from one set of contacts to the next
};

class Session {
 public:
  Session() {
    model_ = plain_model(kSpringStiffness);
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
    control_.translational_stiffness = kSpringStiffness;
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
    const double seconds = kTick + (since == 0 ? spoil.late : 0);
    t_ns_ += static_cast<int64_t>(1e9 * seconds);
    if (!spoil.frozen && since % spoil.every == 0) {
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
    ticks_.push_back({frame.F_device_B, wrist_.wall(), norm(to_rotation_vector(turn)), wrist_.speed,
                      frame.fade, frame.fault, frame.flags});
    REQUIRE(is_finite(frame.X_WT));
    REQUIRE(is_finite(frame.X_WP));
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

/// Names the first promise that is broken of those that hold in every tick, with or without a
/// fault.
std::string broken_always(const std::vector<Tick>& ticks) {
  for (size_t i = 1; i < ticks.size(); ++i) {
    for (const FaultHalf& half : kHalves) {
      const Vec3 &now = ticks[i].felt.*half.of, &last = ticks[i - 1].felt.*half.of;
      const std::string at = std::string(" ") + half.name + " in tick " + std::to_string(i);
      if (!is_finite(now)) return "not finite:" + at;
      if (norm(now) > half.most) return "above the largest:" + at;
      const double length2 = norm_squared(last);
      const double share = length2 > 0 ? std::clamp(dot(now, last) / length2, 0.0, 1.0) : 0;
      const double most = half.slew + half.spring * ticks[i].turned;
      if (norm(now - share * last) > most * (1 + 1e-9)) return "rises too fast:" + at;
    }
  }
  return {};
}

/// True if both halves are the block's, times the gain, within what the passivity controller may
/// add.
bool is_wall(const Tick& tick) {
  return std::all_of(std::begin(kHalves), std::end(kHalves), [&](const FaultHalf& half) {
    return norm(tick.felt.*half.of - tick.wall.*half.of) <=
           half.damper * std::fabs(tick.speed) + 1e-9;
  });
}

/// Zero in each of these ticks.
bool all_zero(const std::vector<Tick>& ticks, size_t from, size_t to) {
  const auto at = [&](size_t i) { return ticks.begin() + static_cast<ptrdiff_t>(i); };
  return std::all_of(at(from), at(to), [](const Tick& tick) { return tick.felt == Wrench{}; });
}

/// From the tick `from` on no more than the share of the soft start, and at its end the wall.
void check_soft_start(const std::vector<Tick>& ticks, size_t from) {
  for (size_t i = from; i < ticks.size(); ++i) {
    const double gain = std::min(1.0, static_cast<double>(i - from + 1) * kTick / kSoftStart);
    for (const FaultHalf& half : kHalves) {
      CAPTURE(half.name, i - from, gain);
      REQUIRE(norm(ticks[i].felt.*half.of) <=
              gain * norm(ticks[i].wall.*half.of) + half.damper * std::fabs(ticks[i].speed) + 1e-9);
    }
  }
  CHECK(is_wall(ticks.back()));
  CHECK(norm(ticks.back().felt.t) > 0.02);
}

}  // namespace

TEST_CASE("faults: without a fault the handle feels the block's force and torque", "[servo]") {
  Session session;
  session.run(300);
  CHECK(broken_always(session.ticks()).empty());
  CHECK(is_wall(session.ticks().back()));
  CHECK(session.ticks().back().felt.f.z > 0.5);
  CHECK(session.ticks().back().felt.t.y < -0.04);
  CHECK(std::fabs(session.wrist().speed) < 1e-3);
}

TEST_CASE("faults: the promises are seen to break", "[servo]") {
  const FaultHalf half = GENERATE(values({kHalves[0], kHalves[1]}));
  INFO(half.name);
  Session session;
  std::vector<Tick> ticks = session.ticks();
  REQUIRE(broken_always(ticks).empty());
  const size_t last = ticks.size() - 1;
  Vec3& felt = ticks[last].felt.*half.of;
  SECTION("what is no number") {
    felt.x = std::numeric_limits<double>::quiet_NaN();
    CHECK(broken_always(ticks).find("not finite") == 0);
  }
  SECTION("what is above the limit") {
    felt = {0, -1.001 * half.most, 0};
    CHECK(broken_always(ticks).find("above") == 0);
  }
  SECTION("what grows along, or across") {
    ticks[last] = ticks[last - 1];
    ticks[last].turned = 0;
    const Vec3 along = normalized(felt);
    felt += 1.01 * half.slew * GENERATE_COPY(values({along, Vec3{1, 0, 0}}));
    CHECK(broken_always(ticks).find("rises") == 0);
  }
}

TEST_CASE("faults: what closes the force closes the torque, until it is cleared", "[servo]") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  struct Row {
    const char* name;
    Fault fault;
    int ticks;  // that it lasts
    std::function<void(ServoInput&, ContactSet&)> how;
  };
  const Row rows[] = {
      {"contact: NaN in an answer", Fault::kContactsNotFinite, 1,
       [&](ServoInput&, ContactSet& set) { set.contacts[0].normal_O.x = nan; }},
      {"contact: infinity in an answer", Fault::kContactsNotFinite, 1,
       [&](ServoInput&, ContactSet& set) { set.contacts[0].object_point_O.z = infinity; }},
      {"device: position that is no number", Fault::kDeviceNotFinite, 1,
       [&](ServoInput& input, ContactSet&) { input.device.X_BH.p.y = nan; }},
      {"device: position that is infinite", Fault::kDeviceNotFinite, 1,
       [&](ServoInput& input, ContactSet&) { input.device.X_BH.p.z = infinity; }},
      {"device: position that is farther than anything", Fault::kDeviceNotFinite, 1,
       [&](ServoInput& input, ContactSet&) { input.device.X_BH.p.x = 1.1e6; }},
      {"device: velocity that nothing has", Fault::kDeviceNotFinite, 1,
       [&](ServoInput& input, ContactSet&) { input.device.V_BH.v.y = -1.1e6; }},
      {"device: orientation that is no number", Fault::kDeviceNotFinite, 1,
       [&](ServoInput& input, ContactSet&) { input.device.X_BH.q.w = nan; }},
      {"device: pose jumps by 0.67 m and back", Fault::kPoseJump, 1,
       [](ServoInput& input, ContactSet&) { input.device.X_BH.p.x += 0.67; }},
      {"device: pose jumps by a metre and goes on lying", Fault::kPoseJump, 60,
       [](ServoInput& input, ContactSet&) { input.device.X_BH.p.x += 1; }},
      {"device: orientation jumps by one radian", Fault::kPoseJump, 1,
       [](ServoInput& input, ContactSet&) {
         input.device.X_BH.q =
             from_rotation_vector(normalized(Vec3{1, -1, 1})) * input.device.X_BH.q;
       }},
      {"device: the same answer always, or old ones", Fault::kDeviceStale, 30,
       [](ServoInput& input, ContactSet&) { input.device.flags |= kDeviceStale; }},
      {"device: noise", Fault::kDeviceNoisy, 30,
       [](ServoInput& input, ContactSet&) { input.device.flags |= kDeviceNoisy; }},
  };
  for (const Row& row : rows) {
    CAPTURE(row.name);
    Session session;
    const size_t begin = session.now();
    session.run(60, {[&](ServoInput& input, ContactSet& set, int since) {
                  if (since < row.ticks) row.how(input, set);
                }});
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

TEST_CASE("faults: a handle that spins feels nothing until it is calm", "[servo]") {
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

TEST_CASE("faults: old contacts are held, faded and gone, and come back by a ramp", "[servo]") {
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
    const double force = left * kSpringStiffness * (kDepth + kLever);
    REQUIRE(norm(ticks[i].felt.f) <= force + 1e-9);
    REQUIRE(norm(ticks[i].felt.t) <= kLever * force + 1e-9);
    REQUIRE(ticks[i].fade <= left + 1e-9);
  }
  CHECK(all_zero(ticks, begin + 151, back));
  CHECK(broken_always(ticks).empty());
  CHECK(is_wall(ticks.back()));
}

TEST_CASE("faults: a contact that is ten times too slow changes nothing", "[servo]") {
  Session session;
  const size_t begin = session.now();
  session.run(400, {{}, 10, false, 0, 10});
  for (size_t i = begin; i < session.now(); ++i) REQUIRE(is_wall(session.ticks()[i]));
}

TEST_CASE("faults: lying planes stay within the limits and the slew", "[servo]") {
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

TEST_CASE("faults: a servo that is late, and was let go, begins at zero", "[servo]") {
  Session session;
  const size_t begin = session.now();
  session.run(600, {[](ServoInput& input, ContactSet&, int since) { input.released = since == 0; },
                    0, false, 0.05});
  const auto& ticks = session.ticks();
  // from zero, whatever was held before
  for (const FaultHalf& half : kHalves) {
    CAPTURE(half.name);
    CHECK(norm(ticks[begin].felt.*half.of) <= half.slew + half.spring * ticks[begin].turned + 1e-9);
  }
  CHECK(broken_always(ticks).empty());
  CHECK(is_wall(ticks.back()));
}

TEST_CASE("faults: a device that is lost or not homed feels nothing, then a soft start",
          "[servo]") {
  const uint32_t away = GENERATE(values({kDeviceLost | kDeviceHomed, kDeviceHeld + 0u}));
  const auto flagged = [](uint32_t flags) {
    return Spoil{[flags](ServoInput& input, ContactSet&, int) { input.device.flags = flags; }};
  };
  Session session;
  const size_t begin = session.now();
  session.run(200, flagged(away));
  const size_t back = session.now();
  session.run(600);
  const auto& ticks = session.ticks();
  CHECK(all_zero(ticks, begin, back + 1));
  for (size_t i = begin; i < back; ++i) REQUIRE((ticks[i].flags & kServoNoDevice) != 0);
  check_soft_start(ticks, back);
  // one missing sample is not a loss
  session.run(1, flagged(kDeviceHeld | kDeviceHomed));
  CHECK(is_wall(ticks.back()));
}
