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
  auto section = root.section("tool");
  if (!section) return;
  read_shape(*section, config_folder, tool);
  read_colour(*section, tool);
  read_mass(*section, kToolMasses, {tool.density, tool.mass, tool.inertia});
  section->finish();
}

void read_proxy(Section& root, ProxyConfig& proxy) {
  auto section = root.section("proxy");
  if (!section) return;
  SoftSolver solver{};
  if (section->read_choice("solver", words(kSolvers), solver)) proxy.solver = solver;
  section->read_choice("integrator", words(kIntegrators), proxy.integrator);
  section->read_all({{"contact_stiffness", kStiffness, kPositive, proxy.contact_stiffness},
                     {"contact_damping", kDamping, kNotNegative, proxy.contact_damping}});
  section->read_choice("sharing", words(kSharings), proxy.sharing);
  section->finish();
}

Range band_range(const VoxelConfig& voxel) {
  return {(voxel.offset_layers + 1) * voxel.size, 100 * voxel.size};
}

void read_voxel(Section& contact, VoxelConfig& voxel) {
  auto section = contact.section("voxel");
  if (!section) return;
  voxel.is_wanted = 1;
  section->read_quantity("size", kLength, kVoxelSizes, voxel.size);
  voxel.point_spacing = voxel.size;
  section->read_integer("offset_layers", 0, kMaxOffsetLayers, voxel.offset_layers);
  section->read_flag("field", voxel.field);
  voxel.band = default_band(voxel);
  section->read_quantity("band", kLength, band_range(voxel), voxel.band);
  section->read_flag("open_as_sheet", voxel.open_as_sheet);
  section->read_all({{"point_spacing", kLength, kVoxelSizes, voxel.point_spacing},
                     {"stiffness", kStiffness, kPositive, voxel.stiffness},
                     {"braking", kDamping, kNotNegative, voxel.braking}});
  section->read_choice("braking_along", words(kBrakings), voxel.braking_along);
  section->read_integer("budget", 0, kMaxBudget, voxel.budget);
  section->finish();
}

void read_pieces(Section& contact, PieceConfig& pieces) {
  auto section = contact.section("pieces");
  if (!section) return;
  pieces.is_wanted = 1;
  section->read_all({{"threshold", kLength, kThresholds, pieces.threshold},
                     {"carry", kLength, kThresholds, pieces.carry},
                     {"bandwidth", kFrequency, kNotNegative, pieces.bandwidth},
                     {"cluster_radius", kLength, kClusterRadii, pieces.cluster_radius}});
  section->read_integer("budget", 0, kMaxBudget, pieces.budget);
  section->finish();
}

void read_rigid(Section& contact, RigidConfig& rigid) {
  auto section = contact.section("rigid");
  if (!section) return;
  section->read_number("k_s", kRigidGains, rigid.k_s);
  section->read_quantity("margin", kLength, kMargins, rigid.margin);
  section->read_integer("moves", 1, kMaxMoves, rigid.moves);
  section->read_choice("solver", words(kRigidSolvers), rigid.solver);
  section->finish();
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
