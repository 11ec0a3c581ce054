// SPDX-License-Identifier: Apache-2.0
#include "proto/config/read/config_body.h"

#include <algorithm>

namespace haptic {

using enum Dimension;

namespace {

constexpr Range kBodyMasses{1e-3, 100};  // [kg]; lighter is less than a tick of any coupling moves
constexpr Range kDensities{1, 25e3};     // [kg/m³]
constexpr Range kRestitutions{0, 1};
constexpr Range kSimRates{50, 1e3};       // [Hz]; kExtrapolationNs is 20 ms
constexpr double kPushedRate = 1000;      // of what can be pushed, that of the hand [Hz]
constexpr Range kGravities{-1000, 1000};  // [m/s²]
constexpr Range kReaches{0.01, 100};      // [m]

}  // namespace

void read_mass(Section& section, const Range& masses, const MassKeys& keys) {
  const auto& [density, mass, inertia] = keys;
  const bool any_mass = section.read_quantity("mass", kMass, masses, mass);
  const bool any_inertia = section.read_quantities("inertia", kInertia, kPositive, inertia);
  section.read_quantity("density", kDensity, kDensities, density);
  if (density > 0 && (any_mass || any_inertia)) {
    section.fail_at("density", "says what 'mass' and 'inertia' say; leave one of them out");
  }
  const double sum = inertia.x + inertia.y + inertia.z;
  for (int k = 0; k < 3; ++k) {
    if (2 * inertia[k] <= sum * (1 + 1e-9)) continue;
    section.fail_at("inertia",
                    "belongs to no body: one moment is larger than the two others "
                    "together; write the moments about x, y, z");
  }
}

void read_body(Section& object, const ObjectConfig& about, BodyConfig& body) {
  object.within("body", [&](Section& section) {
    read_mass(section, kBodyMasses, {body.density, body.mass, body.inertia});
    section.read_number("restitution", kRestitutions, body.restitution);
    if (!has_mass(body)) {
      section.fail_missing("density", "density = \"1 g/cm³\", or mass = \"50 g\"");
    }
    if (!row_of(about.motion.kind).is_still) {
      object.fail_at("motion", "moves an object that has a [object.body]; leave one of them out");
    }
  });
}

void read_sim(Section& root, SessionConfig& config) {
  const auto objects = std::span(config.objects).first(config.n_objects);
  const bool any_mass = std::ranges::any_of(
      objects, [](const ObjectConfig& object) { return has_mass(object.body); });
  const auto clients = std::span(config.clients).first(config.n_clients);
  const bool any_given =
      std::ranges::any_of(clients, [](const ClientConfig& client) { return client.n_moves > 0; });
  if (any_mass || any_given) config.sim_rate = kPushedRate;
  root.within("sim", [&](Section& section) {
    section.read_all({{"rate", kFrequency, kSimRates, config.sim_rate},
                      {"gravity", kAcceleration, kGravities, config.gravity_W},
                      {"reach", kLength, kReaches, config.sim_reach}});
  });
}

}  // namespace haptic
