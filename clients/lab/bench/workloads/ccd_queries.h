// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "contact/query/sweep/swept_pair.h"

namespace haptic {

/// The question if two features with linearly moving corners meet: vertex and face, or two edges.
struct CcdQuery {
  std::array<SweptPoint, 4> corners;
  bool is_face = false;  // false: two edges
  bool meets = false;    // ground truth, if known
};

/// Queries of one kind from one scene, as stored in a folder.
struct CcdFile {
  std::string scene;  // with its kind: "erleben-spikes edge-edge"
  std::vector<CcdQuery> queries;
};

/// Ground truth of Wang, Ferguson, Schneider, Jiang, Attene & Panozzo 2021:
/// <scene>/vertex-face/*.csv and <scene>/edge-edge/*.csv, eight rows per query: three coordinates
/// as numerator and denominator and the exact truth, for four corners at time 0, then at 1. Empty
/// if the folder does not exist; throws std::runtime_error for rows in another form.
std::vector<CcdFile> read_ccd_queries(const std::string& folder);

/// Queries at the scale of a hand: features of 0.2 to 2 mm, a few tenths of a millimetre apart, one
/// of which moves by 0.05 to 2 mm and turns a little. Ground truth is unknown.
std::vector<CcdQuery> hand_scale_queries(size_t n);

/// The answer of the queries that contact uses.
std::optional<SweptMeeting> meeting_of(const CcdQuery& query, double tolerance);

}  // namespace haptic
