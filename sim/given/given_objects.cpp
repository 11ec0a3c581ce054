// SPDX-License-Identifier: GPL-3.0-or-later
#include "sim/given/given_objects.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <optional>

#include "proto/math/assert.h"
#include "proto/math/units.h"
#include "proto/wire/scene_pose.h"
#include "sim/given/statement.h"

namespace haptic {
namespace {

constexpr double kFade = 0.050;                 // in which an object is let go, or let in [s]
constexpr double kCutFade = 0.020;              // in which a client is cut [s]
constexpr int64_t kCutNs = 1'000'000'000;       // for which it is
constexpr double kCutAt = 0.5;                  // share of its energy: the fade needs some
constexpr int64_t kMostReplayedNs = 250 * kMs;  // in a step, of all objects but the first
constexpr int64_t kCorrectionNs = 5 * kMs;      // that a correction costs beside, as replayed
constexpr int64_t kUsualPeriodNs = 10 * kMs;    // until there is a median

/// A push moves the object.
bool answers(const GivenMotion& said) {
  return std::ranges::any_of(said.mobility, [](double m) { return m != 0; });
}

/// The pushes of all hands after the ticks that a client has used, in the order of their instants.
class PushReader {
 public:
  PushReader(std::span<const PushHistory> histories, const GivenMotion& said, size_t object)
      : histories_(histories), object_(object) {
    for (size_t hand = 0; hand < histories.size(); ++hand) {
      const auto used =
          answers(said) ? histories[hand].find(said.ticks[hand]) : std::optional<uint64_t>();
      next_[hand] = used ? *used + 1 : histories[hand].end();
    }
  }

  struct Push {
    int64_t t_ns;
    Wrench impulse_W, late_W;  // since the frame before, and its integral until t_ns
  };
  std::optional<Push> next() {
    size_t first = histories_.size();
    for (size_t hand = 0; hand < histories_.size(); ++hand) {
      if (next_[hand] == histories_[hand].end()) continue;
      if (first == histories_.size() || t_ns(hand) < t_ns(first)) first = hand;
    }
    if (first == histories_.size()) return std::nullopt;
    const PushHistory& history = histories_[first];
    const uint64_t n = next_[first]++;
    const auto& [J_before, S_before] = history.push(n - 1, object_);
    const auto& [J, S] = history.push(n, object_);
    const double between = seconds_of(history.t_ns(n) - history.t_ns(n - 1));
    return Push{history.t_ns(n), J + -J_before, S + -S_before + -between * J_before};
  }

 private:
  int64_t t_ns(size_t hand) const { return histories_[hand].t_ns(next_[hand]); }

