// SPDX-License-Identifier: GPL-3.0-or-later
// The force check on one correct log and one breach of each kind.
#include "clients/lab/torture/force_judge.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <functional>

#include "device-io/emulator/log.h"
#include "device-io/emulator/log_reader.h"
#include "device-io/sixmotors/kinematics.h"
#include "proto/math/units.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/tip.h"

namespace haptic {
namespace {

using Records = std::vector<EmulatorRecord>;

constexpr int64_t kFirstNs = 5'000 * kMs;
constexpr double kDepth = 5e-3;         // where the hand presses [m]
constexpr double kWall = 500 * kDepth;  // [N]
const ForceRules kRules;
const Arm& kArm = woodenhaptics_arm();

/// Encoder counts at a depth below the wall and a distance to the side.
MotorCounts counts_at(double depth, double aside = 0) {
  JointAngles angles{};
  REQUIRE(kArm.solve({{aside, 0, -depth}, {}}, angles));
  return kArm.counts(angles);
}

/// The spring force required by the rules, from the encoder counts.
double spring_at(double depth) {
  const Vec3 tip_B = test::tip_at(counts_at(depth));
  return kRules.stiffness * -tip_B.z;
}

/// [mA]
Milliamperes currents_for(const MotorCounts& counts, const Wrench& F_B,
                          const Arm& arm = woodenhaptics_arm()) {
  MotorEfforts amperes;
  REQUIRE(arm.efforts(arm.angles(counts), {}, F_B, amperes));
  Milliamperes out{};
  for (size_t k = 0; k < amperes.size(); ++k) {
    out[k] = static_cast<int32_t>(std::lround(1e3 * amperes[k]));
  }
  return out;
}

/// A second of commands, one per millisecond, with what is felt at time t [ms].
Records account_at(const Arm& arm, const MotorCounts& counts,
                   const std::function<Wrench(double)>& felt) {
  Records out;
  for (int i = 0; i < 1000; ++i) {
    EmulatorRecord r{};
    r.t_ns = kFirstNs + i * kMs;
    r.commands = static_cast<uint64_t>(i) + 1;
    r.counts = r.answered = r.said_first = counts;
    const Wrench F_B = felt(i);
    r.force_B = F_B.f;
    r.torque_B = F_B.t;
    r.currents = currents_for(counts, F_B, arm);
    r.motors_on = 1;
    out.push_back(r);
  }
  return out;
}

/// Records of a force that is this share of the spring.
Records account(const std::function<double(double)>& share, double depth = kDepth) {
  return account_at(woodenhaptics_arm(), counts_at(depth), [&](double t) {
    return Wrench{{0, 0, share(t) * spring_at(depth)}, {}};
  });
}

JudgedFault fault(Effect effect, double begin_ms, double over_ms) {
  const auto at = [](double ms) { return kFirstNs + static_cast<int64_t>(ms * kMs); };
  return {effect, at(begin_ms), over_ms > 0 ? at(over_ms) : 0, 0, {}};
}

bool breaks(const ForceVerdict& verdict, ForceBreach breach) {
  return std::any_of(verdict.violations.begin(), verdict.violations.end(),
                     [&](const ForceViolation& v) { return v.breach == breach; });
}

double full(double) {
  return 1;
}

/// Full force for 20 ms after 100 ms, faded over 50 ms, back at 500 ms by a ramp of 50 ms.
double faded(double t) {
  if (t < 300) return std::clamp(1 - (t - 120) / 50, 0.0, 1.0);
  return std::clamp((t - 500) / 50, 0.0, 1.0);
}

/// Zero from 105 ms to 500 ms, then a soft start of 100 ms.
double closed(double t) {
  if (t < 105) return 1;
  return std::clamp((t - 500) / 100, 0.0, 1.0);
}

}  // namespace

TEST_CASE("judge: a wall, a fade and a soft start break nothing, and the zero is timed") {
  struct Row {
    double (*share)(double);
    JudgedFault fault;
    std::optional<int64_t> zero_after_ns;
  };
  for (const Row& row : {Row{full, fault(Effect::kNothing, 100, 600), {}},
                         Row{faded, fault(Effect::kFade, 100, 500), 70 * kMs},
                         Row{closed, fault(Effect::kZero, 100, 500), 5 * kMs},
                         // nor if the start of the next servo is unknown
                         Row{closed, fault(Effect::kZero, 100, 0), 5 * kMs}}) {
    const ForceVerdict verdict = judge_force(kRules, account(row.share), row.fault);
    CHECK(verdict.violations.empty());
    CHECK(verdict.zero_after_ns == row.zero_after_ns);
  }
}

TEST_CASE("judge: a body that hangs from a resting hand may swing, and nothing else") {
  ForceRules rules = kRules;
  rules.weight = 0.98;
  rules.sway = 0.2;
  rules.pressing = 0;
  rules.in_a_row = 100;
  const auto hanging = [](const std::function<double(double)>& force) {
    return account_at(woodenhaptics_arm(), counts_at(0), [&](double t) {
      return Wrench{{0, 0, force(t)}, {}};
    });
  };
  const auto swings = [](double t) { return -0.98 + 0.19 * std::sin(0.07 * t); };
  const JudgedFault nothing = fault(Effect::kNothing, 100, 600);
  CHECK(judge_force(rules, hanging(swings), nothing).violations.empty());
  CHECK(whole_again(rules, hanging(swings), kFirstNs + 10 * kMs) == kFirstNs + 10 * kMs);
  const auto drops = [](double t) { return t < 300 ? -0.98 : -1.25; };
  CHECK(breaks(judge_force(rules, hanging(drops), nothing), ForceBreach::kChanged));
  CHECK(breaks(judge_force(rules, hanging(drops), nothing), ForceBreach::kBeyondWall));
  CHECK(!whole_again(rules, hanging(drops), kFirstNs + 250 * kMs));
  // a block below the hand pushes it up instead
  CHECK(breaks(judge_force(rules, hanging([](double) { return 0.98; }), nothing),
               ForceBreach::kChanged));
  // it swings after a standstill of the machine
  JudgedFault stood = nothing;
  stood.stalls = {{kFirstNs + 280 * kMs, kFirstNs + 300 * kMs}};
  const auto swung = [&](double t) { return t < 300 || t > 400 ? -0.98 : -1.25; };
  CHECK(judge_force(rules, hanging(swung), stood).violations.empty());
  // or falls, if that closed the force; without a standstill that is a violation
  const auto falls = [](double t) { return t < 300 ? -0.98 : 0.0; };
  CHECK(judge_force(rules, hanging(falls), stood).violations.empty());
  CHECK(breaks(judge_force(rules, hanging(falls), nothing), ForceBreach::kChanged));
  const auto falls_later = [](double t) { return t < 590 ? -0.98 : 0.0; };
  stood.stalls = {{kFirstNs + 180 * kMs, kFirstNs + 200 * kMs}};
  CHECK(breaks(judge_force(rules, hanging(falls_later), stood), ForceBreach::kChanged));
}

TEST_CASE("judge: a zero that came before the time of the fault was noted is in time") {
  // the last command at 99 ms; the injector stalls until 130 ms
  Records records = account([](double t) { return t < 99 ? 1.0 : 0.0; });
  records.resize(100);
  EmulatorRecord watchdog = records.back();
  watchdog.event = EmulatorEvent::kWatchdog;
  watchdog.t_ns += 100 * kMs;
  records.push_back(watchdog);
  JudgedFault late = fault(Effect::kZero, 130, 0);
  CHECK(judge_force(kRules, records, late).violations.empty());
  CHECK(judge_force(kRules, records, late).zero_after_ns == 0);
  // the firmware's watchdog alone is too late
  records[99].force_B = records[98].force_B;
  CHECK(breaks(judge_force(kRules, records, late), ForceBreach::kLateZero));
}

TEST_CASE("judge: a fault that has to be found may last so much longer, and no longer") {
  const auto found = [](double t) { return t < 190 ? 1.0 : 0.0; };
  JudgedFault lie = fault(Effect::kZero, 100, 0);
  lie.is_misled = true;
  ForceRules rules = kRules;
  CHECK(breaks(judge_force(rules, account(found), lie), ForceBreach::kLateZero));
  rules.zero_ns = 100 * kMs;
  CHECK(judge_force(rules, account(found), lie).violations.empty());
  rules.zero_ns = 80 * kMs;
  CHECK(breaks(judge_force(rules, account(found), lie), ForceBreach::kLateZero));
}

TEST_CASE("judge: the currents of a pose that a lying device has said are judged there") {
  // the device reports a depth of 4 mm but is 30 mm nearer, where the same currents give more force
  Records records = account(full);
  const MotorCounts truth = counts_at(kDepth, -30e-3);
  double most = 0;
  for (EmulatorRecord& r : records) {
    const MotorEfforts amperes{1e-3 * r.currents[0], 1e-3 * r.currents[1], 1e-3 * r.currents[2]};
    r.counts = truth;
    r.force_B = kArm.wrench(kArm.angles(truth), amperes).f;
    most = std::max(most, norm(r.force_B));
  }
  REQUIRE(most > 1.01 * spring_at(kDepth));
  JudgedFault lie = fault(Effect::kLimits, 1, 0);
  CHECK(breaks(judge_force(kRules, records, lie), ForceBreach::kBeyondWall));
  lie.is_misled = true;
  CHECK(judge_force(kRules, records, lie).violations.empty());
  // a tenth more than the wall at the reported pose
  for (EmulatorRecord& r : records) {
    r.currents = currents_for(r.answered, {{0, 0, 1.1 * spring_at(kDepth)}, {}});
  }
  CHECK(breaks(judge_force(kRules, records, lie), ForceBreach::kBeyondWall));
}

TEST_CASE("judge: of old answers in front of new ones a command may follow either") {
  Records records = account(full);
  const MotorCounts old = counts_at(kDepth + 2e-3);
  for (size_t i = 300; i < records.size(); i += 2) {
    EmulatorRecord& r = records[i];
    r.said_first = old;
    r.currents = currents_for(old, {{0, 0, spring_at(kDepth + 2e-3)}, {}});
    r.force_B = {0, 0, spring_at(kDepth + 2e-3)};
  }
  JudgedFault lie = fault(Effect::kLimits, 300, 0);
  lie.is_misled = true;
  CHECK(judge_force(kRules, records, lie).violations.empty());
  for (EmulatorRecord& r : records) r.said_first = r.answered;
  CHECK(breaks(judge_force(kRules, records, lie), ForceBreach::kBeyondWall));
}

TEST_CASE("judge: a zero before the stated time may be another's, and force may follow it") {
  // a pose that asks for nothing, or a servo that was let go
  const auto chance = [](double t) { return t < 150 && t != 110 ? 0.1 : 0.0; };
  const JudgedFault lie = fault(Effect::kZero, 100, 500);
  ForceRules rules = kRules;
  CHECK(breaks(judge_force(rules, account(chance), lie), ForceBreach::kLateZero));
  rules.zero_ns = 100 * kMs;
  CHECK(judge_force(rules, account(chance), lie).violations.empty());
  // once the documented time is over it stays
  const auto again = [](double t) { return t < 150 || t == 300 ? 0.1 : 0.0; };
  CHECK(breaks(judge_force(rules, account(again), lie), ForceBreach::kEarlyReturn));
}

TEST_CASE("judge: a violation says what it was, when, how much, and what was allowed") {
  const auto only = [](const Records& records, const JudgedFault& f) {
    const ForceVerdict verdict = judge_force(kRules, records, f);
    REQUIRE(verdict.violations.size() == 1);
    return verdict.violations.front();
  };
  const double deep = 7.5e-3;  // 3.75 N
  const auto verdict = judge_force(kRules, account(full, deep), fault(Effect::kNothing, 100, 600));
  REQUIRE(breaks(verdict, ForceBreach::kTooStrong));
  const ForceViolation& strong = verdict.violations.front();
  CHECK(strong.force == Approx(3.75).margin(0.05));
  CHECK(strong.allowed == Approx(3.605));
  const auto spike = account([](double t) { return t == 400 ? 1.02 : 1; });
  const ForceViolation beyond = only(spike, fault(Effect::kFade, 100, 110));
  CHECK(beyond.breach == ForceBreach::kBeyondWall);
  CHECK(beyond.t_ns == kFirstNs + 400 * kMs);
  const auto step = account([](double t) { return t < 300 ? faded(t) : t < 500 ? 0 : 1; });
  const ForceViolation rise = only(step, fault(Effect::kFade, 100, 500));
  CHECK(rise.breach == ForceBreach::kRise);
  // 200 N/s over two ticks plus twice the step of the currents
  CHECK(rise.allowed == Approx(0.41));
  Records gap = account(full);
  gap.erase(gap.begin() + 400);
  CHECK(only(gap, fault(Effect::kNothing, 100, 600)).breach == ForceBreach::kLostRecord);
  const auto hard =
      account([](double t) { return t < 500 ? closed(t) : std::clamp((t - 500) / 25, 0.0, 1.0); });
  CHECK(only(hard, fault(Effect::kZero, 100, 500)).breach == ForceBreach::kHardStart);
  // where the next servo's start is unknown too
  CHECK(breaks(judge_force(kRules, hard, fault(Effect::kZero, 100, 0)), ForceBreach::kHardStart));
}

TEST_CASE("judge: planes that are not there may push beyond the wall, but not in a step") {
  // to 1.2 times the wall: within 5 ms, and within one
  const auto lied = [](double time) {
    return account([time](double t) { return 1 + 0.2 * std::clamp((t - 200) / time, 0.0, 1.0); });
  };
  CHECK(judge_force(kRules, lied(5), fault(Effect::kLies, 100, 300)).violations.empty());
  const auto verdict = judge_force(kRules, lied(1), fault(Effect::kLies, 100, 300));
  REQUIRE(verdict.violations.size() == 1);
  CHECK(verdict.violations.front().breach == ForceBreach::kRise);
}

TEST_CASE("judge: what broke before a fault is not the fault's, and hides nothing of it") {
  const auto records = account([](double t) { return t == 60 || t == 400 ? 1.02 : 1; });
  JudgedFault f = fault(Effect::kLimits, 100, 110);
  f.from_ns = kFirstNs + 90 * kMs;
  const auto verdict = judge_force(kRules, records, f);
  REQUIRE(verdict.violations.size() == 1);
  CHECK(verdict.violations.front().t_ns == kFirstNs + 400 * kMs);
}

TEST_CASE("judge: commands that a sleeping device read late may follow each other closely") {
  // the zero at 400 ms, then the slew limit; the device slept until 409.7 ms and read two at once
  Records records =
      account([](double t) { return t < 400 ? 1 : std::min(1.0, (t - 400) * 0.2 / kWall); });
  const auto asleep = [](const EmulatorRecord& r) {
    return r.t_ns > kFirstNs + 400 * kMs && r.t_ns < kFirstNs + 410 * kMs;
  };
  const auto first = std::find_if(records.begin(), records.end(), asleep);
  for (auto r = first; r != records.end() && asleep(*r); ++r) {
    r->t_ns = kFirstNs + 409 * kMs + 700'000 + 10'000 * (r - first);
  }
  JudgedFault f = fault(Effect::kLimits, 300, 310);
  CHECK(breaks(judge_force(kRules, records, f), ForceBreach::kRise));
  f.stalls = {{kFirstNs + 400 * kMs, kFirstNs + 410 * kMs}};
  CHECK(judge_force(kRules, records, f).violations.empty());
}

TEST_CASE("judge: a force that follows the hand inwards is no rise") {
  Records records = account(full);
  for (size_t i = 500; i < records.size(); ++i) {
    records[i].answered = counts_at(kDepth + 1.5e-3);
    records[i].force_B.z = spring_at(kDepth + 1.5e-3);
  }
  CHECK(judge_force(kRules, records, fault(Effect::kNothing, 100, 400)).violations.empty());
}

TEST_CASE("judge: a change where nothing may change is caught, unless the machine stood still") {
  const auto records = account([](double t) { return t == 300 ? 0.9 : 1; });
  JudgedFault f = fault(Effect::kNothing, 100, 600);
  REQUIRE(judge_force(kRules, records, f).violations.size() == 1);
  CHECK(breaks(judge_force(kRules, records, f), ForceBreach::kChanged));
  f.stalls = {{kFirstNs + 200 * kMs, kFirstNs + 220 * kMs}};
  const ForceVerdict excused = judge_force(kRules, records, f);
  CHECK(excused.violations.empty());
  CHECK(excused.excused == 1);
  // a stall long before or after excuses nothing
  f.stalls = {{kFirstNs - 200 * kMs, kFirstNs}, {kFirstNs + 301 * kMs, kFirstNs + 400 * kMs}};
  CHECK(breaks(judge_force(kRules, records, f), ForceBreach::kChanged));
}

TEST_CASE("judge: a stale wall is caught, and what the machine was late by is allowed") {
  const auto late = [](double by) {
    return account([by](double t) {
      return t < 400 ? std::clamp(1 - (t - 200 - by) / 50, 0.0, 1.0)
                     : std::clamp((t - 500) / 50, 0.0, 1.0);
    });
  };
  JudgedFault f = fault(Effect::kFade, 100, 500);
  CHECK(judge_force(kRules, late(0), f).violations.empty());
  CHECK(breaks(judge_force(kRules, late(20), f), ForceBreach::kLateFade));
  f.stalls = {{kFirstNs + 130 * kMs, kFirstNs + 150 * kMs}};
  CHECK(judge_force(kRules, late(20), f).violations.empty());
  // a wall that stays for ever is not due to the machine
  CHECK(breaks(judge_force(kRules, account(full), f), ForceBreach::kLateFade));
}

TEST_CASE("judge: a zero that comes after 20 ms, or never, is caught") {
  const auto late = account([](double t) { return t < 125 ? 1 : closed(t); });
  JudgedFault f = fault(Effect::kZero, 100, 500);
  CHECK(breaks(judge_force(kRules, late, f), ForceBreach::kLateZero));
  CHECK(judge_force(kRules, late, f).zero_after_ns == 25 * kMs);
  f.stalls = {{kFirstNs + 110 * kMs, kFirstNs + 120 * kMs}};
  CHECK(judge_force(kRules, late, f).violations.empty());
  CHECK(breaks(judge_force(kRules, account(full), f), ForceBreach::kLateZero));
}

TEST_CASE("judge: a device that was away must be greeted with zero") {
  // nothing is received from 100 to 300 ms
  const auto away = [](double force_on_return) {
    Records records = account([&](double t) {
      return t == 300 ? force_on_return : t < 100 ? 1 : std::clamp((t - 302) / 100, 0.0, 1.0);
    });
    records.erase(records.begin() + 100, records.begin() + 300);
    for (size_t i = 0; i < records.size(); ++i) records[i].commands = i + 1;
    return records;
  };
  const JudgedFault f = fault(Effect::kSilence, 100, 299.5);
  CHECK(judge_force(kRules, away(0), f).violations.empty());
  CHECK(breaks(judge_force(kRules, away(1), f), ForceBreach::kLateZero));
}

TEST_CASE("judge: the hand is whole again with the first of ten commands that are the spring") {
  const Records records = account(closed);
  CHECK(whole_again(kRules, records, kFirstNs) == kFirstNs);
  CHECK(whole_again(kRules, records, kFirstNs + 150 * kMs) == kFirstNs + 600 * kMs);
  CHECK_FALSE(whole_again(kRules, records, kFirstNs + 995 * kMs));
}

TEST_CASE("judge: a standstill of the emulator is what is longer than its own period") {
  Records records = account(full);
  records.erase(records.begin() + 301, records.begin() + 350);  // 50 ms from 300 to 350
  const std::vector<Stall> stalls = emulator_stalls(records);
  REQUIRE(stalls.size() == 1);
  CHECK(held_up(stalls, kFirstNs, kFirstNs + 999 * kMs) == 39 * kMs);
  CHECK(held_up(stalls, kFirstNs + 330 * kMs, kFirstNs + 999 * kMs) == 20 * kMs);
  CHECK(held_up(stalls, kFirstNs, kFirstNs + 300 * kMs) == 0);
  // two witnesses of one stall count as one
  const std::vector<Stall> other{{kFirstNs, kFirstNs + 2 * kMs},
                                 {kFirstNs + 340 * kMs, kFirstNs + 360 * kMs}};
  CHECK(held_up(merge_stalls(stalls, other), kFirstNs, kFirstNs + 999 * kMs) == 51 * kMs);
}

TEST_CASE("judge: a servo that was let go while the machine stood still climbs by its soft start") {
  const auto released = [](double t) {
    return std::clamp((t - 323) / 100, t < 300 ? 1.0 : 0.0, 1.0);
  };
  Records records = account(released);
  records.erase(records.begin() + 300, records.begin() + 323);
  for (size_t i = 300; i < records.size(); ++i) records[i].commands -= 23;
  JudgedFault quiet = fault(Effect::kNothing, 100, 900);
  CHECK(breaks(judge_force(kRules, records, quiet), ForceBreach::kChanged));
  quiet.stalls = emulator_stalls(records);
  REQUIRE(quiet.stalls.size() == 1);
  const ForceVerdict verdict = judge_force(kRules, records, quiet);
  CHECK(verdict.violations.empty());
  CHECK(verdict.excused > 90);
}

TEST_CASE("judge: the emulator's log is read row by row as it was written") {
  const test::TemporaryFolder folder;
  const std::string path = folder.path() + "/received.csv";
  const Records wrote = account(faded);
  Records got;
  EmulatorLogReader reader(path);
  reader.read(got);
  CHECK(got.empty());
  EmulatorLog log(path);
  for (const EmulatorRecord& r : wrote) log.add(r);
  CHECK(log.finish().rows == wrote.size());
  reader.read(got);
  reader.read(got);
  REQUIRE(got.size() == wrote.size());
  for (size_t i = 0; i < got.size(); ++i) {
    REQUIRE(got[i].t_ns == wrote[i].t_ns);
    REQUIRE(got[i].commands == wrote[i].commands);
    REQUIRE(got[i].answered == wrote[i].answered);
    REQUIRE(got[i].force_B.z == Approx(wrote[i].force_B.z).epsilon(1e-8));
  }
  CHECK_THROWS_WITH(parse_emulator_row("1,2,3"), Catch::Contains("not a row"));
}

namespace {

/// The torque's rules, of a cube with a flat bottom.
ForceRules torque_rules() {
  ForceRules rules;
  rules.part = Part::kTorque;
  rules.arm = &six_motors_arm();
  rules.stiffness = 0.25;
  rules.max_force = 0.03;
  rules.max_damping = 2e-3;
  rules.slew = 1.7;
  rules.step = 2e-4;
  rules.pressing = 0.02;
  rules.tool_on_grip = from_rotation_vector({0, 0.07, 0});
  return rules;
}

/// A pressing hand on a device with six motors, whose handle is turned a little about all axes:
/// force and torque as shares of their springs.
Records account_of_six(const std::function<double(double)>& force,
                       const std::function<double(double)>& torque) {
  const ForceRules rules = torque_rules();
  const Arm& arm = *rules.arm;
  JointAngles angles = arm.angles({});
  REQUIRE(arm.solve({{0, 0, -kDepth}, from_rotation_vector({0.01, -0.01, 0.02})}, angles));
  const MotorCounts counts = arm.counts(angles);
  const Pose X_BH = arm.pose(arm.angles(counts));
  // the shortest turn that brings the tool's z upright
  const Vec3 z_B = rotate(X_BH.q * rules.tool_on_grip, {0, 0, 1});
  const Vec3 upright_B = std::acos(z_B.z) * normalized(cross(z_B, {0, 0, 1}));
  return account_at(arm, counts, [&](double t) {
    return Wrench{{0, 0, force(t) * kRules.stiffness * -X_BH.p.z},
                  torque(t) * rules.stiffness * upright_B};
  });
}

}  // namespace

TEST_CASE("judge: a torque that ends as the force does breaks nothing") {
  ForceRules force = kRules;
  force.arm = &six_motors_arm();
  force.step = 6e-3;
  for (const ForceRules& rules : {force, torque_rules()}) {
    const auto none = [&](const auto& share, const JudgedFault& f) {
      return judge_force(rules, account_of_six(share, share), f).violations.empty();
    };
    CHECK(none(full, fault(Effect::kNothing, 100, 600)));
    CHECK(none(faded, fault(Effect::kFade, 100, 500)));
    CHECK(none(closed, fault(Effect::kZero, 100, 500)));
    const auto whole = whole_again(rules, account_of_six(closed, closed), kFirstNs + 150 * kMs);
    REQUIRE(whole);
    // a step of the currents is a hundredth of the torque
    CHECK(std::llabs(*whole - (kFirstNs + 600 * kMs)) <= kMs);
  }
}

TEST_CASE("judge: what force or torque alone does wrong is caught, and is no fault of the other") {
  const bool turns = GENERATE(false, true);
  CAPTURE(turns);
  ForceRules force = kRules;
  force.arm = &six_motors_arm();
  force.step = 6e-3;
  const auto finds = [&](ForceBreach breach, const auto& right, const auto& wrong, Effect effect) {
    CAPTURE(name_of(breach));
    const Records records = turns ? account_of_six(right, wrong) : account_of_six(wrong, right);
    const JudgedFault f = fault(effect, 100, 500);
    CHECK(breaks(judge_force(turns ? torque_rules() : force, records, f), breach));
    CHECK(judge_force(turns ? force : torque_rules(), records, f).violations.empty());
  };
  const auto spike = [](double t) { return t == 400 ? 1.1 : 1; };
  finds(ForceBreach::kChanged, full, spike, Effect::kNothing);
  finds(ForceBreach::kBeyondWall, full, spike, Effect::kLimits);
  finds(
      ForceBreach::kTooStrong, full, [](double t) { return t == 400 ? 2 : 1; }, Effect::kLies);
  finds(
      ForceBreach::kRise, full, [](double t) { return t > 300 && t < 400 ? 0 : 1; }, Effect::kLies);
  finds(
      ForceBreach::kLateFade, faded, [](double t) { return t < 500 ? 1 : faded(t); },
      Effect::kFade);
  finds(
      ForceBreach::kLateZero, closed, [](double t) { return t < 130 ? 1 : closed(t); },
      Effect::kZero);
  finds(
      ForceBreach::kEarlyReturn, closed, [](double t) { return t > 400 ? 0.1 : closed(t); },
      Effect::kZero);
  finds(
      ForceBreach::kHardStart, closed,
      [](double t) { return t < 505 ? closed(t) : std::min(1.0, (t - 500) / 20); }, Effect::kZero);
}

}  // namespace haptic
