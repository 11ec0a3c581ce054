// SPDX-License-Identifier: Apache-2.0
#include "proto/log/hand_trace.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <limits>

#include "proto/log/csv.h"
#include "proto/log/layout.h"
#include "proto/log/trace.h"
#include "proto/os/regular_file.h"

namespace haptic {
namespace {

constexpr double kNsPerS = 1e9;
// Largest absolute time of a sample [s]: a century; differences of two still fit in nanoseconds.
constexpr double kMostTime = 3.2e9;
constexpr double kUnitTolerance = 1e-6;  // of a quaternion's length; rounding in a file causes 1e-7

std::string as_seconds(int64_t t_ns) {
  return std::to_string(static_cast<double>(t_ns) / kNsPerS) + " s";
}

/// Why a sample cannot be played; empty: it can.
std::string problem_of(const DeviceState& sample) {
  if (std::abs(static_cast<double>(sample.t_ns)) > kMostTime * kNsPerS) {
    return "time is more than a century from zero; subtract the time of the first sample";
  }
  if (!is_finite(sample.X_BH) || !is_finite(sample.V_BH) || !std::isfinite(sample.grip)) {
    return "has a number that is not finite; remove it";
  }
  const Quat& q = sample.X_BH.q;
  const double squared = q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w;
  if (!(std::abs(squared - 1) <= 2 * kUnitTolerance)) {
    return "has an orientation that is no unit quaternion; record it again";
  }
  return "";
}

/// Appends a sample; calls `fail` if it cannot be played or time does not advance.
template <typename Fail>
void append(HandTrace& trace, const DeviceState& sample, uint64_t tick, const Fail& fail) {
  if (const std::string problem = problem_of(sample); !problem.empty()) fail(problem);
  if (!trace.samples.empty()) {
    const DeviceState& last = trace.samples.back();
    if (sample.t_ns <= last.t_ns) {
      fail("time does not advance: " + as_seconds(sample.t_ns) + " after " + as_seconds(last.t_ns) +
           "; sort the file by time and remove repeated rows");
    }
  }
  trace.samples.push_back(sample);
  trace.ticks.push_back(tick);
}

HandTrace load_mcap(const std::string& path) {
  HandTrace trace;
  const TraceReader reader(path);
  trace.notice = reader.notice(*find_topic(servo_topic(kFirstHand).name));
  reader.for_each<ServoFrame>(servo_topic(kFirstHand), [&](const ServoFrame& frame, const Stamp&) {
    if ((frame.device.flags & kDeviceFresh) == 0) return;
    append(trace, frame.device, frame.tick, [&](const std::string& what) {
      throw McapError(path + ": tick " + std::to_string(frame.tick) + ": " + what);
    });
  });
  return trace;
}

/// Loads the columns `device.*` written by export_csv().
HandTrace load_export(CsvReader& csv) {
  struct Part {
    size_t column, offset;
    std::string type;
  };
  std::vector<Part> parts;
  for (const Field& field : flatten(Schema<ServoFrame>::text)) {
    if (!field.name.starts_with("device.")) continue;
    const size_t offset = field.offset - offsetof(ServoFrame, device);
    const std::string name = column_name(field);
    // exported before the field was there: its bytes stay zero
    if (csv.find(name) == CsvReader::npos && is_new_as_zero("ServoFrame", field.name)) continue;
    parts.push_back({csv.require(name), offset, field.type});
  }
  const size_t tick = csv.find("tick");
  HandTrace trace;
  while (csv.next()) {
    std::array<std::byte, sizeof(DeviceState)> bytes{};
    const auto put = [&](size_t offset, auto value) {
      std::memcpy(&bytes[offset], &value, sizeof value);
    };
    for (const Part& part : parts) {
      if (part.type == "float64") {
        put(part.offset, csv.number(part.column));
      } else if (part.type == "int64") {
        put(part.offset, csv.integer(part.column));
      } else {
        put(part.offset, static_cast<uint32_t>(csv.integer(part.column)));
      }
    }
    const DeviceState sample = std::bit_cast<DeviceState>(bytes);
    if ((sample.flags & kDeviceFresh) == 0) continue;
    const uint64_t number =
        tick == CsvReader::npos ? trace.ticks.size() : static_cast<uint64_t>(csv.integer(tick));
    append(trace, sample, number, [&](const std::string& what) { csv.fail(what); });
  }
  return trace;
}

DeviceState sample_at(double t_s) {
  DeviceState sample{};
  // beyond what append() accepts, within the range of an integer
  sample.t_ns = std::llround(std::clamp(t_s, -2 * kMostTime, 2 * kMostTime) * kNsPerS);
  sample.flags = kDeviceFresh | kDeviceHomed;
  return sample;
}

/// Loads one recorded degree of freedom along an axis.
HandTrace load_column(CsvReader& csv, const ReplayConfig& config) {
  const size_t time = csv.require("t_s");
  const size_t column = csv.require(view(config.column));
  const double scale = config.lever_arm > 0 ? config.lever_arm : 1;
  HandTrace trace;
  while (csv.next()) {
    DeviceState sample = sample_at(csv.number(time));
    sample.X_BH.p = scale * csv.number(column) * config.axis_B;
    append(trace, sample, trace.ticks.size(), [&](const std::string& what) { csv.fail(what); });
  }
  return trace;
}

uint32_t buttons_in(CsvReader& csv, size_t column) {
  const int64_t buttons = csv.integer(column);
  if (buttons < 0 || buttons > std::numeric_limits<uint32_t>::max()) {
    csv.fail("'buttons' is one bit for each of 32 buttons, 0 to 4294967295");
  }
  return static_cast<uint32_t>(buttons);
}

HandTrace load_positions(CsvReader& csv) {
  const size_t time = csv.require("t_s");
  constexpr std::string_view kOneDof =
      "; a recording of one angle or length is played with `column` in [device.replay], as "
      "configs/lever.toml does";
  const size_t x = csv.require("x_m", kOneDof), y = csv.require("y_m"), z = csv.require("z_m");
  const bool turns = csv.find("qx") != CsvReader::npos;
  std::array<size_t, 4> q{};
  if (turns) q = {csv.require("qx"), csv.require("qy"), csv.require("qz"), csv.require("qw")};
  const size_t buttons = csv.find("buttons");
  HandTrace trace;
  while (csv.next()) {
    DeviceState sample = sample_at(csv.number(time));
    sample.X_BH.p = {csv.number(x), csv.number(y), csv.number(z)};
    if (turns) {
      sample.X_BH.q =
          normalized(Quat{csv.number(q[0]), csv.number(q[1]), csv.number(q[2]), csv.number(q[3])});
    }
    if (buttons != CsvReader::npos) sample.buttons = buttons_in(csv, buttons);
    append(trace, sample, trace.ticks.size(), [&](const std::string& what) { csv.fail(what); });
  }
  return trace;
}

HandTrace load_csv(const std::string& path, const ReplayConfig& config) {
  CsvReader csv(path);
  if (csv.find("device.t_ns") != CsvReader::npos) return load_export(csv);
  if (!view(config.column).empty()) return load_column(csv, config);
  return load_positions(csv);
}

}  // namespace

double HandTrace::time_of(uint64_t tick) const {
  const auto at = std::ranges::lower_bound(ticks, tick);
  if (at == ticks.end()) return duration();
  const DeviceState& sample = samples[static_cast<size_t>(at - ticks.begin())];
  return static_cast<double>(sample.t_ns - samples.front().t_ns) / kNsPerS;
}

HandTrace load_hand_trace(const ReplayConfig& config) {
  const std::string path(view(config.path));
  const std::string problem = open_regular_file(path).problem;
  if (!problem.empty()) {
    throw CsvError(path + ": " + problem + "; name a recording (.mcap or .csv)");
  }
  const bool is_mcap = is_mcap_file(path);
  HandTrace trace = is_mcap ? load_mcap(path) : load_csv(path, config);
  if (trace.samples.size() < 2) {
    const std::string what = path + ": holds " + std::to_string(trace.samples.size()) +
                             " samples of the hand; a motion needs at least two, record it again";
    if (is_mcap) throw McapError(what);
    throw CsvError(what);
  }
  return trace;
}

}  // namespace haptic
