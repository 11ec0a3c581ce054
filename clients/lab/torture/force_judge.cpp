// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/torture/force_judge.h"
#include "proto/math/units.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace haptic {
namespace {

constexpr size_t kAnswers = 6;            // answers that the server may have used: one is under way
constexpr int64_t kUnderWayNs = 5 * kMs;  // a line, an answer and the grid of the tick
constexpr int64_t kStillNs = 15 * kMs;    // shorter stalls cannot age contacts
constexpr int64_t kLateReadNs = 50 * kMs;  // the device may have slept this long before a command
constexpr int64_t kRecordNs = 11 * kMs;    // longest silence of a healthy emulator

/// A pose reported by the device.
struct Said {
  JointAngles angles;
  Pose X_BH;
  double depth;  // or tilt
};

Said said(const ForceRules& rules, const MotorCounts& counts) {
  Said out{rules.arm->angles(counts), {}, 0};
  out.X_BH = rules.arm->pose(out.angles);
  if (rules.weight > 0) {
    // by which the hold's spring is drawn out, wherever the hand rests
    out.depth = rules.weight / rules.stiffness;
    return out;
  }
  out.depth = rules.part == Part::kForce ? std::max(0.0, -out.X_BH.p.z)
                                         : norm(tilt_of(out.X_BH.q * rules.tool_on_grip));
  return out;
}

/// Way or turn between two of them.
double way_between(const ForceRules& rules, const Pose& a, const Pose& b) {
  return rules.part == Part::kForce ? norm(b.p - a.p)
                                    : norm(to_rotation_vector(b.q * conjugate(a.q)));
}

Vec3 part_of(const ForceRules& rules, const Wrench& F) {
  return rules.part == Part::kForce ? F.f : F.t;
}

double felt(const ForceRules& rules, const EmulatorRecord& r) {
  return norm(part_of(rules, {r.force_B, r.torque_B}));
}

/// A command with the quantities it is checked against.
struct Command {
  int64_t t_ns = 0;
  double force = 0;
  double weakest = 0, strongest = 0;   // its currents as forces at the recent reported poses
  double depth = 0;                    // or tilt, known to the server
  double deepest = 0, shallowest = 0;  // at the recent reported poses
  double moved = 0;                    // since the previous answer, in any direction
  double damper = 0;                   // bound of the damping force on top of the spring
  bool is_zero = false;
  bool is_spring = false;
  bool from_server = true;  // false: the firmware's watchdog
};

bool is_zero(const Command& c) {
  return c.is_zero;
}

MotorEfforts amperes_of(const EmulatorRecord& r) {
  MotorEfforts amperes;
  for (size_t i = 0; i < amperes.size(); ++i) amperes[i] = 1e-3 * r.currents[i];
  return amperes;
}

/// Evaluates the currents at the poses that the server may assume. Returns the largest distance
/// between two consecutive ones.
double look_back(const ForceRules& rules, std::span<const Said> poses, const MotorEfforts& amperes,
                 Command& c) {
  double way = 0;
  c.weakest = c.shallowest = std::numeric_limits<double>::infinity();
  for (size_t j = 0; j < poses.size(); ++j) {
    const double force = norm(part_of(rules, rules.arm->wrench(poses[j].angles, amperes)));
    c.weakest = std::min(c.weakest, force);
    c.strongest = std::max(c.strongest, force);
    c.deepest = std::max(c.deepest, poses[j].depth);
    c.shallowest = std::min(c.shallowest, poses[j].depth);
    if (j > 0) way = std::max(way, way_between(rules, poses[j - 1].X_BH, poses[j].X_BH));
  }
  return way;
}

std::vector<Command> commands_of(const ForceRules& rules, std::span<const EmulatorRecord> records,
                                 bool is_misled = false) {
  // while the driver distrusts the device, it holds the last trusted pose
  const int64_t believed_ns = is_misled ? rules.doubt_ns + kUnderWayNs : 0;
  std::vector<Command> out;
  std::vector<Said> poses;     // in order; an old one sent first precedes its answer
  std::vector<size_t> begins;  // index of the first pose of each answer
  size_t oldest = 0;           // oldest answer that the server may still use
  for (const EmulatorRecord& r : records) {
    const bool from_server = r.event == EmulatorEvent::kCommand;
    if (!from_server && r.event != EmulatorEvent::kWatchdog) continue;
    begins.push_back(poses.size());
    if (r.said_first != r.answered) poses.push_back(said(rules, r.said_first));
    poses.push_back(said(rules, r.answered));
    Command c{.t_ns = r.t_ns, .force = felt(rules, r), .from_server = from_server};
    c.is_zero = c.force <= rules.step;
    c.depth = poses.back().depth;
    while (begins.size() - oldest > kAnswers && out[oldest].t_ns < r.t_ns - believed_ns) ++oldest;
    const auto believed = std::span(poses).subspan(begins[oldest]);
    const double way = look_back(rules, believed, amperes_of(r), c);
    if (begins.size() > 1) {
      c.moved = way_between(rules, poses[begins.back() - 1].X_BH, poses.back().X_BH);
    }
    const double speed = way / (1e-9 * static_cast<double>(rules.tick_ns));
    c.damper = rules.max_damping * speed;
    c.is_spring = from_server && is_wall(rules, r, speed);
    out.push_back(c);
  }
  return out;
}

/// The most that spring and damper make, at the deepest of the recent poses.
double most_of_wall(const ForceRules& rules, const Command& c) {
  return rules.stiffness * c.deepest + rules.bend + rules.sway + c.damper;
}

/// Keeps the first breach of each kind.
class Findings {
 public:
  void add(ForceBreach breach, int64_t t_ns, double force, double allowed) {
    bool& known = known_[static_cast<size_t>(breach)];
    if (!known) verdict.violations.push_back({breach, t_ns, force, allowed});
    known = true;
  }
  ForceVerdict verdict;

