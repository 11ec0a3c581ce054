// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "clients/lab/torture/session.h"

namespace haptic {

/// Compares the servo's frames, as seen by a client that missed none, with the recorded files; also
/// the losses of any ring that the recorders reported themselves.
struct SampleAccount {
  uint64_t published = 0;               // frames of the servo since the first recorded one
  uint64_t recorded = 0;                // of them
  uint64_t explained = 0;               // no recorder ran, or it was killed with an open chunk of a
                                        // quarter of a second (longer if it was stalled)
  uint64_t unexplained = 0;             // not in the file of the recorder that was running
  uint64_t told = 0;                    // records of any ring reported lost by a recorder
  std::vector<std::string> unreadable;  // files, and why
};

/// Reads the recordings; the recorders must have ended. `published`: the servo's frames in order.
/// A frame counts from when it was seen, not from its tick: a stalled servo may publish it long
/// after the recorder was told to end. `parts` are in order of time.
SampleAccount account_for_samples(const std::vector<RecordingPart>& parts,
                                  const std::vector<SeenFrame>& published);

}  // namespace haptic
