// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "proto/config/session_config.h"

/// The hands of a session, as its file names them.
namespace haptic {

/// How people name a hand: its name in the session file, or its number where it has none.
std::string name_of_hand(const SessionConfig& config, uint32_t hand);

/// The number of the hand with that name or number; empty: the session has none.
std::optional<uint32_t> hand_named(const SessionConfig& config, std::string_view name);

/// The names of all hands, as "left, right".
std::string names_of_all_hands(const SessionConfig& config);

/// The session as a hand has it, with the tools of the others behind the objects of the scene, in
/// the order of the hands: each has its own shape, that of a point is a ball. As it is where the
/// session has one hand, or hands_touch is off.
SessionConfig with_tools(std::span<const SessionConfig> hands, uint32_t hand);

/// Why the scene has no room for the tools; empty: it has.
std::string too_many_tools(const SessionConfig& config);

/// Radius of a point, as it is drawn and as others touch it [m].
inline constexpr double kPointRadius = 1e-3;

/// Two hands that may be on one device, and how to tell the devices apart; empty: there are none.
/// The settings of each hand by its number.
std::string shared_device(std::span<const SessionConfig> hands);

}  // namespace haptic
