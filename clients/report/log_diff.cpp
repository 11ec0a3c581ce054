// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/report/log_diff.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <string_view>
#include <vector>

#include "clients/log/log_columns.h"
#include "proto/log/csv.h"
#include "proto/os/message.h"

namespace haptic {
namespace {

// what the clock and the load of the machine decide
constexpr std::array<std::string_view, 8> kOfTheMachine{
    "t_ns",    "realtime_ns", "device.t_ns", "wake_late_ns",
    "busy_ns", "contact_seq", "scene_seq",   "behind_since_ns"};

constexpr uint32_t kFlagsOfTheMachine = kServoLate | kServoContactLate | kServoSimLate;

std::vector<Field> compared_fields(bool exact) {
  std::vector<Field> fields = flatten(Schema<ServoFrame>::text);
  if (exact) return fields;
  std::erase_if(fields, [](const Field& field) {
    return std::ranges::find(kOfTheMachine, field.name) != kOfTheMachine.end();
  });
  return fields;
}

double number_of(const std::byte* record, const Field& field) {
  double number = 0;
  with_number(field.type, record + field.offset,
              [&](auto value) { number = static_cast<double>(value); });
  return number;
}

/// The servo frames of one column of a file, one after the other.
class Frames {
 public:
  Frames(const std::string& path, const std::string& column)
      : trace_(path), topic_(topic_of(path, column)), cursor_(trace_, info_of(topic())) {
    advance();
  }
  bool has() const { return has_; }
  const ServoFrame& frame() const { return frame_; }
  const std::byte* bytes() const { return reinterpret_cast<const std::byte*>(&frame_); }
  void advance() {
    has_ = cursor_.next();
    if (has_) frame_ = cursor_.read<ServoFrame>();
  }

 private:
  Topic<ServoFrame> topic() const { return {topic_}; }
  std::string topic_of(const std::string& path, const std::string& column) const {
    std::string known;
    for (const LogColumn& one : log_columns(trace_)) {
      if (column.empty() || one.name == column) return one.servo;
      known += (known.empty() ? "" : ", ") + one.name;
    }
    throw McapError(
        path + ": has no " + (column.empty() ? "servo frames" : "column '" + shown(column) + "'") +
        (known.empty() ? "; name a recording of a session" : "; it has " + shown(known)));
  }

  TraceReader trace_;
  std::string topic_;
  TopicCursor cursor_;
  ServoFrame frame_{};
  bool has_ = false;
};

/// Notes the first difference.
void note(LogDiff& diff, uint64_t tick, const std::string& field, double a, double b) {
  if (!diff.first_field.empty()) return;
  diff.first_tick = tick;
  diff.first_field = field;
  diff.first_a = a;
  diff.first_b = b;
}

void compare(const Frames& a, const Frames& b, const std::vector<Field>& fields, bool exact,
             LogDiff& diff) {
  ++diff.common;
  diff.rms_force += norm_squared(a.frame().F_device_B.f - b.frame().F_device_B.f);
  diff.rms_proxy += norm_squared(a.frame().X_WP.p - b.frame().X_WP.p);
  const auto differs = [&](const Field& field) {
    if (!exact && field.offset == offsetof(ServoFrame, flags)) {
      return ((a.frame().flags ^ b.frame().flags) & ~kFlagsOfTheMachine) != 0;
    }
    return std::memcmp(a.bytes() + field.offset, b.bytes() + field.offset, size_of(field)) != 0;
  };
  const auto field = std::ranges::find_if(fields, differs);
  if (field == fields.end()) return;
  ++diff.different;
  note(diff, a.frame().tick, field->name, number_of(a.bytes(), *field),
       number_of(b.bytes(), *field));
}

}  // namespace

LogDiff diff_logs(const std::string& path_a, const std::string& path_b, const std::string& column,
                  bool exact) {
  const std::vector<Field> fields = compared_fields(exact);
  Frames a(path_a, column), b(path_b, column);
  LogDiff diff;
  while (a.has() || b.has()) {
    const bool lacks_b = !b.has() || (a.has() && a.frame().tick < b.frame().tick);
    const bool lacks_a = !a.has() || (b.has() && b.frame().tick < a.frame().tick);
    if (!lacks_a && !lacks_b) {
      compare(a, b, fields, exact, diff);
    } else {
      note(diff, (lacks_b ? a : b).frame().tick, lacks_b ? "missing in B" : "missing in A", 0, 0);
      ++(lacks_b ? diff.only_a : diff.only_b);
    }
    if (!lacks_a) a.advance();
    if (!lacks_b) b.advance();
  }
  if (diff.common > 0) {
    diff.rms_force = std::sqrt(diff.rms_force / static_cast<double>(diff.common));
    diff.rms_proxy = std::sqrt(diff.rms_proxy / static_cast<double>(diff.common));
  }
  return diff;
}

}  // namespace haptic
