// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "clients/lockstep/lockstep.h"
#include "clients/report/report.h"
#include "contact/bake/session.h"
#include "proto/config/config.h"

namespace haptic {

/// One hand through several renderers side by side.
struct CompareEval {
  std::vector<std::string> columns;  // renderer, or renderer/solver: "voxel/penalty-dynamics"
  SessionConfig config;              // the scene, with the hand
  std::string config_text;           // for the file
  std::string output;                // .mcap; empty: none
  LockstepOptions lockstep;
  double seconds = 20;  // of a hand that is not recorded
};

/// The measures of one column; lengths in m, forces in N at the device unless said otherwise.
struct CompareFigures {
  std::string name;
  bool is_massless = true;   // the proxy has no mass, or there is none
  size_t free_ticks = 0;     // the ball around the tool is farther from each object than its layer
  double free_force = 0;     // largest coupling force on the hand in them [N, scene]
  double depth_max = 0;      // deepest vertex of the tool at the proxy inside a closed object, over
  double depth_mean = 0;     // at most 500 ticks in contact; mean of those depths
  double force_step = 0;     // largest change of the force in a millisecond [N/ms]
  double returned = 0;       // energy given to the hand [J]
  double contact_force = 0;  // mean |F| of the ticks in contact
  double share = 0;          // of the ticks in contact
  ServoFrame last{};         // the last tick
};

/// The session that a column plays. Throws ConfigError if there is no such renderer or solver, or
/// if the session lacks what it needs.
SessionConfig config_of_column(const SessionConfig& config, const std::string& column);

/// The place of a column in the taxonomy of renderers (Otaduy & Lin): direct or by a virtual
/// coupling, by penalty or by constraint.
std::string way_of_column(const SessionConfig& config);

/// Plays the hand through all columns in lockstep, tick by tick. With an output it writes one file
/// with the topics /COLUMN/servo/frame, /COLUMN/contact/set, /COLUMN/sim/frame and a metadata
/// record `comparison`. Time is virtual and no clock is read: the same call writes the same bytes.
std::vector<CompareFigures> compare_renderers(const CompareEval& eval);

void add_rows(const std::vector<CompareFigures>& figures, const CompareEval& eval, const Rows& all);
/// One line for each column, and what the two words of its way mean.
void print_comparison(std::ostream& out, const std::vector<CompareFigures>& figures,
                      const CompareEval& eval);

}  // namespace haptic
