// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "clients/log/log_index.h"
#include "clients/log/samples.h"
#include "proto/math/pose.h"

namespace haptic {

enum class MarkKind : uint32_t { kContact = 0, kFault = 1, kLate = 2 };

inline constexpr std::array<const char*, 3> kMarkKinds{"contact", "fault", "late"};

/// A tick that one wants to go to: a contact begins (after kApartTicks without), a fault is
/// latched, or ticks have been skipped before it.
struct LogMark {
  uint64_t tick = 0;
  int64_t t_ns = 0;
  MarkKind kind{};
  uint32_t column = 0;
};
inline constexpr uint64_t kApartTicks = 20;  // a bounce of the hand is shorter

/// The plotted quantities of a frame: force and torque at the device, turned into W, and their
/// norms [N], [N·m], distance from tool to proxy [m], lateness of the wake-up [s], answers of
/// contact a second over the last 100 frames [Hz].
enum Plotted : size_t {
  kForceX,
  kForceY,
  kForceZ,
  kForce,
  kTorqueX,
  kTorqueY,
  kTorqueZ,
  kTorque,
  kDepth,
  kLate,
  kContactRate,
  kNumPlotted
};

/// Computes them for frames in order.
class PlottedOf {
 public:
  /// `q_WB`: the base of the device in W.
  explicit PlottedOf(const Quat& q_WB) : X_WB_{{}, q_WB} {}
  std::array<double, kNumPlotted> operator()(const ServoFrame& frame);

 private:
  Pose X_WB_;
  Samples samples_;
};

/// Smallest and largest values over some ticks; `frames` 0: there are none.
struct LogStep {
  uint64_t first_tick = 0, last_tick = 0, frames = 0;
  std::array<double, kNumPlotted> low{}, high{};

  /// Adds the values of others; first and last tick stay.
  void add(const LogStep& more);
};

/// The overview of a whole recording: marks, and smallest and largest values in steps of
/// kStepTicks. It has to read every frame, so it is done piece by piece, on a thread or between two
/// requests.
class LogSurvey {
 public:
  /// `index` must outlive it. `q_WB`: the base of the device in W, for the components of the force.
  explicit LogSurvey(const LogIndex& index, const Quat& q_WB = {});

  /// Reads that many more chunks, also of what the index has found since. True as long as there are
  /// more. Throws McapError.
  bool advance(size_t chunks);
  /// Share of the file that has been read.
  double share() const;

  /// In the order of their ticks for each column.
  const std::vector<LogMark>& marks() const { return marks_; }
  /// `n` steps of equal length from one tick to another, out of what has been read; a step shorter
  /// than kStepTicks repeats that of its surroundings. LogIndex::for_each_frame() is exact.
  std::vector<LogStep> overview(uint64_t from, uint64_t to, size_t n, size_t column = 0) const;

 private:
  struct Run {  // of a column
    TopicCursor frames;
    PlottedOf plotted;
    std::vector<LogStep> steps{};
    uint64_t last_contact = 0, skipped = 0;
    bool was_faulty = false, has_begun = false;
  };
  void add(const ServoFrame& frame, uint32_t column);

  const LogIndex& index_;
  std::vector<Run> runs_;
  std::vector<LogMark> marks_;
  size_t next_chunk_ = 0;
};
inline constexpr uint64_t kStepTicks = 100;  // a tenth of a second: a slider has no finer steps

}  // namespace haptic
