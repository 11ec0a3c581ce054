// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "clients/report/report.h"
#include "contact/bake/session.h"
#include "proto/config/config.h"
#include "proto/wire/behind.h"
#include "proto/wire/packing.h"
#include "proto/wire/wire.h"

namespace haptic {

/// The part of a ContactSet that is kept: without the contacts it is a tenth of the size.
struct VerifiedProxy {
  int64_t answers_t_ns = 0;
  Pose X_WG;
  std::vector<Pose> X_WO;
  int64_t busy_ns = 0;
  uint32_t flags = 0, renderer = 0;
};
VerifiedProxy verified_proxy(const ContactSet& set);

/// The data of a recording that are evaluated.
struct SessionData {
  PackedRecords<ServoFrame> frames;
  std::vector<VerifiedProxy> proxies;
  PackedRecords<SceneFrame> scenes;
  uint64_t recorded = 0;  // samples of all three topics
  uint64_t lost = 0;      // samples published but not recorded
};

/// Reads the servo, contact and sim topics of a recording. Throws McapError.
SessionData load_session(const std::string& log);

/// Work of force and torque through the port between hand and device, in device units: F_k, held
/// from tick k to k+1, is paired with the displacement and the turn over that same step; any other
/// pairing hides the energy leak of the zero-order hold (Hannaford & Ryu 2002).
struct PortEnergy {
  double into_device = 0;                                // the hand moved against the force [J]
  double returned = 0;                                   // the force moved the hand [J]
  double net() const { return into_device - returned; }  // ≥ 0: passive
};
PortEnergy port_energy(const PackedRecords<ServoFrame>& frames);

/// How deep the proxies were inside objects.
struct Penetration {
  size_t verified_inside = 0;  // sets whose verified proxy is strictly inside; must be 0
  size_t verified_checked = 0;
  std::string unchecked;  // why the verified proxy was not checked; empty if it was
  // rigid tools: poses not reached along a path, those of them with an object in between, and sets
  // without a free pose, for which no force was rendered
  size_t placed_anew = 0, across = 0, without_pose = 0;
  double deepest_proxy = 0;  // of the servo's proxy X_WP; contacts lag behind it [m]
};

/// Exact check of every verified proxy of a point (CGAL predicates) and depth of every tick's
/// proxy. With a tool of six degrees of freedom about 2,000 verified poses are checked, if its
/// renderer is rigid, and the depth of about 1,000 of its vertices at about 200 instants.
Penetration measure_penetration(const SessionData& data, const SessionConfig& config,
                                const BakedSession& baked);

/// True if the tick has a contact whose force the hand can feel; weaker ones count as free space.
bool is_touching(const ServoFrame& frame);

/// Metrics that others look for among the rows.
inline constexpr std::string_view kContactShare = "share of ticks in contact";  // [%]
inline constexpr std::string_view kFirstTouch = "time of the first touch";      // since the start
inline constexpr std::string_view kGone = "scene";  // a note, where bodies are out of reach

/// The figures of a session as rows of case `name`: ticks, late ticks, lateness, busy times, rates,
/// force, depth, energy and samples, with the goals of a successful session.
std::vector<Row> summarize(const std::string& name, const SessionData& data,
                           const SessionConfig& config, const Penetration& penetration);

}  // namespace haptic
