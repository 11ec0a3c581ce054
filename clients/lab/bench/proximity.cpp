// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/support/measurement.h"

#include <algorithm>
#include <array>
#include <functional>
#include <memory>

#include "clients/lab/bench/peers/pair.h"
#include "clients/lab/bench/workloads/proximity.h"
#include "clients/lab/bench/workloads/turns.h"
#include "clients/lab/selftest/rt_guard.h"
#include "clients/lab/support/thread_cpu.h"
#include "contact/query/proximity/mesh_distance.h"
#include "contact/query/proximity/near_contacts.h"
#include "contact/query/proximity/near_front.h"
#include "proto/config/command_line.h"

namespace haptic {
namespace {

constexpr double kBand = 0.1e-3;        // [m]; distance of near pairs
constexpr size_t kChunk = 50;           // poses per turn of a contestant
constexpr size_t kMostPairs = 400'000;  // capacity of the query from scratch

struct Options {
  std::vector<std::string> cases{"torus", "bolt"};
  size_t torus_poses = 2000, bolt_poses = 120;
};

using Pairs = std::vector<TrianglePair>;

Pairs sorted(std::span<const NearPair> near) {
  Pairs pairs;
  for (const NearPair& pair : near) pairs.push_back(pair.triangles);
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

/// Wraps a query so that its CPU time is stored [s].
template <class Query>
std::function<void(size_t)> with_cpu(std::vector<double>& cpu, const Query& query) {
  return [&cpu, query](size_t i) { cpu.push_back(cpu_seconds_of([&] { query(i); })); };
}

/// Each of our queries compared with each peer; medians over chunks as ratios of wall-clock time.
void add_beside(Rows& rows, const Contestant& ours, const std::vector<Contestant>& peers) {
  for (const Contestant& peer : peers) {
    if (!peer.name.starts_with("FCL")) continue;
    rows.add_beside(ours.name + ", p50, beside", percentile(ours.times, 50), "s", peer.name,
                    percentile(peer.times, 50));
    rows.add(ours.name + " : " + peer.name, median_ratio(ours, peer));
  }
}

/// Number of allocations of a front that has already been along all poses.
double allocations(NearFront& front, NearContacts& contacts, const std::vector<Pose>& poses) {
  const auto follow = [&] {
    for (const Pose& X_OT : poses) contacts.reduce(front.update(X_OT, kBand), X_OT);
  };
  follow();
  return static_cast<double>(allocations_of(follow));
}

/// Differences at every pose: sets of pairs, and collision against FCL.
struct Agreement {
  double other_sets = 0, other_answers = 0, touching = 0;
  std::array<std::vector<double>, 6> counts;  // of kCounted
};
constexpr std::array kCounted{"near pairs",     "local minima",
                              "contacts kept",  "pairs of nodes looked at",
                              "boxes compared", "triangles measured"};

Agreement compare(const ProximityWork& work, PairPeer* peer) {
  const MeshShape object = work.object.view(), tool = work.tool.view();
  NearFront front(object, tool);
  NearContacts contacts(object, tool);
  std::vector<NearPair> cold(kMostPairs);
  Agreement found;
  // the first update builds the front and is not a step
  front.update(work.poses[0], kBand);
  for (const Pose& X_OT : work.poses) {
    const std::span<const NearPair> near = front.update(X_OT, kBand);
    const size_t n = near_pairs(object, tool, X_OT, kBand, cold);
    const Pairs set = sorted(near);
    found.other_sets += set != sorted(std::span(cold).first(std::min(n, cold.size())));
    const NearContactSet reduced = contacts.reduce(near, X_OT);
    const auto& work_done = front.work();
    const std::array<size_t, kCounted.size()> counts{
        near.size(),       reduced.minima,  reduced.contacts.size(),
        work_done.visited, work_done.boxes, work_done.triangles};
    for (size_t i = 0; i < counts.size(); ++i) {
      found.counts[i].push_back(static_cast<double>(counts[i]));
    }
    found.touching += reduced.meeting > 0;
    const bool any = any_near_pair(object, tool, X_OT, kBand);
    found.other_answers += any != (n > 0);
    if (peer == nullptr) continue;
    found.other_answers += any != (peer->distance(X_OT) <= kBand);
    found.other_answers += (reduced.meeting > 0) != peer->collides(X_OT);
  }
  return found;
}

void add_agreement(Rows& rows, const Agreement& found, double poses) {
  rows.add({{"poses at which they touch", found.touching / poses},
            {"sets that differ from those found from scratch", found.other_sets, "", kMustBeZero},
            {"yes or no that differs", found.other_answers, "", kMustBeZero}});
  for (size_t i = 0; i < kCounted.size(); ++i) {
    const std::string what = kCounted[i];
    rows.add({{what + ", p50", percentile(found.counts[i], 50)},
              {what + ", most", percentile(found.counts[i], 100)}});
  }
}

/// `goals`: p99 of the front alone, and of front and contacts together [s].
void bench_pairs(const ProximityWork& work, std::vector<std::optional<double>> goals,
                 const Rows& all) {
  Rows rows = all.of("proximity, " + work.name);
  const MeshShape object = work.object.view(), tool = work.tool.view();
  const auto peer = make_fcl_peer(object.mesh, tool.mesh);
  rows.add({{"triangles of the object", object.mesh.triangles.size()},
            {"triangles of the tool", tool.mesh.triangles.size()},
            {"poses of 1 kHz", work.poses.size()}});

  NearFront front(object, tool), reduced(object, tool);
  NearContacts contacts(object, tool);
  std::vector<NearPair> cold(kMostPairs);
  const auto& poses = work.poses;
  // the first pose builds the front, as before the start of a session
  for (NearFront* f : {&front, &reduced}) f->update(poses[0], kBand);
  std::array<std::vector<double>, 7> cpu;
  std::vector<Contestant> ours;
  const auto ask = [&](const std::string& name, const std::function<void(size_t)>& query) {
    ours.push_back({name, with_cpu(cpu[ours.size()], query)});
  };
  ask("front, all pairs", [&](size_t i) { front.update(poses[i], kBand); });
  ask("front, pairs and contacts",
      [&](size_t i) { contacts.reduce(reduced.update(poses[i], kBand), poses[i]); });
  ask("from scratch, all pairs",
      [&](size_t i) { near_pairs(object, tool, poses[i], kBand, cold); });
  ask("from scratch, whether any", [&](size_t i) { any_near_pair(object, tool, poses[i], kBand); });
  ask("from scratch, distance", [&](size_t i) { mesh_distance(object, tool, poses[i]); });
  if (peer) {
    ask("FCL, whether they meet", [&](size_t i) { peer->collides(poses[i]); });
    ask("FCL, distance", [&](size_t i) { peer->distance(poses[i]); });
  } else {
    rows.note("FCL", "not in this build");
  }
  take_turns(ours, poses.size(), kChunk, 1);
  goals.resize(ours.size());
  for (size_t k = 0; k < ours.size(); ++k)
    add_times(rows, ours[k].name + ", CPU", cpu[k], goals[k]);
  for (size_t k = 0; k < 5; ++k) add_beside(rows, ours[k], ours);
  rows.add("front : from scratch, all pairs", median_ratio(ours[0], ours[2]));

  add_agreement(rows, compare(work, peer.get()), static_cast<double>(poses.size()));
  rows.add({{"front, pairs of nodes", front.size()},
            {"allocations once along the path", allocations(reduced, contacts, poses), "",
             kMustBeZero}});
}

void all_rows(const Options& options, const Rows& all) {
  all.machine("proximity");
  const auto wants = [&](const std::string& name) {
    return std::find(options.cases.begin(), options.cases.end(), name) != options.cases.end();
  };
  if (wants("torus")) bench_pairs(torus_on_torus(options.torus_poses), {1e-4}, all);
  if (wants("bolt")) bench_pairs(bolt_through_nut(options.bolt_poses), {3e-3, 1e-3}, all);
}

}  // namespace

/// All pairs of triangles within 0.1 mm, from scratch and with a bounding-volume-tree front kept
/// from pose to pose, and their reduction to contacts, compared with FCL's collision and distance
/// (W3).
Measured bench_proximity(Command& command) {
  const auto options = std::make_shared<Options>();
  command.option("--case CASE", options->cases, "torus or bolt; several may be given")
      .one_of({"torus", "bolt"});
  add_counts(command, {{"--torus-poses", &options->torus_poses, "of 1 kHz", 2, 100000},
                       {"--bolt-poses", &options->bolt_poses, "of 1 kHz", 2, 100000}});
  return measured(all_rows, options);
}

}  // namespace haptic
