// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/eval/quality.h"

#include <array>
#include <cmath>

#include "clients/lab/eval/drag.h"
#include "clients/lab/support/measurement.h"
#include "contact/detect/body/cluster_contact.h"
#include "contact/detect/body/exact.h"
#include "contact/detect/body/voxel.h"
#include "contact/shape/mesh/tool_body.h"
#include "proto/os/progress.h"

namespace haptic {
namespace {

constexpr double kPointStiffness = 1000;  // of one point or one exact contact [N/m]
constexpr double kToolStiffness = 1000, kToolDamping = 9;  // of the coupling [N/m], [N·s/m]
constexpr double kToolTurnStiffness = 2, kToolTurnDamping = 3e-3;  // [N·m/rad], [N·m·s/rad]
constexpr double kToolMass = 0.02;                                 // of the tool [kg]
constexpr size_t kRoom = 100000;                                   // capacity in pairs of triangles
constexpr int kMostTicks = 500, kQuietTicks = 5;  // limit per pose; settled after as many
constexpr double kQuiet = 1e-5;  // relative change of the wrench per tick that counts as settled

constexpr std::array kScenes{QualityScene::kConeOnPlane, QualityScene::kSphereRoundCylinder,
                             QualityScene::kCubeOnPlate, QualityScene::kPegInHole};

BakedShape bake(const Soup& soup, std::string_view name) {
  ShapeConfig shape;
  assign(shape.name, std::string(name));
  return bake_soup(soup.vertices, soup.triangles, shape);
}

VoxelConfig options_of(const QualityGrain& grain) {
  return {.size = grain.voxel,
          .band = 4 * grain.voxel,
          .stiffness = kPointStiffness,
          // surfaces must be where the closed form has them
          .offset_layers = 0,
          .budget = 0};  // no time limit offline
}

ToolBody body_of(const TriangleMesh& mesh) {
  ToolConfig config;
  config.mass = kToolMass;
  return tool_body(mesh, config);
}

}  // namespace

std::span<const QualityRenderer> quality_renderers() {
  static const std::array kJudged{
      QualityRenderer{"direct6", QualityDetector::kExact, SoftSolver::kDirect},
      QualityRenderer{"voxel, field, direct", QualityDetector::kField, SoftSolver::kDirect},
      QualityRenderer{"voxel, field, quasi-static", QualityDetector::kField,
                      SoftSolver::kQuasiStatic},
      QualityRenderer{"voxel, field, penalty dynamics implicit", QualityDetector::kField,
                      SoftSolver::kPenaltyDynamics},
      QualityRenderer{"voxel, tangent planes, direct", QualityDetector::kTangentPlanes,
                      SoftSolver::kDirect},
      QualityRenderer{"voxel, tangent planes, quasi-static", QualityDetector::kTangentPlanes,
                      SoftSolver::kQuasiStatic},
      QualityRenderer{"voxel, tangent planes, penalty dynamics implicit",
                      QualityDetector::kTangentPlanes, SoftSolver::kPenaltyDynamics}};
  return kJudged;
}

QualityShapes bake_quality(QualityScene scene, const QualityGrain& grain) {
  const QualityBodies bodies = bodies_of(scene, grain);
  VoxelConfig options = options_of(grain);
  options.point_spacing = spacing_of(scene, grain);
  QualityShapes shapes{bake(bodies.object, "object"), bake(bodies.tool, "tool"), {}, {}};
  shapes.object_volume = bake_obstacle(shapes.object, options);
  shapes.tool_volume = bake_tool(shapes.tool, options);
  return shapes;
}

QualityProbe::QualityProbe(const QualityRenderer& renderer, const QualityShapes& shapes,
                           const QualityGrain& grain)
    : renderer_(renderer),
      object_(shapes.object.shape),
      tool_(shapes.tool.shape),
      voxels_{shapes.object_volume.content.map, shapes.object_volume.content.field} {
  VoxelConfig config = options_of(grain);
  config.field = renderer.detector == QualityDetector::kTangentPlanes ? 0 : 1;
  voxel_model_ = voxel_model(config, shapes.tool_volume.content.shell);
  voxel_model_.objects = {&voxels_, 1};
  voxel_state_ = std::make_unique<VoxelState>(voxel_model_);
  pairs_.resize(kRoom);
  pushes_.resize(kPushesPerPair * kRoom);
  model_.solver = renderer.solver;
  set_.objects.resize(1);
  in_force_.X_WO.resize(1);
  in_force_.V_WO.resize(1);
  in_force_.tool = body_of(tool_.mesh);
  in_force_.coupling = {kToolStiffness, kToolDamping, kToolTurnStiffness, kToolTurnDamping, 0, 0};
  model_.contact_stiffness = kPointStiffness;
  model_.max_travel = 0.5 * options_of(grain).band;
}

void QualityProbe::detect(const Pose& X_WP, ContactSet& set) {
  set.X_WT = X_WP;
  if (renderer_.detector != QualityDetector::kExact) {
    BodyQuestion question{};
    question.X_WO.resize(1);
    question.V_WO.resize(1);
    question.X_WT = X_WP;
    question.reach = voxels_.map.size;
    detect_voxel(voxel_model_, *voxel_state_, question, set);
    return;
  }
  std::array<PushCluster, kMaxContacts> clusters;
  PushOptions options;
  options.stiffness = kPointStiffness;
  const ExactAnswer answer =
      exact_contacts(object_, tool_, X_WP, options, clusters_, {pairs_, pushes_}, clusters);
  set.contacts.clear();
  for (const PushCluster& cluster : std::span(clusters).first(answer.n_clusters)) {
    set.contacts.push_back(contact_of(cluster, 0, {}, X_WP));
  }
}

Wrench QualityProbe::operator()(const Pose& X_WT) {
  BodyTick tick = in_force_;
  tick.hand.X_WT = X_WT;
  tick.contacts = &set_;
  Wrench before{};
  int quiet = 0;
  for (int k = 0; k < kMostTicks; ++k) {
    const bool at_hand = renderer_.solver == SoftSolver::kDirect || !state_.started;
    detect(at_hand ? X_WT : state_.proxy.X_WT, set_);
    const Wrench felt = solve_soft_proxy(model_, state_, tick).F_hand_W;
    if (renderer_.solver == SoftSolver::kDirect) return felt;
    const double change = norm(felt.f - before.f) + norm(felt.t - before.t);
    quiet = change <= kQuiet * (norm(felt.f) + norm(felt.t)) ? quiet + 1 : 0;
    before = felt;
    if (quiet == kQuietTicks) return felt;
  }
  ++restless_;
  return before;
}

bool is_held_to(const QualityRenderer& renderer, QualityScene scene) {
  return renderer.detector == QualityDetector::kField ||
         (renderer.detector == QualityDetector::kExact && scene == QualityScene::kConeOnPlane);
}

void eval_quality(QualityScene scene, const QualityRenderer& renderer, const QualityShapes& shapes,
                  const QualityGrain& grain, const Rows& all) {
  const std::string name = std::string(name_of(scene)) + ": " + renderer.name;
  QualityProbe probe(renderer, shapes, grain);
  QualityGoals goals;
  goals.are_judged = is_held_to(renderer, scene);
  Rows rows = all.of(name);
  rows.note("scene", name);
  judge_quality(
      scene, [&](const Pose& X_WT) { return probe(X_WT); }, grain.samples, goals, name, all);
  rows.add("places at which it did not settle", probe.restless());
}

void eval_every_quality(const QualityGrain& grain, const Rows& all) {
  all.machine("quality");
  eval_drag(all);
  Progress progress("eval quality",
                    static_cast<double>(kScenes.size() * quality_renderers().size()));
  for (const QualityScene scene : kScenes) {
    const QualityShapes shapes = bake_quality(scene, grain);
    for (const QualityRenderer& renderer : quality_renderers()) {
      eval_quality(scene, renderer, shapes, grain, all);
      progress.step();
    }
  }
}

Measured suite_quality(Command&) {
  return measured(eval_every_quality, std::make_shared<QualityGrain>());
}

}  // namespace haptic