  std::span<const PushHistory> histories_;
  size_t object_;
  std::array<uint64_t, kMostHands> next_{};
};

/// What the client's frame means now: its state, and every push that it has not used.
ModelState replayed(const GivenState& state, size_t object, int64_t until_ns) {
  const GivenMotion& said = state.objects[object].said;
  ModelState at{said.X_WO, said.V_WO};
  int64_t t_ns = said.t_ns;
  PushReader pushes(state.histories, said, object);
  while (const auto pushed = pushes.next()) {
    Wrench late_W = pushed->late_W;
    if (pushed->t_ns > t_ns) {
      drift(said, at, seconds_of(std::min(pushed->t_ns, until_ns) - std::min(t_ns, until_ns)));
      t_ns = pushed->t_ns;
    } else {
      late_W = late_W + seconds_of(t_ns - pushed->t_ns) * pushed->impulse_W;
    }
    push(said, at, pushed->impulse_W, late_W);
  }
  if (t_ns < until_ns) {
    drift(said, at, seconds_of(until_ns - t_ns));
  } else {
    at.X_WO = extrapolate(at.X_WO, at.V_WO, -seconds_of(t_ns - until_ns));
  }
  return at;
}

int64_t period_of(const GivenClientState& client) {
  const int64_t median_ns = client.heard.median_period_ns();
  return median_ns > 0 ? median_ns : kUsualPeriodNs;
}

ModelState shown(const GivenObjectState& object) {
  const auto* guarded = std::get_if<GuardedModel>(&object.model);
  return guarded != nullptr ? guarded->at() : std::get<FollowingModel>(object.model).shown();
}

/// Steps of sim in a period of the client.
int ticks_in(int64_t period_ns, double step) {
  return static_cast<int>(std::lround(seconds_of(period_ns) / step));
}

/// It fades, and stands meanwhile.
void let_go(GivenObjectState& object) {
  object.phase = GivenPhase::kLetGo;
  std::visit([](auto& moving) { moving.stop(); }, object.model);
}

/// Takes a statement over into the model. An object that is about to be let in is put where it is
/// said to be.
void correct(const GivenModel& model, GivenState& state, size_t k, int64_t t_ns) {
  GivenObjectState& object = state.objects[k];
  const int64_t period_ns = period_of(state.clients[model.objects[k].client]);
  const ModelState now = replayed(state, k, t_ns);
  if (!object.is_placed) {
    if (answers(object.said)) {
      object.model.emplace<GuardedModel>().place(now, object.said);
    } else {
      object.model.emplace<FollowingModel>().place(now, object.said);
    }
    object.is_placed = true;
  } else if (auto* guarded = std::get_if<GuardedModel>(&object.model)) {
    // held back until it left the scene, it is put anew where its client has it
    const GivenObject& given = model.objects[k];
    is_out_of_reach(guarded->at().X_WO, given.X_WO, model.reach)
        ? let_go(object)
        : guarded->correct(now, object.said, ticks_in(period_ns, model.period));
  } else {
    std::get<FollowingModel>(object.model).correct(now, object.said, period_ns);
  }
  object.is_new = false;
}

/// Weight of what a client gives, by its age and by the power that it has given.
double weight_of(const GivenClient& known, GivenClientState& client, int64_t t_ns, double dt) {
  const double most = kCutAt * known.config.max_power;
  if (client.power.energy(t_ns) > most) client.cut_until_ns = t_ns + kCutNs;
  const double weight = client.heard.weigh(t_ns, std::max(dt, 1e-6));
  return t_ns < client.cut_until_ns ? 0 : weight;
}

/// The share of an object goes towards what its client's weight allows.
void let_in(GivenObjectState& object, double weight, bool is_cut, double dt) {
  if (object.phase == GivenPhase::kStands) {
    object.share = std::min(1.0, object.share + dt / kFade);
    if (object.is_said) object.phase = GivenPhase::kLetGo;
    return;
  }
  const bool follows = object.phase == GivenPhase::kFollows;
  // what is not felt stands until it is put where its client has it
  const double wanted = follows && object.is_placed ? weight : 0;
  const double fall = dt / (is_cut ? kCutFade : kFade);
  object.share = wanted < object.share ? std::max(wanted, object.share - fall)
                                       : std::min(wanted, object.share + dt / kFade);
  if (object.share > 0) return;
  object.is_placed = follows && object.is_placed && weight > 0;
  object.phase = GivenPhase::kFollows;
}

/// The pushes of all hands since the last step, by object.
std::array<NewPush, kMaxBodies> take_all(GivenState& state, const GivenModel& model,
                                         std::span<const ServoFrame* const> hands) {
  std::array<NewPush, kMaxBodies> all{};
  for (size_t hand = 0; hand < hands.size(); ++hand) {
    if (hands[hand] == nullptr) continue;
    const NewPushes pushes = take_pushes(state.seen[hand], *hands[hand], state.t_ns);
    for (size_t k = 0; k < model.objects.size(); ++k) {
      const NewPush& push = pushes[model.first_response + k];
      all[k].impulse_W = all[k].impulse_W + push.impulse_W;
      all[k].late_W = all[k].late_W + push.late_W;
    }
  }
  return all;
}

/// How much of the past a statement makes sim look at, and what each costs beside it [ns].
int64_t replay_ns(const GivenState& state, const GivenMotion& said, int64_t t_ns) {
  int64_t oldest_ns = said.t_ns;
  for (size_t hand = 0; answers(said) && hand < state.histories.size(); ++hand) {
    const PushHistory& history = state.histories[hand];
    if (const auto used = history.find(said.ticks[hand])) {
      oldest_ns = std::min(oldest_ns, history.t_ns(*used));
    }
  }
  return std::max<int64_t>(t_ns - oldest_ns, 0) + kCorrectionNs;
}

/// Corrects the models by statements that are new, as far as the step's budget reaches; the first
/// one in any case.
void correct_models(const GivenModel& model, GivenState& state, int64_t t_ns) {
  const size_t n = model.objects.size();
  int64_t left_ns = kMostReplayedNs;
  for (size_t i = 0; i < n && left_ns > 0; ++i) {
    const size_t k = (state.turn + i) % n;
    GivenObjectState& object = state.objects[k];
    const double weight = state.clients[model.objects[k].client].weight;
    if (!object.is_new || object.phase != GivenPhase::kFollows) continue;
    if (!object.is_placed && !(weight > 0)) continue;
    // the client is behind by more than it may be
    if (t_ns - object.said.t_ns > kOldestGivenNs) {
      object.is_new = false;
      continue;
    }
    left_ns -= replay_ns(state, object.said, t_ns);
    correct(model, state, k, t_ns);
    state.turn = (k + 1) % n;
  }
}

/// Energy in the coupling of a hand that presses with that force [J]: of a spring, and where the
/// force is cut to max_force that of a constant force beyond it, F d − F²/2k.
double spring_energy(double force, const SeenHand& hand, double share) {
  const double k = share * hand.stiffness;
  const bool is_cut = k > 0 && force < k * hand.depth;
  return is_cut ? force * (hand.depth - 0.5 * force / k) : 0.5 * force * hand.depth;
}

/// Moves an object that follows its client. One that is not felt stands.
void move(GivenState& state, size_t k, const NewPush& pushed, double dt) {
  GivenObjectState& object = state.objects[k];
  if (object.share == 0 || object.phase != GivenPhase::kFollows) {
    std::visit([](auto& moving) { moving.stop(); }, object.model);
  } else if (auto* guarded = std::get_if<GuardedModel>(&object.model)) {
    HandsOnObject hands{pushed.impulse_W, pushed.late_W, object.work};
    for (size_t hand = 0; hand < state.histories.size(); ++hand) {
      const PushHistory& history = state.histories[hand];
      if (history.end() - history.begin() < 2) continue;
      const uint64_t n = history.end() - 1;
      const Wrench J_W = history.push(n, k).impulse_W + -history.push(n - 1, k).impulse_W;
      const double force = norm(J_W.f) / seconds_of(history.t_ns(n) - history.t_ns(n - 1));
      hands.spring += spring_energy(force, state.hands[hand], object.share);
      hands.stiffness = std::max(hands.stiffness, state.hands[hand].stiffness);
    }
    guarded->step(hands, dt);
  } else {
    std::get<FollowingModel>(object.model).step(dt);
  }
}

/// Lets an object of numbers that have become none stand where the session file has it.
void forget(const GivenModel& model, GivenState& state, size_t k) {
  GivenObjectState& object = state.objects[k];
  object.model.emplace<FollowingModel>().place({model.objects[k].X_WO, {}}, {});
  object.is_said = object.is_new = object.is_placed = false;
  object.share = 0;
}

void note_objects(const GivenModel& model, const GivenState& state, SceneFrame& frame) {
  for (size_t k = 0; k < model.objects.size(); ++k) {
    const GivenObject& given = model.objects[k];
    const GivenObjectState& object = state.objects[k];
    SceneObject& out = frame.objects[given.object];
    out.reduction = 1 - object.share;
    const ModelState at = shown(object);
    if (object.phase != GivenPhase::kStands) {
      out.most_force = model.clients[given.client].config.max_force;
    }
    if (object.phase != GivenPhase::kFollows) {
      out.X_WO = at.X_WO;
      continue;
    }
    out.X_WO = at.X_WO;
    out.V_WO = at.V_WO;
    out.mover = moved_by_client(given.client);
  }
}

void note_clients(const GivenModel& model, const GivenState& state, SceneFrame& frame) {
  for (uint32_t c = 0; c < model.clients.size(); ++c) {
    const GivenClientState& client = state.clients[c];
    if (model.clients[c].objects.empty()) continue;
    GiverState out = client.heard.report(c, frame.t_ns);
    out.given_power = client.power.energy(frame.t_ns);
    if (frame.t_ns < client.cut_until_ns) out.flags |= kGiverCut;
    for (const uint32_t k : model.clients[c].objects) {
      const auto* guarded = std::get_if<GuardedModel>(&state.objects[k].model);
      if (guarded != nullptr && guarded->is_held_back()) out.flags |= kGiverSoftened;
    }
    frame.givers.push_back(out);
  }
}

/// Why a statement of this client cannot be used.
GiverRefusal refusal_in(const GivenModel& model, const GivenState& state, uint32_t client,
                        const GivenMotion& said, size_t k, int64_t t_ns) {
  if (!(said.power >= 0 && said.power <= model.clients[client].config.max_power)) {
    return GiverRefusal::kTooStrong;
  }
  const GivenObjectState& object = state.objects[k];
  if (const GiverRefusal why = refusal_of(said); why != GiverRefusal::kNone) return why;
  if (is_out_of_reach(said.X_WO, model.objects[k].X_WO, model.reach)) return GiverRefusal::kTooFast;
  const bool is_old = object.is_said && said.t_ns < object.said.t_ns;
  if (is_old || said.t_ns > t_ns + kClientFutureNs || said.t_ns < t_ns - kOldestGivenNs) {
    return GiverRefusal::kBackInTime;
  }
  for (size_t hand = 0; hand < state.histories.size(); ++hand) {
    const PushHistory& history = state.histories[hand];
    const uint64_t tick = said.ticks[hand];
    const auto used = history.find(tick);
    // a servo that has begun anew counts its ticks anew
    const bool goes_back = object.is_said && tick < object.said.ticks[hand] &&
                           history.find(object.said.ticks[hand]).has_value();
    const bool is_near = used && std::abs(history.t_ns(*used) - said.t_ns) <= kOldestGivenNs;
    if (answers(said) && (goes_back || !is_near)) return GiverRefusal::kUnknownTick;
  }
  return GiverRefusal::kNone;
}

size_t place_of(const GivenModel& model, uint32_t object) {
  return static_cast<size_t>(std::ranges::find(model.objects, object, &GivenObject::object) -
                             model.objects.begin());
}

GiverRefusal refusal_in(const GivenModel& model, const GivenState& state, uint32_t client,
                        const GivenFrame& given, int64_t t_ns) {
  const GiverRefusal wrong = state.clients[client].heard.wrong_time(given, t_ns);
  if (wrong != GiverRefusal::kNone) return wrong;
  if (!may_give(model.clients[client].config, given)) return GiverRefusal::kNotAllowed;
  for (size_t i = 0; i < given.moves.size(); ++i) {
    const GivenMotion& said = given.moves[i];
    const auto before = std::span(given.moves.data(), i);
    const bool is_twice =
        std::ranges::find(before, said.object, &GivenMotion::object) != before.end();
    const size_t k = place_of(model, said.object);
    const GiverRefusal why =
        is_twice ? GiverRefusal::kNotAllowed : refusal_in(model, state, client, said, k, t_ns);
    if (why != GiverRefusal::kNone) return why;
  }
  return GiverRefusal::kNone;
}

}  // namespace

ModelState FollowingModel::shown() const {
  const double left = std::clamp(1 - since_ / period_, 0.0, 1.0);
  return left > 0 ? moved(at_, left, gap_) : at_;
}

void FollowingModel::place(const ModelState& at, const GivenMotion& said) {
  said_ = said;
  at_ = at;
  gap_ = {};
}

void FollowingModel::correct(const ModelState& replayed, const GivenMotion& said,
                             int64_t period_ns) {
  const ModelState before = shown();
  said_ = said;
  at_ = replayed;
  gap_ = gap_between(at_, before);
  since_ = 0;
  period_ = seconds_of(period_ns);
}

void FollowingModel::step(double dt) {
  drift(said_, at_, dt);
  since_ += dt;
}

GivenModel build_given(const SessionConfig& config, uint32_t first_response) {
  GivenModel model;
  model.first_response = first_response;
  model.period = 1 / config.sim_rate;
  model.reach = config.sim_reach;
  for (uint32_t c = 0; c < config.n_clients; ++c) {
    const ClientConfig& client = config.clients[c];
    GivenClient made{client, {}};
    for (uint32_t i = 0; i < client.n_moves; ++i) {
      made.objects.push_back(static_cast<uint32_t>(model.objects.size()));
      const uint32_t object = client.moves[i];
      model.objects.push_back({object, c, config.objects[object].X_WO});
    }
    model.clients.push_back(std::move(made));
  }
  return model;
}

GivenState begin_given(const GivenModel& model, uint32_t n_hands) {
  GivenState state;
  state.objects.resize(model.objects.size());
  for (size_t k = 0; k < model.objects.size(); ++k) {
    std::get<FollowingModel>(state.objects[k].model).place({model.objects[k].X_WO, {}}, {});
  }
  state.clients.resize(model.clients.size());
  for (uint32_t hand = 0; hand < n_hands && !model.objects.empty(); ++hand) {
    state.histories.emplace_back(model.objects.size(), model.first_response);
  }
  return state;
}

void resume_given(const GivenModel& model, GivenState& state, const SceneFrame& last) {
  for (size_t k = 0; k < model.objects.size(); ++k) {
    const SceneObject& object = last.objects[model.objects[k].object];
    if (k < last.world_pushes.size()) state.objects[k].by_bodies = last.world_pushes[k];
    state.objects[k].share = std::clamp(1 - object.reduction, 0.0, 1.0);
    if (object.mover == kMovedBySim) continue;
    std::get<FollowingModel>(state.objects[k].model).place({object.X_WO, {}}, {});
    state.objects[k].phase = GivenPhase::kFollows;
    state.objects[k].share = 0;
  }
}

void see_hand(const GivenModel& model, GivenState& state, uint32_t hand, const ServoFrame& frame) {
  if (hand >= state.histories.size()) return;
  PushHistory& history = state.histories[hand];
  history.add(frame);
  const SeenHand before = state.hands[hand];
  if (!is_finite(frame.X_WT) || !std::isfinite(frame.depth)) return;
  state.hands[hand] = {frame.X_WT, frame.depth, frame.translational_stiffness};
  const uint64_t n = history.end() - 1;
  if (history.end() - history.begin() < 3) return;
  const Twist way = way_between(before.X_WT, frame.X_WT);
  for (size_t k = 0; k < model.objects.size(); ++k) {
    const Wrench F_W = 1 / seconds_of(history.t_ns(n) - history.t_ns(n - 1)) *
                       (history.push(n - 1, k).impulse_W + -history.push(n - 2, k).impulse_W);
    if (F_W == Wrench{}) continue;
    GivenObjectState& object = state.objects[k];
    // the force of the tick before was held until this one
    const Vec3 arm_W = shown(object).X_WO.p - before.X_WT.p;
    const double work = dot(F_W, Twist{velocity_at(way, arm_W), way.w});
    if (!std::isfinite(work)) continue;
    object.work += work;
    state.clients[model.objects[k].client].power.add(-work, frame.t_ns);
  }
}

void set_giving(const GivenModel& model, GivenState& state, uint32_t client, uint64_t generation) {
  HAPTIC_ASSERT(client < state.clients.size());
  if (!state.clients[client].heard.follow(generation)) return;
  // what its predecessor moved fades, and is then put where this one has it
  for (const uint32_t k : model.clients[client].objects) {
    GivenObjectState& object = state.objects[k];
    if (object.phase == GivenPhase::kFollows) let_go(object);
    object.is_said = object.is_new = false;
  }
}

void see_client(const GivenModel& model, GivenState& state, uint32_t client, uint64_t generation,
                const GivenFrame& given, int64_t t_ns) {
  HAPTIC_ASSERT(client < state.clients.size());
  HeardClient& heard = state.clients[client].heard;
  if (!heard.look_at(generation, given, t_ns)) return;
  const GiverRefusal why = refusal_in(model, state, client, given, t_ns);
  heard.conclude(given, why, t_ns);
  if (why != GiverRefusal::kNone) return;
  for (const GivenMotion& said : given.moves) {
    GivenObjectState& object = state.objects[place_of(model, said.object)];
    // one that answers pushes from now on, or does no more, is let go first
    const bool changes = object.is_placed && answers(said) != answers(object.said);
    if (changes) let_go(object);
    object.said = said;
    object.said.X_WO.q = normalized(said.X_WO.q);
    object.is_said = object.is_new = true;
  }
}

void step_given(const GivenModel& model, GivenState& state,
                std::span<const ServoFrame* const> hands, SceneFrame& frame) {
  HAPTIC_ASSERT(state.objects.size() == model.objects.size());
  const int64_t last_ns = state.t_ns != 0 ? state.t_ns : frame.t_ns;
  // beyond it, readers have let the objects stand
  const double dt = seconds_of(std::clamp<int64_t>(frame.t_ns - last_ns, 0, kExtrapolationNs));
  const auto pushes = take_all(state, model, hands);
  for (uint32_t c = 0; c < model.clients.size(); ++c) {
    state.clients[c].weight = weight_of(model.clients[c], state.clients[c], frame.t_ns, dt);
  }
  for (size_t k = 0; k < model.objects.size(); ++k) {
    const GivenClientState& client = state.clients[model.objects[k].client];
    GivenObjectState& object = state.objects[k];
    let_in(object, client.weight, frame.t_ns < client.cut_until_ns, dt);
    move(state, k, pushes[k], dt);
    if (!is_finite(shown(object).X_WO) || !is_finite(shown(object).V_WO)) forget(model, state, k);
    object.work = 0;
  }
  state.t_ns = frame.t_ns;
  correct_models(model, state, frame.t_ns);
  note_objects(model, state, frame);
}

void push_by_bodies(GivenState& state, size_t k, const Wrench& impulse_W, double dt) {
  ObjectPush& push = state.objects[k].by_bodies;
  push.impulse_time_W = push.impulse_time_W + dt * push.impulse_W;
  push.impulse_W = push.impulse_W + impulse_W;
}

void note_given(const GivenModel& model, const GivenState& state, SceneFrame& frame) {
  for (size_t k = 0; k < model.objects.size(); ++k) {
    const GivenObjectState& object = state.objects[k];
    const auto response = static_cast<uint32_t>(frame.responses.size());
    frame.objects[model.objects[k].object].response = response;
    ObjectResponse answer{};
    if (object.phase == GivenPhase::kFollows) {
      answer = std::visit(
          [](const auto& moving) -> ObjectResponse {
            return {moving.acceleration(), moving.said().mobility};
          },
          object.model);
    }
    frame.responses.push_back(answer);
    frame.world_pushes.push_back(object.by_bodies);
    for (uint32_t hand = 0; hand < frame.n_hands; ++hand) {
      frame.seen.push_back(state.seen[hand].pushes[response]);
    }
  }
  note_clients(model, state, frame);
}

}  // namespace haptic
