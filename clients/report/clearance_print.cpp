// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/report/clearance_print.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "clients/report/plot_svg.h"
#include "clients/report/report.h"
#include "proto/os/json.h"
#include "proto/os/message.h"
#include "proto/os/text.h"

namespace haptic {
namespace {

constexpr size_t kSpans = 10;      // rows over the path
constexpr size_t kNameWidth = 24;  // of an object in the table [characters]
constexpr double kNearPanel = 4;   // the second panel ends at this many of the least distances
constexpr double kLeastNearPanel = 1e-3;  // [m]; a hundred margins of a contact are no clearance

std::string name_of(const SessionConfig& config, uint32_t object) {
  return shown(view(config.objects[object].name));
}

std::string distance_text(double distance) {
  return distance > 0 ? readable(distance, "m") : "meets";
}

std::string place(const Vec3& p) {
  return formatted("(%.1f, %.1f, %.1f)", 1e3 * p.x, 1e3 * p.y, 1e3 * p.z);
}

Json json_of(const Vec3& p) {
  return {p.x, p.y, p.z};
}

Json json_of(const Pose& X) {
  return {{"position", json_of(X.p)}, {"orientation", {X.q.w, X.q.x, X.q.y, X.q.z}}};
}

/// The least distance in each tenth of the time, and to which object.
void print_spans(std::ostream& out, const SessionConfig& config, const Clearance& clearance) {
  const double begin = clearance.samples.front().t;
  const double length = (clearance.samples.back().t - begin) / kSpans;
  auto next = clearance.samples.begin();
  for (size_t span = 0; span < kSpans; ++span) {
    const double end = begin + static_cast<double>(span + 1) * length;
    double least = std::numeric_limits<double>::infinity();
    uint32_t object = 0;
    while (next != clearance.samples.end() && (next->t <= end || span + 1 == kSpans)) {
      for (size_t k = 0; k < next->distances.size(); ++k) {
        if (!(next->distances[k] < least)) continue;
        least = next->distances[k];
        object = clearance.tightest[k].object;
      }
      ++next;
    }
    if (least == std::numeric_limits<double>::infinity()) continue;
    out << padded(formatted("  %.2f s to %.2f s", end - length, end), kNameWidth + 2)
        << padded(distance_text(least), 12) << name_of(config, object) << '\n';
  }
}

}  // namespace

void print_clearance(std::ostream& out, const std::string& log, const SessionConfig& config,
                     const Clearance& clearance) {
  const size_t n = clearance.samples.size();
  out << shown(log) << ": " << n << " poses of the tool over "
      << readable(clearance.samples.back().t - clearance.samples.front().t, "s") << ", ";
  if (clearance.proven == n) {
    out << "each proven free by contact\n";
  } else {
    out << "of its proxy, which may enter objects\n";
  }
  out << padded("  object", kNameWidth + 2) << padded("least", 12) << padded("at", 12)
      << "there, in W [mm]\n";
  for (const Tightest& one : clearance.tightest) {
    out << padded("  " + name_of(config, one.object), kNameWidth + 2)
        << padded(distance_text(one.distance), 12) << padded(formatted("%.3f s", one.t), 12)
        << place(one.object_point_W) << '\n';
  }
  out << "  over the path, the least and to which object\n";
  print_spans(out, config, clearance);
}

void print_clearance_json(std::ostream& out, const std::string& log, const SessionConfig& config,
                          const Clearance& clearance) {
  Json objects = Json::array();
  for (const Tightest& one : clearance.tightest) {
    objects.push_back({{"name", view(config.objects[one.object].name)},
                       {"index", one.object},
                       {"distance_m", one.distance},
                       {"meets", !(one.distance > 0)},
                       {"tick", one.tick},
                       {"t_s", one.t},
                       {"tool_point_W", json_of(one.tool_point_W)},
                       {"object_point_W", json_of(one.object_point_W)},
                       {"X_WT", json_of(one.X_WT)},
                       {"X_WO", json_of(one.X_WO)}});
  }
  std::string all = json_line({{"log", log},
                               {"poses", clearance.samples.size()},
                               {"proven", clearance.proven},
                               {"objects", objects},
                               {"nearest", clearance.nearest()}});
  // an hour has millions of samples: they are written one by one
  all.pop_back();
  out << all << ", \"samples\": [";
  const char* separator = "\n";
  for (const ClearanceSample& sample : clearance.samples) {
    out << std::exchange(separator, ",\n")
        << json_line({{"tick", sample.tick}, {"t_s", sample.t}, {"distance_m", sample.distances}});
  }
  out << "]}\n";
}

void plot_clearance(const std::string& path, const std::string& log, const SessionConfig& config,
                    const Clearance& clearance) {
  std::vector<double> t;
  for (const ClearanceSample& sample : clearance.samples) t.push_back(sample.t);
  Panel all{"distance", "mm", {}, {}}, near{"distance where it is small", "mm", {}, {}};
  double end = kLeastNearPanel;
  for (const Tightest& one : clearance.tightest) end = std::max(end, kNearPanel * one.distance);
  for (size_t k = 0; k < clearance.tightest.size(); ++k) {
    const Tightest& one = clearance.tightest[k];
    const std::string name = name_of(config, one.object);
    Series whole{name, t, {}}, part{name, t, {}};
    for (const ClearanceSample& sample : clearance.samples) {
      const double d = sample.distances[k];
      whole.y.push_back(1e3 * d);
      part.y.push_back(d <= end ? 1e3 * d : std::numeric_limits<double>::quiet_NaN());
    }
    all.series.push_back(std::move(whole));
    near.series.push_back(std::move(part));
    near.marks.push_back({one.t, 1e3 * one.distance, distance_text(one.distance)});
  }
  write_svg(path, "clearance, " + shown(log), {all, near});
}

}  // namespace haptic
