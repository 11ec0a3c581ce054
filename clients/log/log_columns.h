// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "proto/log/trace.h"

namespace haptic {

/// Name of the one column of a recorded session.
inline constexpr std::string_view kSessionColumn = "session";

/// One run in a recording: a session has one for each hand, a comparison one for each renderer.
struct LogColumn {
  std::string name;                 // "session", "god-object6", "voxel/quasi-static"
  std::string servo, contact, sim;  // its topics
};

/// The column of a comparison, whose topics are /NAME/servo/frame, /NAME/contact/set and
/// /NAME/sim/frame.
LogColumn column_of_comparison(const std::string& name);

/// The columns of a file: those that its metadata record `comparison` lists in its entry `columns`,
/// divided by commas, as far as their topics are there; without such a record the session's. Empty
/// if the file has no servo frames.
std::vector<LogColumn> log_columns(const TraceReader& trace);

}  // namespace haptic
