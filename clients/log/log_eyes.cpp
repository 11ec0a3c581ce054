// SPDX-License-Identifier: Apache-2.0
#include "clients/log/log_eyes.h"

#include <algorithm>
#include <optional>

#include "proto/os/text.h"
#include "proto/wire/wire.h"

namespace haptic {
namespace {

constexpr std::string_view kPrefix = "eye/";

std::optional<uint32_t> object_of(std::string_view name) {
  if (!name.starts_with(kPrefix)) return std::nullopt;
  const auto object = number_from<uint32_t>(name.substr(kPrefix.size()));
  return object && *object < kMaxObjects ? object : std::nullopt;
}

}  // namespace

std::string eye_attachment(uint32_t object) {
  return object < kMaxObjects ? std::string(kPrefix) + std::to_string(object)
                              : std::string(kToolEyeAttachment);
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
    if (!object && name != kToolEyeAttachment) continue;
    try {
      (object ? eyes.objects[*object] : eyes.tool) = file.read_attachment(*attachment);
    } catch (const McapError& error) {
      if (object) eyes.objects.erase(*object);
      eyes.problem = error.what();
    }
  }
  return eyes;
}

}  // namespace haptic
