// SPDX-License-Identifier: Apache-2.0
#include "proto/config/config_names.h"

namespace haptic {

std::string session_name_problem(std::string_view name) {
  constexpr size_t kLongest = 32;
  constexpr std::string_view kAllowed =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-";
  const bool good = !name.empty() && name.size() <= kLongest &&
                    name.find_first_not_of(kAllowed) == std::string_view::npos;
  if (good) return {};
  return "cannot be the name of a session; use 1 to " + std::to_string(kLongest) +
         " letters, digits, '-' and '_'";
}

}  // namespace haptic