 private:
  std::array<bool, kForceBreaches> known_{};
};

/// After a stall this long the servo may have been released, and the force climbs back from zero by
/// the slew limit or the soft start.
bool is_climbing(const ForceRules& rules, const JudgedFault& fault, const Command& c) {
  const int64_t released_ns = (kReleaseAfterTicks - 4) * rules.tick_ns;
  const double climb = std::max(rules.max_force / rules.slew, rules.soft_start);
  const auto climb_ns = static_cast<int64_t>(1e9 * climb);
  return std::any_of(fault.stalls.begin(), fault.stalls.end(), [&](const Stall& s) {
    return s.end_ns - s.begin_ns > released_ns && s.begin_ns < c.t_ns &&
           c.t_ns < s.end_ns + climb_ns + 2 * released_ns;
  });
}

/// After a stall contacts may have aged, and the force returns by a ramp.
bool is_excused(const ForceRules& rules, const JudgedFault& fault, const Command& c) {
  const int64_t memory_ns = rules.hold_ns + 3 * rules.fade_ns;
  return held_up(fault.stalls, c.t_ns - memory_ns, c.t_ns) > kStillNs ||
         is_climbing(rules, fault, c);
}

/// Checks what holds at all times, with or without a fault. False planes may push harder than the
/// wall and to any side, but no faster than the hand's motion and the slew limit allow. The
/// currents of a lying device belong to one of its reported poses: a command is checked by the
/// force there.
void judge_always(const ForceRules& rules, std::span<const Command> all, const JudgedFault& fault,
                  Findings& found) {
  const bool lies = fault.effect == Effect::kLies;
  for (size_t i = 0; i < all.size(); ++i) {
    const Command& c = all[i];
    if (c.t_ns < fault.from_ns) continue;
    const bool misled = fault.is_misled && c.t_ns >= fault.begin_ns - kUnderWayNs;
    const double force = misled ? c.weakest : c.force;
    const double strongest = rules.max_force + rules.step;
    if (!(force <= strongest)) found.add(ForceBreach::kTooStrong, c.t_ns, force, strongest);
    if (i + 1 < kAnswers) continue;
    const double wall = most_of_wall(rules, c) + rules.step;
    // what hangs from the hand falls while the machine stands still, and swings
    const bool swings = rules.weight > 0 && is_excused(rules, fault, c);
    if (!lies && !swings && !(force <= wall)) {
      found.add(ForceBreach::kBeyondWall, c.t_ns, force, wall);
    }
    // since the command before last: a stalled device has read the last one too late
    const int64_t before_ns = all[i - 1].t_ns;
    const int64_t late_ns = held_up(fault.stalls, before_ns - kLateReadNs, before_ns);
    const double dt = 1e-9 * static_cast<double>(c.t_ns - all[i - 2].t_ns + late_ns);
    // growth due to spring and damper; false planes: to any side, over two answers, one late
    const double deeper =
        misled ? c.deepest - all[i - 1].shallowest : std::max(0.0, c.depth - all[i - 1].depth);
    const double pushed =
        lies ? rules.stiffness * (c.moved + all[i - 1].moved) : rules.stiffness * deeper + c.damper;
    const double before = misled ? all[i - 1].strongest : all[i - 1].force;
    const double allowed = before + pushed + rules.slew * dt + 2 * rules.step;
    if (!(force <= allowed)) found.add(ForceBreach::kRise, c.t_ns, force, allowed);
  }
}

void judge_complete(const ForceRules& rules, std::span<const EmulatorRecord> records,
                    Findings& found) {
  for (size_t i = 1; i < records.size(); ++i) {
    const EmulatorRecord &before = records[i - 1], &r = records[i];
    const uint64_t expected = before.commands + (r.event == EmulatorEvent::kCommand ? 1 : 0);
    if (r.commands == expected && r.t_ns >= before.t_ns) continue;
    found.add(ForceBreach::kLostRecord, r.t_ns, felt(rules, r), felt(rules, before));
  }
}

void judge_unchanged(const ForceRules& rules, std::span<const Command> all,
                     const JudgedFault& fault, Findings& found) {
  // a standstill that closes the force ends a hold, until the hand takes its body again
  bool has_fallen = false;
  for (const Command& c : all) {
    const bool meanwhile =
        c.t_ns >= fault.begin_ns && (fault.over_ns == 0 || c.t_ns < fault.over_ns);
    if (!meanwhile || c.is_spring) continue;
    const bool is_empty = rules.weight > 0 && c.force < rules.step;
    if (is_excused(rules, fault, c) || (has_fallen && is_empty)) {
      has_fallen = is_empty;
      ++found.verdict.excused;
    } else {
      found.add(ForceBreach::kChanged, c.t_ns, c.force, rules.stiffness * c.depth);
    }
  }
}

/// Full force for the longest hold, then fading to zero while contact is away.
void judge_fade(const ForceRules& rules, std::span<const Command> all, const JudgedFault& fault,
                Findings& found) {
  const int64_t gone_ns = fault.begin_ns + rules.hold_ns + rules.fade_ns + kUnderWayNs;
  for (const Command& c : all) {
    if (c.t_ns < fault.begin_ns || c.t_ns >= fault.over_ns) continue;
    const int64_t excused_ns = held_up(fault.stalls, fault.begin_ns, c.t_ns);
    const double left =
        static_cast<double>(gone_ns + excused_ns - c.t_ns) / static_cast<double>(rules.fade_ns);
    const double share = std::clamp(left, 0.0, 1.0);
    const double allowed = share * most_of_wall(rules, c) + rules.step;
    if (!(c.force <= allowed)) found.add(ForceBreach::kLateFade, c.t_ns, c.force, allowed);
  }
}

/// After the last zero the force must grow no faster than the soft start.
void judge_soft_start(const ForceRules& rules, std::span<const Command> all, size_t zero,
                      const JudgedFault& fault, Findings& found) {
  while (zero + 1 < all.size() && is_zero(all[zero + 1])) ++zero;
  // it runs from a servo's first tick, with or without contacts
  const int64_t begin_ns = (fault.soft_ns != 0 ? fault.soft_ns : all[zero].t_ns) - kUnderWayNs;
  for (size_t i = zero + 1; i < all.size(); ++i) {
    const Command& c = all[i];
    // a stalled device has read the zero late
    const int64_t late_ns = held_up(fault.stalls, begin_ns - kLateReadNs, c.t_ns);
    const double gain = 1e-9 * static_cast<double>(c.t_ns + late_ns - begin_ns) / rules.soft_start;
    if (gain >= 1) return;
    const double allowed =
        gain * (rules.stiffness * c.deepest + rules.bend) + c.damper + rules.step;
    if (!(c.force <= allowed)) found.add(ForceBreach::kHardStart, c.t_ns, c.force, allowed);
  }
}

bool was_zero_before(std::span<const Command> all, std::span<const Command>::iterator command) {
  return command != all.begin() && is_zero(*std::prev(command));
}

void judge_zero(const ForceRules& rules, std::span<const Command> all, const JudgedFault& fault,
                Findings& found) {
  // a device that is away can receive nothing
  const bool away = fault.effect == Effect::kSilence;
  const int64_t from_ns = away ? fault.over_ns : fault.begin_ns;
  // until then a zero may be another's: of a pose that asks for nothing, or hapticd's, which lets
  // go of a servo that is held up
  const int64_t stays_from_ns = std::min(fault.over_ns, from_ns + rules.zero_ns);
  auto after = std::find_if(all.begin(), all.end(), [&](const Command& c) {
    return c.t_ns >= from_ns && (c.from_server || !away);
  });
  // the injector may have been stalled before it noted the time
  if (!away && was_zero_before(all, after)) --after;
  auto first = std::find_if(after, all.end(), is_zero);
  for (auto c = first; !away && c != all.end() && c->t_ns < stays_from_ns; ++c) {
    if (!is_zero(*c)) first = std::find_if(c, all.end(), is_zero);
  }
  const int64_t stated_ns = from_ns + rules.zero_ns;
  const int64_t limit_ns =
      first == all.end() ? stated_ns : stated_ns + held_up(fault.stalls, from_ns, first->t_ns);
  const bool late = first == all.end() || (away ? first != after : first->t_ns > limit_ns);
  if (late) {
    const double force = after == all.end() ? 0 : after->force;
    found.add(ForceBreach::kLateZero, first == all.end() ? limit_ns : first->t_ns, force, 0);
  }
  if (first == all.end()) return;
  size_t zero = static_cast<size_t>(first - all.begin());
  if (fault.over_ns > from_ns) {
    for (size_t i = zero; i < all.size() && all[i].t_ns < fault.over_ns; ++i) {
      if (is_zero(all[i])) zero = i;
      if (!is_zero(all[i])) found.add(ForceBreach::kEarlyReturn, all[i].t_ns, all[i].force, 0);
    }
  }
  judge_soft_start(rules, all, zero, fault, found);
}

}  // namespace

