// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/torture_account.h"

#include <algorithm>
#include <limits>

#include "proto/trace.h"

namespace haptic {
namespace {

// a chunk stays open for a quarter of a second, and is looked at every ten milliseconds
constexpr int64_t kOpenChunkNs = 290'000'000;

/// The times of the servo's frames in a file, in order; adds what the recorder lost.
std::vector<int64_t> recorded_times(const std::string& path, uint64_t& told) {
  const TraceReader reader(path);
  std::vector<int64_t> times;
  reader.for_each<ServoFrame>(
      kServo0Topic, [&](const ServoFrame&, const Stamp& stamp) { times.push_back(stamp.t_ns); });
  reader.for_each<Event>(kEventTopic, [&](const Event& event, const Stamp&) {
    if (event.code == static_cast<uint32_t>(EventCode::kRecordsLost)) {
      told += static_cast<uint64_t>(event.numbers[0]);
    }
  });
  std::sort(times.begin(), times.end());
  return times;
}

/// Whether a frame of that time may be missing from the part whose turn it was.
bool is_explained(const RecordingPart& part, int64_t t_ns) {
  if (part.ended_ns == 0) return false;
  return t_ns >= part.ended_ns - (part.killed ? kOpenChunkNs : 0);
}

}  // namespace

SampleAccount account_for_samples(const std::vector<RecordingPart>& parts,
                                  const std::vector<int64_t>& published) {
  SampleAccount account;
  std::vector<std::vector<int64_t>> times(parts.size());
  for (size_t i = 0; i < parts.size(); ++i) {
    try {
      times[i] = recorded_times(parts[i].path, account.told);
    } catch (const McapError& error) {
      account.unreadable.push_back(error.what());
    }
  }
  for (size_t i = 0; i < parts.size(); ++i) {
    if (times[i].empty()) continue;
    // from its first frame to the first of its successor
    int64_t end_ns = std::numeric_limits<int64_t>::max();
    for (size_t j = parts.size() - 1; j > i; --j) {
      if (!times[j].empty()) end_ns = times[j].front();
    }
    const auto first = std::lower_bound(published.begin(), published.end(), times[i].front());
    for (auto t = first; t != published.end() && *t < end_ns; ++t) {
      ++account.published;
      if (std::binary_search(times[i].begin(), times[i].end(), *t)) {
        ++account.recorded;
      } else if (is_explained(parts[i], *t)) {
        ++account.explained;
      } else {
        ++account.unexplained;
      }
    }
  }
  return account;
}

}  // namespace haptic
