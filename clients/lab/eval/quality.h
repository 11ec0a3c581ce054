// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "clients/lab/eval/scenes/quality_scenes.h"
#include "contact/bake/volume.h"
#include "contact/detect/body/voxel.h"
#include "contact/query/proximity/triangle_pairs.h"
#include "servo/solve/body/soft_proxy.h"

namespace haptic {

/// The contact detector of a renderer.
enum class QualityDetector {
  kExact,         // triangles against triangles (contact/detect/body/exact)
  kField,         // points in a distance field (contact/detect/body/voxel)
  kTangentPlanes  // points in voxels, as in the paper of 1999
};

/// A renderer under test.
struct QualityRenderer {
  std::string name;
  QualityDetector detector = QualityDetector::kField;
  SoftSolver solver = SoftSolver::kDirect;
};

/// All renderers that are tested: direct6, and voxel with each detector and each solver.
std::span<const QualityRenderer> quality_renderers();

/// Both bodies of a scene, ready for every detector.
struct QualityShapes {
  BakedShape object, tool;
  BakedVolume object_volume, tool_volume;
};
QualityShapes bake_quality(QualityScene scene, const QualityGrain& grain);

/// A renderer on one pair of bodies, evaluated pose by pose: detector and solver alternate with the
/// hand held still until the wrench has settled.
class QualityProbe {
 public:
  QualityProbe(const QualityRenderer& renderer, const QualityShapes& shapes,
               const QualityGrain& grain);
  // the model points into this object
  QualityProbe(const QualityProbe&) = delete;
  QualityProbe& operator=(const QualityProbe&) = delete;

  /// The wrench on the hand with the tool at X_WT, about the tool's origin, in W. The proxy starts
  /// where it was for the previous pose.
  Wrench operator()(const Pose& X_WT);

  uint64_t restless() const { return restless_; }  // poses at which it did not settle

 private:
  void detect(const Pose& X_WP, ContactSet& set);

  QualityRenderer renderer_;
  MeshShape object_, tool_;
  VoxelObject voxels_;
  VoxelModel voxel_model_;
  std::unique_ptr<VoxelState> voxel_state_;
  std::vector<TrianglePair> pairs_;
  std::vector<PointPush> pushes_;
  ClusterMemory clusters_;
  SoftProxyModel model_;
  BodyTick in_force_;  // tool and coupling
  SoftProxyState state_;
  ContactSet set_{};
  uint64_t restless_ = 0;
};

/// True if a renderer is held to the goals of a scene. Renderers whose method cannot reach them
/// report their figures only; docs/judge.md says why.
bool is_held_to(const QualityRenderer& renderer, QualityScene scene);

/// Evaluates one renderer in one scene.
void eval_quality(QualityScene scene, const QualityRenderer& renderer, const QualityShapes& shapes,
                  const QualityGrain& grain, const Rows& all);

/// `hapt eval quality`: every scene with every renderer.
void eval_every_quality(const QualityGrain& grain, const Rows& all);

}  // namespace haptic
