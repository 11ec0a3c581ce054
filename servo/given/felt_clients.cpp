// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/given/felt_clients.h"

#include <algorithm>
#include <cmath>

#include "proto/math/assert.h"
#include "proto/math/motion_metric.h"
#include "proto/wire/mapping.h"
#include "proto/wire/renderer.h"
#include "servo/render/body_solver.h"

namespace haptic {
namespace {

constexpr double kPointLever = 0.01;  // of the torque on a tool that is a point [m]

/// From the origin of the tool to the farthest of its points [m]; 0: it is a point.
double rim_of(const ServoModel& model, const ContactSet& set) {
  const auto renderer = static_cast<Renderer>(set.renderer);
  if (!is_renderer(set.renderer) || !is_of_body(renderer)) return 0;
  const ToolBody& tool = tool_in_force(model, set);
  return norm(tool.centre_T) + tool.radius;
}

/// Of the torque that a client's force may make [m].
double lever_of(const ServoModel& model, const ContactSet& set) {
  return std::max(rim_of(model, set), kPointLever);
}

/// F0 + K δ − B V.
Wrench wrench_at(const ToolWrench& w, const RenderQuestion& question, double rim) {
  Mat6 K, B;
  K.a = w.K;
  B.a = w.B;
  const Twist way = way_between(w.X_WT, question.X_WT);
  const Twist trusted = limit_travel(way, rim, std::max(w.trust_radius, 0.0)).motion;
  return w.F0_W + K * trusted + -(B * question.V_WT);
}

/// No longer than `most`.
Vec3 bounded(const Vec3& v, double most) {
  const double length = norm(v);
  if (length <= most) return v;
  return std::isfinite(length) ? std::max(most, 0.0) / length * v : Vec3{};
}

/// Puts each client's planes together.
std::array<Wrench, kMostClients> planes_of(const TickScene& scene, const Rendered& rendered,
                                           const KeptShares& shares) {
  std::array<Wrench, kMostClients> sum_W{};
  for (size_t s = 0; s < scene.surfaces.size(); ++s) {
    const size_t body = scene.n_objects() + s;
    Wrench& of_client_W = sum_W[scene.surfaces[s].client];
    of_client_W = of_client_W + shares[body] * rendered.push_W[body];
  }
  return sum_W;
}

}  // namespace

void note_work(const ServoModel& model, const Pose& X_BH, FeltClientsState& state) {
  const Twist way = state.X_BH ? way_between(*state.X_BH, X_BH) : Twist{};
  for (size_t c = 0; c < state.clients.size(); ++c) {
    FeltClientsState::Client& client = state.clients[c];
    const double work = dot(client.felt_B, way);
    const double sound = std::isfinite(work) ? work : 0;
    client.bank.note(sound, model.dt, model.clients[c].max_power);
    client.energy += sound;
  }
}

double share_of(const ServoModel& model, const FeltClientsState& state, uint32_t client) {
  return state.clients[client].bank.share(model.clients[client].max_power);
}

void keep_surfaces(const ServoModel& model, const RenderQuestion& question,
                   const Rendered& rendered, KeptShares& shares) {
  const TickScene& scene = question.scene;
  if (scene.surfaces.empty()) return;
  const auto planes_W = planes_of(scene, rendered, shares);
  const double lever = lever_of(model, question.contacts);
  for (size_t s = 0; s < scene.surfaces.size(); ++s) {
    const uint32_t c = scene.surfaces[s].client;
    const double most = model.clients[c].max_force;
    const double force = norm(planes_W[c].f), torque = norm(planes_W[c].t);
    double& share = shares[scene.n_objects() + s];
    const double by_force = force > most ? most / force : 1;
    const double by_torque = torque > most * lever ? most * lever / torque : 1;
    share *= std::min(by_force, by_torque);
  }
}

FeltOfClients felt_of_clients(const ServoModel& model, const FeltClientsState& state,
                              const RenderQuestion& question, const KeptShares& shares,
                              const Rendered& rendered) {
  FeltOfClients out;
  if (question.scene.surfaces.empty() && question.contacts.wrenches.empty()) return out;
  out.of_client_W = planes_of(question.scene, rendered, shares);
  const double rim = rim_of(model, question.contacts);
  const double lever = lever_of(model, question.contacts);
  std::array<Wrench, kMostClients> wrench_W{};
  for (const AppliedWrench& applied : question.contacts.wrenches) {
    const uint32_t c = applied.giver - moved_by_client(0);
    if (c >= kMostClients) continue;
    const double weight = std::clamp(applied.weight, 0.0, 1.0) * question.scene.weight;
    wrench_W[c] = wrench_W[c] + weight * wrench_at(applied.wrench, question, rim);
  }
  for (size_t c = 0; c < kMostClients; ++c) {
    if (wrench_W[c] == Wrench{}) continue;
    const Wrench& planes_W = out.of_client_W[c];
    const double most = model.clients[c].max_force;
    const double share = share_of(model, state, static_cast<uint32_t>(c));
    const Wrench felt_W{share * bounded(wrench_W[c].f, most - norm(planes_W.f)),
                        share * bounded(wrench_W[c].t, most * lever - norm(planes_W.t))};
    out.finite &= is_finite(felt_W);
    out.of_client_W[c] = out.of_client_W[c] + felt_W;
    out.wrenches_W = out.wrenches_W + felt_W;
  }
  return out;
}

void keep_felt(const ServoModel& model, const Pose& X_BH, const FeltOfClients& felt,
               const FeltShare& share, FeltClientsState& state) {
  state.X_BH = X_BH;
  for (size_t c = 0; c < kMostClients; ++c) {
    const Wrench& F_W = felt.of_client_W[c];
    Wrench& felt_B = state.clients[c].felt_B;
    felt_B = {};
    if (F_W == Wrench{}) continue;
    const Wrench F_B = device_wrench(model.map, X_BH, F_W);
    felt_B.f = share.force * F_B.f;
    if (model.limits.max_torque > 0) felt_B.t = share.torque * F_B.t;
  }
}

void note_felt(const ServoModel& model, const FeltClientsState& state, const FeltOfClients& felt,
               const ContactSet& set, ServoFrame& frame) {
  std::array<bool, kMostClients> is_there{};
  const auto see = [&](uint32_t giver) {
    const uint32_t c = giver - moved_by_client(0);
    if (c < kMostClients) is_there[c] = true;
  };
  for (const AppliedWrench& applied : set.wrenches) see(applied.giver);
  for (const Contact& contact : set.contacts) see(contact.giver);
  for (uint32_t c = 0; c < kMostClients; ++c) {
    if (!is_there[c]) continue;
    const FeltClientsState::Client& client = state.clients[c];
    frame.felt.push_back({felt.of_client_W[c], client.energy, share_of(model, state, c), c, 0});
  }
}

}  // namespace haptic
