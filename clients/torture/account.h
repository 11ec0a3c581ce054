// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "clients/torture/session.h"

namespace haptic {

/// Where the servo's frames have gone, by the account of a client that saw each of them, compared
/// with the files; and what the recorders themselves say they lost, of whatever ring.
struct SampleAccount {
  uint64_t published = 0;    // frames of the servo since the first recorded one
  uint64_t recorded = 0;     // of them
  uint64_t explained = 0;    // no recorder ran, or one was killed with its open quarter second,
                             // which is longer where it had no time meanwhile
  uint64_t unexplained = 0;  // not in the file of the recorder whose time it was
  uint64_t told = 0;         // records of any ring that a recorder counted as lost
  std::vector<std::string> unreadable;  // files, and why
};

/// Reads the recordings; the recorders must have ended. `published`: the servo's frames in order.
/// A frame counts from when it was seen, not from the tick it was due at: a servo that was held up
/// may publish it long after the recorder was told to end. Parts in order of time.
SampleAccount account_for_samples(const std::vector<RecordingPart>& parts,
                                  const std::vector<SeenFrame>& published);

}  // namespace haptic