std::string_view name_of(ForceBreach breach) {
  constexpr std::array<std::string_view, kForceBreaches> kNames{"above the largest force",
                                                                "more than the wall",
                                                                "rises too fast",
                                                                "changed without a reason",
                                                                "fades too late",
                                                                "zero too late",
                                                                "back too early",
                                                                "back without a soft start",
                                                                "a gap in the emulator's log"};
  return kNames[static_cast<size_t>(breach)];
}

Vec3 tilt_of(const Quat& q_BT) {
  const double length = std::hypot(q_BT.z, q_BT.w);
  if (!(length > 0)) return to_rotation_vector(q_BT);
  const Quat about_z{0, 0, q_BT.z / length, q_BT.w / length};
  return to_rotation_vector(q_BT * conjugate(about_z));
}

bool is_wall(const ForceRules& rules, const EmulatorRecord& command, double speed) {
  const Said at = said(rules, command.answered);
  const double force = std::min(rules.stiffness * at.depth, rules.max_force);
  Vec3 wall{0, 0, force};
  if (rules.weight > 0) wall.z = -force;
  if (rules.part == Part::kTorque && at.depth > 0) {
    wall = -force / at.depth * tilt_of(at.X_BH.q * rules.tool_on_grip);
  }
  const Vec3 got = part_of(rules, {command.force_B, command.torque_B});
  return norm(got - wall) <= rules.step + rules.sway + rules.max_damping * speed;
}

