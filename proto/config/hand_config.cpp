// SPDX-License-Identifier: Apache-2.0
#include "proto/config/hand_config.h"

#include <algorithm>

#include "proto/config/devices.h"
#include "proto/math/assert.h"
#include "proto/os/message.h"
#include "proto/os/text.h"
#include "proto/wire/other_tools.h"
#include "proto/wire/renderer.h"

namespace haptic {
namespace {

/// True if both may find the same device: a serial node by its path, one that is plugged in by
/// what is said of it.
bool may_be_one(const DeviceConfig& a, const DeviceConfig& b) {
  if (row_of(a.kind).node == NodeKind::kSerial) {
    return row_of(b.kind).node == NodeKind::kSerial && a.serial.path == b.serial.path;
  }
  if (a.kind != b.kind || !row_of(a.kind).has_node()) return false;
  const auto differ = [](const Name& x, const Name& y) {
    return !view(x).empty() && !view(y).empty() && x != y;
  };
  return !differ(a.plugged.serial, b.plugged.serial) && !differ(a.plugged.port, b.plugged.port);
}

std::string how_to_tell_apart(const DeviceConfig& device) {
  return row_of(device.kind).node == NodeKind::kSerial
             ? "give each its own path in [hand.device.serial]"
             : "give each its serial or its port in [hand.device.usb] (hapt devices lists them)";
}

}  // namespace

std::string name_of_hand(const SessionConfig& config, uint32_t hand) {
  const std::string_view name = view(config.hand_names.at(hand));
  return name.empty() ? std::to_string(hand) : std::string(name);
}

std::optional<uint32_t> hand_named(const SessionConfig& config, std::string_view name) {
  for (uint32_t hand = 0; hand < config.n_hands; ++hand) {
    if (name == name_of_hand(config, hand)) return hand;
  }
  const auto number = number_from<uint32_t>(name);
  return number && *number < config.n_hands ? number : std::nullopt;
}

std::string names_of_all_hands(const SessionConfig& config) {
  std::string names;
  for (uint32_t hand = 0; hand < config.n_hands; ++hand) {
    names += (hand > 0 ? ", " : "") + name_of_hand(config, hand);
  }
  return names;
}

SessionConfig with_tools(std::span<const SessionConfig> hands, uint32_t hand) {
  HAPTIC_ASSERT(hand < hands.size());
  SessionConfig config = hands[hand];
  if (config.hands_touch == 0) return config;
  for (const SessionConfig& other : hands) {
    if (other.hand == hand || config.n_objects == kMaxObjects) continue;
    ObjectConfig& tool = config.objects[config.n_objects++];
    tool = {};
    static_cast<ShapeConfig&>(tool) = other.tool;
    if (!is_of_body(other.renderer) || !has_mesh(other.tool)) {
      const bool is_sphere = row_of(other.renderer).moves == Moves::kSphere;
      const double radius = is_sphere ? std::max(other.proxy_radius, kPointRadius) : kPointRadius;
      tool.primitive = primitive::Sphere{.diameter = 2 * radius, .subdivisions = 4};
      tool.mesh = {};
    }
    assign(tool.name, "tool of " + name_of_hand(config, other.hand));
    // far from any hand until its servo has said where it is
    tool.X_WO.p = kNowhere;
    ++config.n_tools;
  }
  return config;
}

std::string too_many_tools(const SessionConfig& config) {
  const uint32_t room = kMaxObjects - (config.n_hands - 1);
  if (config.hands_touch == 0 || config.n_objects <= room) return {};
  return "has one [[object]] too many beside the tools of its hands; " + std::to_string(room) +
         " is the most, join some meshes or write hands_touch = false in [session]";
}

std::string shared_device(std::span<const SessionConfig> hands) {
  for (size_t b = 1; b < hands.size(); ++b) {
    for (size_t a = 0; a < b; ++a) {
      if (!may_be_one(hands[a].device, hands[b].device)) continue;
      const auto name = [&](size_t k) {
        return "'" + shown(name_of_hand(hands[k], static_cast<uint32_t>(k))) + "'";
      };
      return "hands " + name(a) + " and " + name(b) + " may be on the same device; " +
             how_to_tell_apart(hands[b].device);
    }
  }
  return {};
}

}  // namespace haptic
