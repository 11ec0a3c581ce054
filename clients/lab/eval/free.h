// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "clients/lab/eval/oracle/free_cgal.h"
#include "clients/lab/eval/scenes/free_scenes.h"
#include "clients/report/report.h"

namespace haptic {

/// All renderers whose method exerts exactly no force without contact: all except those with mass.
const std::vector<JudgedRenderer>& free_renderers();

/// Counts of the ticks of one run.
struct FreeFound {
  uint64_t ticks = 0;    // ticks with contacts
  uint64_t touched = 0;  // ticks with a force although not proved free; the hands do come near
  uint64_t free = 0;     // ticks in which nothing can be in contact
  uint64_t felt = 0;     // of these, ticks with a force
  double largest = 0;    // largest force or torque in free ticks [N], [N·m]
  std::string where;     // scene, hand and age of that one

  void add(const FreeFound& other);
};

/// Distances of a moving tool from all objects in each tick, by the oracle.
class FreeWay {
 public:
  /// `as_point`: distances of the tool's origin only.
  FreeWay(const FreeScene& scene, const FreeHand& hand, bool as_point);

  /// True if contacts computed for tick `asked` can prove the tool free at tick `now`: for each
  /// object, 0.9 times the distance at `asked` exceeds the relative motion of the tool's centre
  /// since then, plus its rotation angle times its radius, plus √3 bands by which a detector may
  /// thicken surfaces.
  bool is_free(uint64_t asked, uint64_t now);

  const FreeScene& scene() const { return scene_; }
  const FreeHand& hand() const { return hand_; }

 private:
  Pose in_object(size_t object, uint64_t tick) const;
  double distance(size_t object, uint64_t tick);

  const FreeScene& scene_;
  const FreeHand& hand_;
  Vec3 middle_T_;
  double radius_ = 0, layer_ = 0;  // [m]
  std::vector<FreeOracle> oracles_;
  std::vector<std::vector<double>> distances_;  // per object and tick; negative: not computed yet
};

/// Runs a session in lockstep with answers `age` ticks late, on a device with motors of force and
/// torque. Only ticks are evaluated in which the
/// tool is free and has been for three ages: until then a held proxy may still be catching up.
FreeFound judge_free(const JudgedRenderer& renderer, FreeWay& way, uint32_t age, uint64_t ticks);

struct FreeEval {
  uint64_t ticks = 200;        // per run
  std::vector<uint32_t> ages;  // of the answers [ticks]; empty: 1 to 20
  uint64_t seed = 1;           // for generated bodies and hands
  bool all_scenes = true;      // false: the peg only
};

/// `hapt eval free`. Throws MeshError.
void eval_free(const FreeEval& eval, const Rows& all);

}  // namespace haptic
