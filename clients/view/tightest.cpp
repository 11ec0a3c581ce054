// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/view/tightest.h"

#include <array>
#include <cmath>

#include "proto/os/json.h"
#include "proto/os/message.h"
#include "proto/os/regular_file.h"
#include "proto/os/text.h"

namespace haptic {
namespace {

constexpr size_t kMostBytes = size_t{256} << 20;  // some two million samples
constexpr double kUnitTolerance = 1e-6;           // of a quaternion's length, printed in full

template <size_t N>
std::array<double, N> numbers(const Json& list) {
  const auto values = list.get<std::array<double, N>>();
  for (const double value : values) {
    if (!std::isfinite(value)) throw std::invalid_argument("a number that is not finite");
  }
  return values;
}

Vec3 point(const Json& list) {
  const auto [x, y, z] = numbers<3>(list);
  return {x, y, z};
}

Pose pose(const Json& json) {
  const auto [w, x, y, z] = numbers<4>(json.at("orientation"));
  const Quat q{x, y, z, w};
  if (!(std::fabs(std::sqrt(dot(q, q)) - 1) < kUnitTolerance)) {
    throw std::invalid_argument("an orientation that is no unit quaternion");
  }
  return {point(json.at("position")), q};
}

}  // namespace

TightestPlace parse_tightest(std::string_view text, const std::string& file) {
  try {
    const Json all = Json::parse(text);
    const Json& one = all.at("objects").at(all.at("nearest").get<size_t>());
    TightestPlace place;
    place.object = one.at("index").get<uint32_t>();
    place.name = one.at("name").get<std::string>();
    place.tick = one.at("tick").get<uint64_t>();
    place.t = one.at("t_s").get<double>();
    place.distance = one.at("distance_m").get<double>();
    place.tool_point_W = point(one.at("tool_point_W"));
    place.object_point_W = point(one.at("object_point_W"));
    place.X_WT = pose(one.at("X_WT"));
    if (!(place.distance >= 0) || !std::isfinite(place.t + place.distance)) {
      throw std::invalid_argument("a distance below zero");
    }
    return place;
  } catch (const std::exception& error) {
    throw InputError(shown(file) + ": is not what `hapt clearance LOG --json` prints (" +
                     shown(error.what()) + "); write it anew");
  }
}

TightestPlace read_tightest(const std::string& path) {
  std::string text;
  const std::string problem = read_regular_file(path, kMostBytes, text);
  if (!problem.empty()) {
    throw InputError(shown(path) + ": " + problem +
                     "; name what `hapt clearance LOG --json` prints");
  }
  return parse_tightest(text, path);
}

std::string words_of(const TightestPlace& place) {
  const std::string where = "The tool is nearest to '" + shown(place.name) + "'";
  return where + (place.distance > 0
                      ? formatted(" at %.3f s: %.3g mm", place.t, 1e3 * place.distance)
                      : formatted(" at %.3f s: they meet", place.t));
}

}  // namespace haptic
