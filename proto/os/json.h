// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace haptic {

/// A value whose keys keep their order.
using Json = nlohmann::ordered_json;

/// As short as it can be, for other programs; what is no number is null, and bytes that are not
/// UTF-8 are replaced.
std::string json_compact(const Json& json);

/// In one line, as `{"a": 1, "b": [2, null]}`. Numbers have as many digits as they need; those that
/// are not finite are null, and bytes that are not UTF-8 are replaced.
std::string json_line(const Json& json);

/// An array with a line for each of its elements.
std::string json_lines(const Json& array);

}  // namespace haptic
