// SPDX-License-Identifier: GPL-3.0-or-later
// haptic-sim: moves the scene and publishes the poses of the objects.
#include <algorithm>
#include <memory>
#include <span>
#include <vector>

#include "contact/bake/cache.h"
#include "contact/bake/session.h"
#include "proto/ipc/process.h"
#include "proto/os/priorities.h"
#include "proto/wire/behind.h"
#include "proto/wire/packing.h"
#include "sim/step.h"

namespace haptic {
namespace {

constexpr int64_t kPatienceNs = kNsPerSecond;  // longest wait for the session's segments
constexpr int64_t kLookNs = 1'000'000;         // between checks
// of a sim that moves bodies: it belongs to the hand's loop, below contact, above hapticd's threads

/// The newest frame of a hand, kept from step to step. Where clients move objects every frame
/// counts.
struct HandInbox {
  static constexpr int kMostAtOnce = 64;  // behind more than that, the rest is passed over

  uint32_t hand;
  RingSource<&ServoChannels::frames> frames;
  ServoFrame frame{};
  bool any = false;

  const ServoFrame* latest(const SimModel& model, SimState& state) {
    for (int n = 0; !model.given.objects.empty() && n < kMostAtOnce && frames.next(frame); ++n) {
      any = true;
      see_hand(model.given, state.given, hand, frame);
    }
    if (frames.latest(frame)) {
      any = true;
      see_hand(model.given, state.given, hand, frame);
    }
    return any ? &frame : nullptr;
  }
};

/// The rings of the clients that may move objects.
struct ClientInboxes {
  struct Inbox {
    uint32_t client;
    RingSource<&ClientChannels::frames> frames;
  };
  std::vector<Inbox> inboxes;
  GivenFrame frame{};

  explicit ClientInboxes(Child<SimChannels>& child) {
    for (uint32_t c = 0; c < child.config().n_clients; ++c) {
      if (child.config().clients[c].n_moves == 0) continue;
      inboxes.push_back({c, child.ring<&ClientChannels::frames>(Start::kNewest, c)});
    }
  }

  void take(const SimModel& model, SimState& state, const ControlFrame& control, int64_t t_ns) {
    for (Inbox& inbox : inboxes) {
      set_giving(model.given, state.given, inbox.client, control.giving[inbox.client]);
      // a client that floods costs no more than one that does not
      if (!state.given.clients[inbox.client].heard.is_due(t_ns)) continue;
      if (!inbox.frames.latest(frame)) continue;
      see_client(model.given, state.given, inbox.client, inbox.frames.item_generation(), frame,
                 t_ns);
    }
  }
};

/// A sim at that priority uses at most 60 % of a core: after a step of d it rests 2/3 d, and skips
/// the ticks that fall into it.
void rest_after(int64_t end_ns, int64_t busy_ns, int64_t next_deadline_ns) {
  const int64_t rested_ns = end_ns + busy_ns * 2 / 3;
  if (rested_ns > next_deadline_ns) sleep_until(rested_ns);
}

/// The last point of the grid before this process ran: it may have stood still in its sleep, and
/// what the hand has done since then belongs to no earlier step.
int64_t grid_point(const Tick& tick, int64_t period_ns) {
  return tick.deadline_ns + tick.late_ns / period_ns * period_ns;
}

/// Waits until what the session has is attached. hapticd sends its own segment last.
void await_session(RingSource<&ControlChannels::frames>& controls, ControlFrame& control) {
  const int64_t give_up_ns = now_ns() + kPatienceNs;
  while (!controls.latest(control) && now_ns() < give_up_ns) sleep_until(now_ns() + kLookNs);
}

/// The shapes of the objects where any has mass: contact has baked them, or does so now.
struct BakedBodies {
  std::vector<BakedShape> objects;
  std::vector<BakedPieces> pieces;
};

BakedBodies bake_where_needed(const SessionConfig& config) {
  const auto objects = std::span(config.objects).first(config.n_objects);
  BakedBodies baked;
  if (std::ranges::none_of(objects, [](const auto& o) { return has_mass(o.body); })) return baked;
  bake_apart();
  for (const ObjectConfig& object : objects) {
    baked.objects.push_back(bake_object(object, config.mesh_memory_limit));
  }
  baked.pieces = bake_collision_pieces(config, baked.objects);
  return baked;
}

int run(const ChildArguments& arguments) {
  Child<SimChannels> child(arguments);
  auto predecessors = child.ring<&SimChannels::frames>(Start::kOldest);
  auto controls = child.ring<&ControlChannels::frames>(Start::kOldest);
  std::vector<HandInbox> inboxes;
  for (uint32_t hand = 0; hand < child.n_hands(); ++hand) {
    inboxes.push_back({hand, child.ring<&ServoChannels::frames>(Start::kOldest, hand)});
  }
  ClientInboxes clients(child);
  const BakedBodies baked = bake_where_needed(child.config());
  std::vector<MeshShape> shapes;
  for (const BakedShape& object : baked.objects) shapes.push_back(object.shape);
  std::vector<PieceTree> pieces;
  for (const BakedPieces& object : baked.pieces) pieces.push_back(object.tree);
  const SimModel model = build_sim(child.config(), shapes, pieces);
  const auto state = std::make_unique<SimState>(model);
  child.attach();
  const bool is_pushed = model.moves_by_pushes();
  // four frames: the last, the next, that of a step and that of a reader
  child.enter_realtime({.fifo_priority = is_pushed ? kSimPriority : 0,
                        .lock_memory = is_pushed,
                        .prefault_stack = 4 * sizeof(SceneFrame) + 128 * 1024});

  ControlFrame control{};
  control.scene_time_scale = 1;
  await_session(controls, control);
  SceneFrame frame{};
  if (child.generation() > 1 && predecessors.latest(frame)) resume(model, *state, frame);
  BehindSince behind;
  uint64_t skipped = 0;
  const auto publish_step = [&](int64_t t_ns, int64_t begin_ns) {
    controls.latest(control);
    // a ring may hold anything
    const double time_scale = control.scene_time_scale >= 0 ? control.scene_time_scale : 0;
    HandFrames hands;
    for (HandInbox& inbox : inboxes) hands.push_back(inbox.latest(model, *state));
    clients.take(model, *state, control, t_ns);
    copy_in_use(sim_step(model, *state, hands, t_ns, time_scale), frame);
    frame.skipped = skipped;
    frame.behind_since_ns = behind.seen(skipped, t_ns);
    frame.busy_ns = now_ns() - begin_ns;
    child.channels().frames.publish(frame);
  };
  // offered only with a frame in it: whoever comes after this process finds where the bodies are
  // in the newest segment, whenever this one is killed
  const int64_t first_ns = now_ns();
  publish_step(first_ns, first_ns);
  child.offer();
  DeadlineClock clock(period_ns(child.config().sim_rate));
  while (!child.stopping()) {
    const Tick tick = clock.wait();
    child.beat(tick);
    skipped = tick.skipped;
    const int64_t t_ns = grid_point(tick, clock.period());
    publish_step(t_ns, tick.deadline_ns + tick.late_ns);
    if (is_pushed) rest_after(now_ns(), frame.busy_ns, t_ns + clock.period());
  }
  child.finish();
  return kExitClean;
}

}  // namespace
}  // namespace haptic

int main(int argc, char** argv) {
  return haptic::run_child(argc, argv, haptic::run);
}