ForceVerdict judge_force(const ForceRules& rules, std::span<const EmulatorRecord> records,
                         const JudgedFault& fault) {
  const std::vector<Command> all = commands_of(rules, records, fault.is_misled);
  Findings found;
  judge_complete(rules, records, found);
  judge_always(rules, all, fault, found);
  // in the order of Effect; lies and limits are judged as always
  constexpr std::array<decltype(&judge_zero), 6> kJudges{nullptr,    nullptr,    judge_unchanged,
                                                         judge_fade, judge_zero, judge_zero};
  if (const auto judge = kJudges[static_cast<size_t>(fault.effect)]) {
    judge(rules, all, fault, found);
  }
  const std::span<const Command> judged = all;
  const auto after = std::find_if(judged.begin(), judged.end(),
                                  [&](const Command& c) { return c.t_ns >= fault.begin_ns; });
  const auto zero = std::find_if(after, judged.end(), is_zero);
  if (was_zero_before(judged, after)) {
    found.verdict.zero_after_ns = 0;
  } else if (zero != judged.end()) {
    found.verdict.zero_after_ns = zero->t_ns - fault.begin_ns;
  }
  return found.verdict;
}

std::optional<int64_t> whole_again(const ForceRules& rules, std::span<const EmulatorRecord> records,
                                   int64_t from_ns) {
  const std::vector<Command> all = commands_of(rules, records);
  size_t in_a_row = 0;
  for (size_t i = 0; i < all.size(); ++i) {
    const bool whole = all[i].t_ns >= from_ns && all[i].is_spring && all[i].depth > rules.pressing;
    in_a_row = whole ? in_a_row + 1 : 0;
    if (in_a_row == rules.in_a_row) return all[i + 1 - in_a_row].t_ns;
  }
  return std::nullopt;
}

