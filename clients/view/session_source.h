// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <string>

#include "clients/view/frame_source.h"

namespace haptic {

/// The name of a running session; empty: the only one. Throws HandoutError.
std::string name_of_session(const std::string& session);

/// A running session as a source of frames. It connects on a thread of its own, again and again
/// when hapticd has ended. Rings are mapped read-only.
FrameSource session_source(const std::string& session);

}  // namespace haptic
