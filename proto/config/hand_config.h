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

/// Two hands that may be on one device, and how to tell the devices apart; empty: there are none.
/// The settings of each hand by its number.
std::string shared_device(std::span<const SessionConfig> hands);

}  // namespace haptic
