// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/torture/session_text.h"

#include "proto/config/quantity.h"

namespace haptic {
namespace {

constexpr const char* kBox = R"(
[[object]]
name = "{name}"
primitive = "box"
extent = {extent}
position = {place}
)";
constexpr const char* kClient = R"(
[[client]]
name = "{name}"
may = ["move {name}", "push", "touch"]
)";

// the limits of safety alone are looked for
constexpr const char* kStrong = R"(max_force = "10 N"
max_power = "10 W"
)";

}  // namespace

std::string filled(std::string text,
                   const std::vector<std::pair<std::string, std::string>>& words) {
  for (const auto& [name, value] : words) {
    const std::string place = "{" + name + "}";
    for (size_t at = 0; (at = text.find(place, at)) != std::string::npos; at += value.size()) {
      text.replace(at, place.size(), value);
    }
  }
  return text;
}

std::string box(const std::string& name, const Vec3& extent, const Vec3& place) {
  const auto lengths = [](const Vec3& v) {
    return "[\"" + number_text(v.x) + " m\", \"" + number_text(v.y) + " m\", \"" +
           number_text(v.z) + " m\"]";
  };
  return filled(kBox, {{"name", name}, {"extent", lengths(extent)}, {"place", lengths(place)}});
}

Vec3 place_of_given(uint32_t client) {
  return {0.6, 0.1 * client, 0.3};
}
std::string name_of_given(uint32_t client) {
  return "given " + std::to_string(client);
}

std::string text_of_givers() {
  std::string text;
  for (uint32_t client = 0; client < kGivers; ++client) {
    text += box(name_of_given(client), {0.02, 0.02, 0.02}, place_of_given(client));
  }
  for (uint32_t client = 0; client < kGivers; ++client) {
    text += filled(kClient, {{"name", name_of_given(client)}});
  }
  return text;
}

std::string text_of_holder() {
  return filled(kClient, {{"name", "block"}}) + kStrong;
}

}  // namespace haptic
