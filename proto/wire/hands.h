// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

/// The hands of a session, numbered from 0. Each has a device, a servo and a contact; what belongs
/// to one has the hand's number in its name: "servo0", "/contact0/set".
namespace haptic {

inline constexpr uint32_t kFirstHand = 0;
inline constexpr uint32_t kMostHands = 4;  // two people; a name has one digit

using HandName = std::array<char, 24>;  // zero-terminated
using HandNames = std::array<HandName, kMostHands>;

/// A name for each hand: `before`, its number, `after`. Names too long do not compile.
consteval HandNames names_of_hands(std::string_view before, std::string_view after = "") {
  HandNames names{};
  for (uint32_t hand = 0; hand < kMostHands; ++hand) {
    size_t n = 0;
    for (const char c : before) names[hand][n++] = c;
    names[hand][n++] = static_cast<char>('0' + hand);
    for (const char c : after) names[hand][n++] = c;
    names[hand].at(n) = '\0';
  }
  return names;
}

constexpr std::string_view view_of(const HandName& name) {
  size_t n = 0;
  while (n < name.size() && name[n] != '\0') ++n;
  return {name.data(), n};
}

inline constexpr HandNames kServoNames = names_of_hands("servo");
inline constexpr HandNames kContactNames = names_of_hands("contact");

/// Name of the servo or contact of a hand, for people and in logs.
constexpr const char* servo_name(uint32_t hand) {
  return kServoNames[hand].data();
}
constexpr const char* contact_name(uint32_t hand) {
  return kContactNames[hand].data();
}

}  // namespace haptic
