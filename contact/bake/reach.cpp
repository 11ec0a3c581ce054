// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/bake/reach.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

#include "contact/query/point/closest_point.h"
#include "contact/shape/mesh/box.h"
#include "proto/config/devices.h"
#include "proto/wire/mapping.h"

namespace haptic {
namespace {

constexpr double kLeastSize = 0.5e-3, kMostSize = 10;  // [m]; beyond, the unit is doubtful

std::string rounded(double value) {
  if (value >= 10) return std::to_string(std::lround(value));
  std::ostringstream text;
  text.precision(2);
  text << value;
  return text.str();
}

std::string length_text(double metres) {
  return metres < 0.1 ? rounded(1e3 * metres) + " mm" : rounded(metres) + " m";
}

std::string quoted_millimetres(double metres) {
  return "\"" + std::to_string(std::lround(1e3 * metres)) + " mm\"";
}

/// Ball around the places that the tool's origin can come to.
struct Reach {
  Vec3 centre_W;
  double radius = std::numeric_limits<double>::infinity();  // [m]
};

/// Around the waypoints of a hand, in B.
Reach reach_along(const IntentConfig& intent) {
  Box box{intent.waypoints[0].X_BH.p, intent.waypoints[0].X_BH.p};
  for (uint32_t i = 1; i < intent.n_waypoints; ++i) box.add(intent.waypoints[i].X_BH.p);
  return {0.5 * (box.lower + box.upper), 0.5 * norm(box.size())};
}

Reach reach_of(const SessionConfig& config) {
  const DeviceConfig& device = config.device;
  const IntentConfig& intent = device.hand.intent;
  const bool is_simulated = row_of(device.kind).can_be_led;  // by an intention
  Reach reach;
  if (is_simulated) reach.radius = std::max(intent.hover_radius, intent.press_radius);
  const bool has_edge = !is_simulated && !row_of(device.kind).is_recorded;
  if (has_edge && device.workspace_radius > 0) reach.radius = device.workspace_radius;
  Vec3 centre_B = is_simulated ? intent.centre_B : device.workspace_centre_B;
  if (is_simulated && intent.n_waypoints > 0) {
    const Reach along_B = reach_along(intent);
    centre_B = along_B.centre_W;
    reach.radius = along_B.radius;
  }
  reach.radius *= config.map.motion_scale;
  reach.centre_W = tool_pose(config.map, {}, {centre_B, {}}).p;
  return reach;
}

/// From the tool's origin to its furthest point; of a point zero [m].
double tool_radius(const BakedSession& baked) {
  double longest = 0;
  if (!baked.tool) return 0;
  for (const Vec3& p_T : baked.tool->shape.mesh.vertices) longest = std::max(longest, norm(p_T));
  return longest;
}

std::string unit_doubt(const ShapeConfig& object, double size) {
  if (object.unit == 1 && size > 1) return "was unit \"m\" meant as \"mm\"?";
  if (object.unit > 0 && object.unit < 1 && size < 1e-3) return "was its unit meant as \"m\"?";
  return "";
}

/// Where the middle of the object is in the middle of the reach.
Vec3 position_in(const Reach& reach, const ObjectConfig& object, const TriangleMesh& mesh) {
  return reach.centre_W - rotate(object.X_WO.q, 0.5 * (mesh.lower + mesh.upper));
}

std::string advice(const Reach& reach, const ObjectConfig& object, const BakedShape& baked) {
  const std::string doubt = unit_doubt(object, baked.report.size);
  std::string mend;
  if (0.5 * baked.report.size < reach.radius) {
    const Vec3 p = position_in(reach, object, baked.shape.mesh);
    mend = "move it to position = [" + quoted_millimetres(p.x) + ", " + quoted_millimetres(p.y) +
           ", " + quoted_millimetres(p.z) + "]";
  } else {
    mend = "it is " + length_text(baked.report.size) + " long: make it smaller";
  }
  return doubt.empty() ? mend : mend + ", or " + doubt;
}

}  // namespace

std::string out_of_reach(const SessionConfig& config, const BakedSession& baked, uint32_t i) {
  const Reach reach = reach_of(config);
  const ObjectConfig& object = config.objects[i];
  if (std::isinf(reach.radius) || object.motion.kind == MotionKind::kSpin) return "";
  const ClosestPoint surface =
      closest_point(baked.objects[i].shape, inverse(object.X_WO) * reach.centre_W,
                    std::numeric_limits<double>::infinity());
  const double beyond =
      surface.distance - reach.radius - tool_radius(baked) - object.motion.amplitude;
  if (!surface.found || !(beyond > 0)) return "";
  return "the object '" + shown(view(object.name)) + "' lies " + length_text(beyond) +
         " beyond what the hand reaches; " + advice(reach, object, baked.objects[i]);
}

std::string size_doubt(const ShapeConfig& object, double size) {
  if (size >= kLeastSize && size <= kMostSize) return "";
  const std::string doubt = unit_doubt(object, size);
  return "is " + length_text(size) + " long; " + (doubt.empty() ? "check its unit" : doubt);
}

std::vector<std::string> scene_warnings(const SessionConfig& config, const BakedSession& baked) {
  std::vector<std::string> lines;
  for (uint32_t i = 0; i < config.n_objects; ++i) {
    const double size = baked.objects[i].report.size;
    if (std::string line = out_of_reach(config, baked, i); !line.empty()) {
      lines.push_back(std::move(line));
    } else if (std::string doubt = size_doubt(config.objects[i], size); !doubt.empty()) {
      lines.push_back("the object '" + shown(view(config.objects[i].name)) + "' " + doubt);
    }
  }
  return lines;
}

bool nothing_in_reach(const SessionConfig& config, const BakedSession& baked) {
  for (uint32_t i = 0; i < config.n_objects; ++i) {
    if (out_of_reach(config, baked, i).empty()) return false;
  }
  return config.n_objects > 0;
}

}  // namespace haptic
