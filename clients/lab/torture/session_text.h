// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "proto/math/vec3.h"
#include "proto/wire/wire.h"

/// Pieces of the session file of hapt torture.
namespace haptic {

/// Clients that give, each of which moves an object far away from the hand. The last one is honest
/// and always there; the others come in turn, because a name takes a segment once a second.
inline constexpr uint32_t kGivers = 7, kBystander = kGivers - 1;
static_assert(kGivers < kMostClients);  // the one behind them moves the block, where it is given

/// A text with the words in braces replaced.
std::string filled(std::string text, const std::vector<std::pair<std::string, std::string>>& words);

std::string box(const std::string& name, const Vec3& extent, const Vec3& place);

/// Where the object of a client is: behind the block, out of the hand's reach.
Vec3 place_of_given(uint32_t client);
std::string name_of_given(uint32_t client);

/// The clients that give, and what they move.
std::string text_of_givers();
/// The client that moves the block, with no limits of its own.
std::string text_of_holder();

}  // namespace haptic
