// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "proto/log/mcap.h"
#include "proto/wire/hands.h"

/// The meshes that draw a scene, in its recording: an eye file (proto/ipc/eye_file.h) of the tool
/// and of each object, as attachments of the names eye/tool (of other hands eye/tool1, …), eye/0,
/// eye/1 …
namespace haptic {

inline constexpr std::string_view kEyeMediaType = "application/x-haptic-eye";

/// Name of the attachment of an object, by its index in the session file, or of a hand's tool.
std::string eye_attachment(uint32_t object);

/// Bytes of eye files, not checked.
struct LogEyes {
  std::array<std::vector<std::byte>, kMostHands> tools;  // empty: none
  std::map<uint32_t, std::vector<std::byte>> objects;    // by index in the session file
  std::string problem;                                   // the last one that cannot be read: why
};

/// Reads the eye files of a recording, of several of one name the newest. A damaged one is left
/// out.
LogEyes read_log_eyes(const McapReader& file);

}  // namespace haptic
