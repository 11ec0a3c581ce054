// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/given/felt_clients.h"

#include <algorithm>
#include <cmath>

#include "proto/math/assert.h"
#include "proto/math/motion_metric.h"
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

void note_work(const ServoModel& model, const Twist& way, FeltClientsState& state) {
  // the hand is given so much at the handle of what the wrench does on the tool
  const double at_handle = model.map.force_scale / model.map.motion_scale;
  for (size_t c = 0; c < state.clients.size(); ++c) {
    FeltClientsState::Client& client = state.clients[c];
    const double work = at_handle * dot(client.felt_W, way);
    const double sound = std::isfinite(work) ? work : 0;
    client.bank.note(sound, model.dt, model.clients[c].max_power);
    client.energy += sound;
  }
}

void keep_surfaces(const ServoModel& model, const FeltClientsState& state, const TickScene& scene,
                   const Rendered& rendered, KeptShares& shares) {
  const auto planes_W = planes_of(scene, rendered, shares);
  for (size_t s = 0; s < scene.surfaces.size(); ++s) {
    const uint32_t c = scene.surfaces[s].client;
    const ClientLimits& limits = model.clients[c];
    const double force = norm(planes_W[c].f);
    const double most = force > limits.max_force ? limits.max_force / force : 1;
    shares[scene.n_objects() + s] *= most * state.clients[c].bank.share(limits.max_power);
  }
}

FeltOfClients felt_of_clients(const ServoModel& model, const FeltClientsState& state,
                              const RenderQuestion& question, const KeptShares& shares,
                              const Rendered& rendered) {
  FeltOfClients out;
  out.of_client_W = planes_of(question.scene, rendered, shares);
  const double rim = rim_of(model, question.contacts);
  const double lever = std::max(rim, kPointLever);
  std::array<Wrench, kMostClients> wrench_W{};
  for (const AppliedWrench& applied : question.contacts.wrenches) {
    const uint32_t c = applied.giver - moved_by_client(0);
    if (c >= kMostClients) continue;
    const double weight = std::clamp(applied.weight, 0.0, 1.0) * question.scene.weight;
    wrench_W[c] = wrench_W[c] + weight * wrench_at(applied.wrench, question, rim);
  }
  for (size_t c = 0; c < kMostClients; ++c) {
    if (wrench_W[c] == Wrench{}) continue;
    const ClientLimits& limits = model.clients[c];
    const double left = limits.max_force - norm(out.of_client_W[c].f);
    const double share = state.clients[c].bank.share(limits.max_power);
    const Wrench felt_W{share * bounded(wrench_W[c].f, left),
                        share * bounded(wrench_W[c].t, left * lever)};
    out.finite &= is_finite(felt_W);
    out.of_client_W[c] = out.of_client_W[c] + felt_W;
    out.wrenches_W = out.wrenches_W + felt_W;
  }
  return out;
}

void keep_felt(const FeltOfClients& felt, const FeltShare& share, FeltClientsState& state) {
  for (size_t c = 0; c < kMostClients; ++c) {
    const Wrench& F_W = felt.of_client_W[c];
    state.clients[c].felt_W = {share.force * F_W.f, share.torque * F_W.t};
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
    frame.felt.push_back(
        {felt.of_client_W[c], client.energy, client.bank.share(model.clients[c].max_power), c, 0});
  }
}

}  // namespace haptic
