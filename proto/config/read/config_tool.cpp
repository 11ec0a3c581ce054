// SPDX-License-Identifier: Apache-2.0
#include "proto/config/read/config_tool.h"

#include "proto/config/read/config_body.h"
#include "proto/config/read/config_shape.h"
#include "proto/os/message.h"

namespace haptic {

using enum Dimension;

namespace {

constexpr Words<SoftSolver, 3> kSolvers{{{kSoftSolverNames[0], SoftSolver::kDirect},
                                         {kSoftSolverNames[1], SoftSolver::kPenaltyDynamics},
                                         {kSoftSolverNames[2], SoftSolver::kQuasiStatic}}};
constexpr Words<RigidSolver, 2> kRigidSolvers{
    {{"coulomb", RigidSolver::kCoulomb}, {"lcp", RigidSolver::kLcp}}};
constexpr Words<Sharing, 2> kSharings{{{"corners", Sharing::kCorners}, {"none", Sharing::kNone}}};
constexpr Words<Integrator, 3> kIntegrators{{{"explicit", Integrator::kExplicit},
                                             {"semi-implicit", Integrator::kSemiImplicit},
                                             {"implicit", Integrator::kImplicit}}};
constexpr Words<Braking, 2> kBrakings{
    {{"velocity", Braking::kAlongVelocity}, {"normal", Braking::kAlongNormal}}};
constexpr Range kToolMasses{1e-4, 10};   // [kg]; range in which the implicit integrators are tested
constexpr Range kRigidGains{0.05, 2};    // k_s
constexpr Range kMargins{1e-7, 1e-3};    // [m]
constexpr int64_t kMaxMoves = 64;        // per step of contact
constexpr int64_t kMaxOffsetLayers = 8;  // [voxels]
constexpr int64_t kMaxBudget = 1 << 30;  // points, or pairs of pieces, per step
constexpr Range kThresholds{0, 10e-3};   // [m]
constexpr Range kClusterRadii{1e-5, 1};  // [m]

}  // namespace

void read_tool(Section& root, const std::filesystem::path& config_folder, ToolConfig& tool) {
  assign(tool.name, "tool");
  tool.colour = kToolColour;
  root.within("tool", [&](Section& section) {
    read_shape(section, config_folder, tool);
    read_colour(section, tool);
    read_mass(section, kToolMasses, {tool.density, tool.mass, tool.inertia});
  });
}

void read_proxy(Section& root, ProxyConfig& proxy) {
  root.within("proxy", [&](Section& section) {
    SoftSolver solver{};
    if (section.read_choice("solver", kSolvers, solver)) proxy.solver = solver;
    section.read_all({{"integrator", kIntegrators, proxy.integrator},
                      {"contact_stiffness", kStiffness, kPositive, proxy.contact_stiffness},
                      {"contact_damping", kDamping, kNotNegative, proxy.contact_damping},
                      {"sharing", kSharings, proxy.sharing}});
  });
}

Range band_range(const VoxelConfig& voxel) {
  return {(voxel.offset_layers + 1) * voxel.size, 100 * voxel.size};
}

void read_voxel(Section& contact, VoxelConfig& voxel) {
  const auto read = [&](Section& section) {
    section.read_quantity("size", kLength, kVoxelSizes, voxel.size);
    voxel.point_spacing = voxel.size;
    section.read_all(
        {{"offset_layers", 0, kMaxOffsetLayers, voxel.offset_layers}, {"field", voxel.field}});
    voxel.band = default_band(voxel);
    section.read_all({{"band", kLength, band_range(voxel), voxel.band},
                      {"open_as_sheet", voxel.open_as_sheet},
                      {"point_spacing", kLength, kVoxelSizes, voxel.point_spacing},
                      {"stiffness", kStiffness, kPositive, voxel.stiffness},
                      {"braking", kDamping, kNotNegative, voxel.braking},
                      {"braking_along", kBrakings, voxel.braking_along},
                      {"budget", 0, kMaxBudget, voxel.budget}});
  };
  voxel.is_wanted = contact.within("voxel", read) ? 1 : 0;
}

void read_pieces(Section& contact, PieceConfig& pieces) {
  const auto read = [&](Section& section) {
    section.read_all({{"threshold", kLength, kThresholds, pieces.threshold},
                      {"carry", kLength, kThresholds, pieces.carry},
                      {"bandwidth", kFrequency, kNotNegative, pieces.bandwidth},
                      {"cluster_radius", kLength, kClusterRadii, pieces.cluster_radius},
                      {"budget", 0, kMaxBudget, pieces.budget}});
  };
  pieces.is_wanted = contact.within("pieces", read) ? 1 : 0;
}

void read_rigid(Section& contact, RigidConfig& rigid) {
  contact.within("rigid", [&](Section& section) {
    section.read_all({{"k_s", kRigidGains, rigid.k_s},
                      {"margin", kLength, kMargins, rigid.margin},
                      {"moves", 1, kMaxMoves, rigid.moves},
                      {"solver", kRigidSolvers, rigid.solver}});
  });
}

void check_rigid(Section& root, const SessionConfig& config) {
  if (config.rigid.solver != RigidSolver::kLcp) return;
  for (uint32_t i = 0; i < config.n_objects; ++i) {
    const ObjectConfig& object = config.objects[i];
    if (object.material.friction_static == 0) continue;
    root.section("contact")->section("rigid")->fail_at(
        "solver", "is \"lcp\", which knows no friction, and object '" + shown(view(object.name)) +
                      "' has some; write solver = \"coulomb\" or take the friction away");
  }
}

}  // namespace haptic
