// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "clients/eval/oracle/free_cgal.h"
#include "clients/eval/scenes/free_scenes.h"
#include "clients/report/report.h"

namespace haptic {

/// A renderer under test, with the proxy solver where it has a choice of several.
struct FreeRenderer {
  std::string name;
  Renderer renderer = Renderer::kGodObject3;
  std::optional<SoftSolver> solver;
  bool reads_field = true;  // of voxel: the field, else tangent planes
};

/// All whose method leaves a hand alone that touches nothing: all but those that give the tool
/// mass.
const std::vector<FreeRenderer>& free_renderers();

/// Counts of the ticks of one run.
struct FreeFound {
  uint64_t ticks = 0;    // with contacts
  uint64_t touched = 0;  // in which something was felt that may be: the hands do come near
  uint64_t free = 0;     // in which nobody could have touched anything
  uint64_t felt = 0;     // of these, in which something was felt
  double largest = 0;    // of the forces and torques in these [N], [N·m]
  std::string where;     // that was: scene, hand, age

  void add(const FreeFound& other);
};

/// Distances of a tool on its way from all objects, tick by tick, by the oracle.
class FreeWay {
 public:
  /// `as_point`: of the tool's origin alone.
  FreeWay(const FreeScene& scene, const FreeHand& hand, bool as_point);

  /// Returns whether contacts computed for tick `asked` can prove the tool free at tick `now`:
  /// nine tenths of its distance from each object then were more than its middle has moved since
  /// against that object, plus the angle by which it has turned times its radius, plus what a
  /// detector may add to surfaces, √3 bands.
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
  std::vector<std::vector<double>> distances_;  // of each object and tick; negative: not asked
};

/// Runs a session in lockstep, with answers `age` ticks late. Judged are the ticks in which the
/// tool is free, and was for three ages before: until then a proxy that was held may follow.
FreeFound judge_free(const FreeRenderer& renderer, FreeWay& way, uint32_t age, uint64_t ticks);

struct FreeEval {
  uint64_t ticks = 200;        // of each run
  std::vector<uint32_t> ages;  // of the answers; none: 1 to 20 [ticks]
  uint64_t seed = 1;           // of generated bodies and hands
  bool all_scenes = true;      // else the peg alone
};

/// The whole of `hapt eval --suite free`. Throws MeshError.
std::vector<Row> eval_free(const FreeEval& eval);

}  // namespace haptic
