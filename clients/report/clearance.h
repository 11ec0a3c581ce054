// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "contact/bake/session.h"
#include "proto/config/config.h"

namespace haptic {

/// The least distance of the tool to one object over a recorded path, and where.
struct Tightest {
  uint32_t object = 0;
  uint64_t tick = 0;                      // of the recording, as `hapt view` counts (LogIndex)
  double t = 0;                           // since the first servo frame [s]
  double distance = 0;                    // [m]; 0 where they meet or one is inside of the other
  Vec3 tool_point_W{}, object_point_W{};  // nearest to each other; where they meet of no meaning
  Pose X_WT{}, X_WO{};
};

struct ClearanceSample {
  uint64_t tick = 0;
  double t = 0;                   // [s]
  std::vector<double> distances;  // to each object of Clearance::tightest [m]
};

/// How near a tool has come to the objects.
struct Clearance {
  std::vector<ClearanceSample> samples;  // in order of time
  std::vector<Tightest> tightest;        // of each object that was asked for
  size_t proven = 0;                     // samples of poses that contact has proven free

  /// The object to which the tool came nearest: index in `tightest`.
  size_t nearest() const;
};

struct ClearanceOptions {
  double every = 0;    // between two poses that are measured [s]; 0: every recorded one
  std::string object;  // the only one to be measured; empty: all
  std::function<void(double share)> told = [](double) {};
};

/// The session file inside a recording. Throws McapError, or InputError where there is none.
SessionConfig carried_session(const std::string& log);

/// Bakes or maps the surfaces of a session, and nothing else that its renderer would need. Throws
/// MeshError.
BakedSession bake_surfaces(SessionConfig config);

/// Exact distances (mesh_distance) of the tool and each object at the recorded poses. Of a tool
/// that never enters an object the pose is X_WG with the X_WO of the same contact set, proven free
/// of the objects there: X_WP of the servo lies on planes that are a tick old, and so would report
/// the error of the planes as a clearance or a collision. Of a tool that may enter, which has no
/// verified pose, it is X_WP, with the objects where the servo had them (object_pose_at). Throws
/// McapError, or InputError: no such object, no such pose.
Clearance measure_clearance(const std::string& log, const SessionConfig& config,
                            const BakedSession& baked, const ClearanceOptions& options);

}  // namespace haptic
