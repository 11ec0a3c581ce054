// SPDX-License-Identifier: Apache-2.0
#include "proto/hand_trace.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstring>

#include "proto/csv.h"
#include "proto/trace.h"

namespace haptic {
namespace {

constexpr double kNsPerS = 1e9;

double seconds_between(const DeviceState& a, const DeviceState& b) {
  return static_cast<double>(b.t_ns - a.t_ns) / kNsPerS;
}

std::string as_seconds(int64_t t_ns) {
  return std::to_string(static_cast<double>(t_ns) / kNsPerS) + " s";
}

/// Appends a sample; `fail` is told when time does not advance.
template <typename Fail>
void append(HandTrace& trace, const DeviceState& sample, double max_gap, const Fail& fail) {
  if (!trace.samples.empty()) {
    const DeviceState& last = trace.samples.back();
    if (sample.t_ns <= last.t_ns) {
      fail("time does not advance: " + as_seconds(sample.t_ns) + " after " + as_seconds(last.t_ns) +
           "; sort the file by time and remove repeated rows");
    }
    const double gap = seconds_between(last, sample);
    trace.longest_gap = std::max(trace.longest_gap, gap);
    if (gap > max_gap) trace.after_gap.push_back(trace.samples.size());
  }
  trace.samples.push_back(sample);
}

/// Central difference of the position, one-sided at the ends.
void differentiate(std::vector<DeviceState>& samples) {
  for (size_t i = 0; i < samples.size(); ++i) {
    const DeviceState& before = samples[i > 0 ? i - 1 : 0];
    const DeviceState& after = samples[std::min(i + 1, samples.size() - 1)];
    if (before.t_ns == after.t_ns) continue;
    samples[i].V_BH.v = (after.X_BH.p - before.X_BH.p) / seconds_between(before, after);
  }
}

HandTrace load_mcap(const std::string& path, double max_gap) {
  HandTrace trace;
  const TraceReader reader(path);
  reader.for_each<ServoFrame>(kServo0Topic, [&](const ServoFrame& frame, const Stamp&) {
    if ((frame.device.flags & kDeviceFresh) == 0) return;
    append(trace, frame.device, max_gap, [&](const std::string& what) {
      throw McapError(path + ": tick " + std::to_string(frame.tick) + ": " + what);
    });
  });
  return trace;
}

/// The columns `device.*` that export_csv() writes.
HandTrace load_export(CsvReader& csv, double max_gap) {
  struct Part {
    size_t column, offset;
    std::string type;
  };
  std::vector<Part> parts;
  for (const Field& field : flatten(Schema<ServoFrame>::text)) {
    if (!field.name.starts_with("device.")) continue;
    const size_t offset = field.offset - offsetof(ServoFrame, device);
    parts.push_back({csv.require(column_name(field)), offset, field.type});
  }
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
    append(trace, sample, max_gap, [&](const std::string& what) { csv.fail(what); });
  }
  return trace;
}

DeviceState sample_at(double t_s) {
  DeviceState sample{};
  sample.t_ns = std::llround(t_s * kNsPerS);
  sample.flags = kDeviceFresh | kDeviceHomed;
  return sample;
}

/// One recorded degree of freedom along an axis.
HandTrace load_column(CsvReader& csv, const ReplayConfig& config) {
  const size_t time = csv.require("t_s");
  const size_t column = csv.require(view(config.column));
  const double scale = config.lever_arm > 0 ? config.lever_arm : 1;
  HandTrace trace;
  while (csv.next()) {
    DeviceState sample = sample_at(csv.number(time));
    sample.X_BH.p = scale * csv.number(column) * config.axis_B;
    append(trace, sample, config.max_gap, [&](const std::string& what) { csv.fail(what); });
  }
  differentiate(trace.samples);
  return trace;
}

HandTrace load_positions(CsvReader& csv, double max_gap) {
  const size_t time = csv.require("t_s");
  const size_t x = csv.require("x_m"), y = csv.require("y_m"), z = csv.require("z_m");
  const bool turns = csv.find("qx") != CsvReader::npos;
  std::array<size_t, 4> q{};
  if (turns) q = {csv.require("qx"), csv.require("qy"), csv.require("qz"), csv.require("qw")};
  HandTrace trace;
  while (csv.next()) {
    DeviceState sample = sample_at(csv.number(time));
    sample.X_BH.p = {csv.number(x), csv.number(y), csv.number(z)};
    if (turns) {
      sample.X_BH.q =
          normalized(Quat{csv.number(q[0]), csv.number(q[1]), csv.number(q[2]), csv.number(q[3])});
    }
    append(trace, sample, max_gap, [&](const std::string& what) { csv.fail(what); });
  }
  differentiate(trace.samples);
  return trace;
}

HandTrace load_csv(const std::string& path, const ReplayConfig& config) {
  CsvReader csv(path);
  if (csv.find("device.t_ns") != CsvReader::npos) return load_export(csv, config.max_gap);
  if (!view(config.column).empty()) return load_column(csv, config);
  return load_positions(csv, config.max_gap);
}

}  // namespace

HandTrace load_hand_trace(const ReplayConfig& config) {
  const std::string path(view(config.path));
  const bool is_mcap = path.ends_with(".mcap");
  HandTrace trace = is_mcap ? load_mcap(path, config.max_gap) : load_csv(path, config);
  if (trace.samples.size() < 2) {
    const std::string what = path + ": holds " + std::to_string(trace.samples.size()) +
                             " samples of the hand; a motion needs at least two";
    if (is_mcap) throw McapError(what);
    throw CsvError(what);
  }
  return trace;
}

}  // namespace haptic
