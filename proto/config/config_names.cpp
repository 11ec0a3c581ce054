// SPDX-License-Identifier: Apache-2.0
#include "proto/config/config_names.h"

namespace haptic {

namespace {

constexpr size_t kLongestName = 32;
constexpr std::string_view kDigits = "0123456789";
constexpr std::string_view kAllowed =
    "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-";

bool is_plain(std::string_view name) {
  return !name.empty() && name.size() <= kLongestName &&
         name.find_first_not_of(kAllowed) == std::string_view::npos;
}

std::string name_problem_of(const char* whose) {
  return std::string("cannot be the name of a ") + whose + "; use 1 to " +
         std::to_string(kLongestName) + " letters, digits, '-' and '_'";
}

}  // namespace

std::string session_name_problem(std::string_view name) {
  return is_plain(name) ? "" : name_problem_of("session");
}

std::string hand_name_problem(std::string_view name) {
  // "0" is the first hand, and "all" are all of them
  const bool is_taken = name == "all" || name.find_first_not_of(kDigits) == std::string_view::npos;
  if (!is_plain(name) || is_taken)
    return name_problem_of("hand") + ", not digits alone and not 'all'";
  return {};
}

}  // namespace haptic
