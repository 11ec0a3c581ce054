// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "contact/bake/session.h"

/// What a hand can reach of a session's objects.
namespace haptic {

/// Why the hand cannot touch the object: "the object 'part' lies 0.4 m beyond what the hand
/// reaches; how to mend". Empty if it may, and if the reach is not known (a recorded hand, a device
/// without a workspace). The reach is the ball of the intended strokes, or the workspace.
std::string out_of_reach(const SessionConfig& config, const BakedSession& baked, uint32_t object);
/// Whether there are objects, and all of them are out of reach.
bool nothing_in_reach(const SessionConfig& config, const BakedSession& baked);
/// A doubt about the size of a mesh [m], in words: "is 60 m long; was unit \"m\" meant as \"mm\"?".
/// Empty: nothing.
std::string size_doubt(const ShapeConfig& object, double size);
/// Objects out of reach and of doubtful size, one line each.
std::vector<std::string> scene_warnings(const SessionConfig& config, const BakedSession& baked);

}  // namespace haptic
