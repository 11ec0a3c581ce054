// SPDX-License-Identifier: Apache-2.0
#include "clients/log/log_eyes.h"

#include <algorithm>
#include <optional>

#include "proto/ipc/eye_file.h"
#include "proto/os/text.h"
#include "proto/wire/wire.h"

namespace haptic {
namespace {

constexpr std::string_view kPrefix = "eye/";

/// The number of an object or a tool.
std::optional<uint32_t> object_of(std::string_view name) {
  for (uint32_t hand = 0; hand < kMostHands; ++hand) {
    if (name == eye_attachment(eye_of_tool(hand))) return eye_of_tool(hand);
  }
  if (!name.starts_with(kPrefix)) return std::nullopt;
  const auto object = number_from<uint32_t>(name.substr(kPrefix.size()));
  return object && *object < kMaxObjects ? object : std::nullopt;
}

}  // namespace

std::string eye_attachment(uint32_t object) {
  const std::string prefix(kPrefix);
  if (!is_eye_of_tool(object)) return prefix + std::to_string(object);
  const uint32_t hand = kEyeOfTool - object;
  return prefix + "tool" + (hand == kFirstHand ? "" : std::to_string(hand));
}

LogEyes read_log_eyes(const McapReader& file) {
  LogEyes eyes;
  // the newest of each name only: the others need not be read
  std::map<std::string_view, const McapAttachment*> newest;
  for (const McapAttachment& attachment : file.attachments()) {
    if (attachment.media_type == kEyeMediaType) newest[attachment.name] = &attachment;
  }
  for (const auto& [name, attachment] : newest) {
    const std::optional<uint32_t> object = object_of(name);
    if (!object) continue;
    const bool is_tool = is_eye_of_tool(*object);
    try {
      (is_tool ? eyes.tools[kEyeOfTool - *object] : eyes.objects[*object]) =
          file.read_attachment(*attachment);
    } catch (const McapError& error) {
      if (!is_tool) eyes.objects.erase(*object);
      eyes.problem = error.what();
    }
  }
  return eyes;
}

}  // namespace haptic
