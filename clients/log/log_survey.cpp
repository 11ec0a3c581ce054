// SPDX-License-Identifier: Apache-2.0
#include "clients/log/log_survey.h"

#include <algorithm>

namespace haptic {
void LogStep::add(const LogStep& more) {
  for (size_t i = 0; i < kNumPlotted && more.frames > 0; ++i) {
    low[i] = frames == 0 ? more.low[i] : std::min(low[i], more.low[i]);
    high[i] = frames == 0 ? more.high[i] : std::max(high[i], more.high[i]);
  }
  frames += more.frames;
}

std::array<double, kNumPlotted> PlottedOf::operator()(const ServoFrame& frame) {
  samples_.add(sample_of(frame, X_WB_));
  const Sample& s = samples_.at(samples_.end() - 1);
  const Vec3 &f = s.force_W, &t = s.torque_W;
  return {f.x, f.y, f.z, norm(f), t.x, t.y, t.z, norm(t), s.depth, s.wake_late, s.contact_rate};
}

LogSurvey::LogSurvey(const LogIndex& index, const Quat& q_WB) : index_(index) {
  for (const LogColumn& column : index_.columns()) {
    const Topic<ServoFrame> topic{column.servo};
    runs_.push_back({.frames = {index_.trace(), info_of(topic)}, .plotted = PlottedOf(q_WB)});
  }
}

double LogSurvey::share() const {
  const size_t all = index_.trace().mcap().chunks().size();
  return all == 0 ? 1 : static_cast<double>(next_chunk_) / static_cast<double>(all);
}

bool LogSurvey::advance(size_t chunks) {
  const size_t all = index_.trace().mcap().chunks().size();
  for (; chunks > 0 && next_chunk_ < all; --chunks, ++next_chunk_) {
    for (uint32_t i = 0; i < runs_.size(); ++i) {
      while (runs_[i].frames.next(next_chunk_)) add(runs_[i].frames.read<ServoFrame>(), i);
    }
  }
  return next_chunk_ < all;
}

void LogSurvey::add(const ServoFrame& frame, uint32_t column) {
  Run& run = runs_[column];
  const uint64_t tick = index_.tick_of(frame.t_ns);
  const auto mark = [&](MarkKind kind) { marks_.push_back({tick, frame.t_ns, kind, column}); };
  const bool touches = (frame.flags & kServoContact) != 0;
  if (touches && (!run.has_begun || tick - run.last_contact > kApartTicks))
    mark(MarkKind::kContact);
  if (touches || !run.has_begun) run.last_contact = tick;
  const bool is_faulty = (frame.flags & kServoFault) != 0;
  if (is_faulty && !run.was_faulty) mark(MarkKind::kFault);
  run.was_faulty = is_faulty;
  if (run.has_begun && frame.skipped > run.skipped) mark(MarkKind::kLate);
  run.skipped = frame.skipped;
  run.has_begun = true;

  const uint64_t number = (tick - index_.first_tick()) / kStepTicks;
  // a wild instant in a damaged file must not take all memory
  constexpr uint64_t kMostSteps = uint64_t{1} << 24;
  if (number >= kMostSteps) return;
  if (run.steps.size() <= number) run.steps.resize(number + 1);
  const std::array<double, kNumPlotted> now = run.plotted(frame);
  run.steps[number].add({tick, tick, 1, now, now});
}

std::vector<LogStep> LogSurvey::overview(uint64_t from, uint64_t to, size_t n,
                                         size_t column) const {
  const std::vector<LogStep>& steps = runs_.at(column).steps;
  std::vector<LogStep> out(n);
  const uint64_t first = index_.first_tick();
  const double each =
      static_cast<double>(to - from + 1) / static_cast<double>(std::max<size_t>(n, 1));
  for (size_t k = 0; k < n; ++k) {
    LogStep& step = out[k];
    step.first_tick = from + static_cast<uint64_t>(each * static_cast<double>(k));
    step.last_tick = std::max(step.first_tick,
                              from + static_cast<uint64_t>(each * static_cast<double>(k + 1)) - 1);
    const uint64_t begin = (std::max(step.first_tick, first) - first) / kStepTicks;
    const uint64_t end = (std::max(step.last_tick, first) - first) / kStepTicks;
    for (uint64_t i = begin; i <= end && i < steps.size(); ++i) step.add(steps[i]);
  }
  return out;
}

}  // namespace haptic
