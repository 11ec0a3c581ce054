// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "clients/view/view.h"

/// The binary frame of docs/view-protocol.md. One table says where each number is and how it is
/// computed; /layout.json is written from the same table.
namespace haptic {

inline constexpr uint64_t kMostSamples = 256;  // of one frame

/// The text of /layout.json.
std::string layout_json();

/// Makes the numbers that a frame has in common for all viewers: the fixed part, the objects and
/// the contacts. The numbers of one viewer are zero.
std::vector<double> common_frame(const View& view);

/// The numbers of one viewer.
struct FrameOf {
  uint64_t sequence = 0;                      // of the frame, for this viewer
  uint64_t column = 0;                        // of a comparison
  uint64_t unseen = 0;                        // ticks passed over since its last frame
  uint64_t first_sample = 0, end_sample = 0;  // numbers in View::samples
};

/// The bytes of a viewer's frame.
std::string frame_bytes(const std::vector<double>& common, const View& view, const FrameOf& of);

/// The samples that a viewer is sent who has had those before `seen`: at most kMostSamples, the
/// newest.
FrameOf samples_since(const Samples& samples, uint64_t seen);

}  // namespace haptic
