// SPDX-License-Identifier: Apache-2.0
#include "proto/os/json.h"

#include <charconv>
#include <cmath>

namespace haptic {
namespace {

// the library's own text of 500.0 is "500.0", and its lines have no blanks
std::string json_leaf(const Json& json) {
  if (json.is_number_float() && std::isfinite(json.get<double>())) {
    char text[32];  // the longest double has 24 characters
    return {text, std::to_chars(text, text + sizeof text, json.get<double>()).ptr};
  }
  return json_compact(json);
}

}  // namespace

std::string json_compact(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::string json_line(const Json& json) {
  if (!json.is_structured()) return json_leaf(json);
  std::string text;
  for (const auto& [key, value] : json.items()) {
    if (!text.empty()) text += ", ";
    if (json.is_object()) text += json_leaf(key) + ": ";
    text += json_line(value);
  }
  return json.is_object() ? "{" + text + "}" : "[" + text + "]";
}

std::string json_lines(const Json& array) {
  std::string text;
  for (const Json& one : array) text += (text.empty() ? "\n  " : ",\n  ") + json_line(one);
  return "[" + text + "\n]\n";
}

}  // namespace haptic