int64_t held_up(std::span<const Stall> stalls, int64_t from_ns, int64_t to_ns) {
  int64_t sum_ns = 0;
  for (const Stall& s : stalls) {
    sum_ns += std::max<int64_t>(0, std::min(s.end_ns, to_ns) - std::max(s.begin_ns, from_ns));
  }
  return sum_ns;
}

std::vector<Stall> emulator_stalls(std::span<const EmulatorRecord> records) {
  std::vector<Stall> out;
  for (size_t i = 1; i < records.size(); ++i) {
    const Stall stall{records[i - 1].t_ns + kRecordNs, records[i].t_ns};
    if (stall.end_ns > stall.begin_ns) out.push_back(stall);
  }
  return out;
}

std::vector<Stall> stalls_since(std::vector<Stall> stalls, int64_t since_ns) {
  std::erase_if(stalls, [&](const Stall& s) { return s.end_ns <= since_ns; });
  return merge_stalls(stalls, {});
}

std::vector<Stall> merge_stalls(std::span<const Stall> a, std::span<const Stall> b) {
  std::vector<Stall> all(a.begin(), a.end());
  all.insert(all.end(), b.begin(), b.end());
  std::sort(all.begin(), all.end(),
            [](const Stall& x, const Stall& y) { return x.begin_ns < y.begin_ns; });
  std::vector<Stall> out;
  for (const Stall& stall : all) {
    if (!out.empty() && stall.begin_ns <= out.back().end_ns) {
      out.back().end_ns = std::max(out.back().end_ns, stall.end_ns);
    } else {
      out.push_back(stall);
    }
  }
  return out;
}

}  // namespace haptic
