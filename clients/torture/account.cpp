// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/torture/account.h"

#include <algorithm>

#include "proto/log/trace.h"

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

/// When the chunk was opened, at the earliest, that a recorder had not written when it was killed:
/// it stays open for as long as the recorder had no time.
int64_t open_chunk_ns(const RecordingPart& part) {
  int64_t since_ns = part.killed_ns - kOpenChunkNs;
  for (int64_t before_ns = 0; since_ns != before_ns;) {
    before_ns = since_ns;
    since_ns = part.killed_ns - kOpenChunkNs - held_up(part.stalls, before_ns, part.killed_ns);
  }
  return since_ns;
}

/// Index of the first published frame that is no older.
size_t index_of(const std::vector<SeenFrame>& published, int64_t t_ns) {
  const auto at =
      std::lower_bound(published.begin(), published.end(), t_ns,
                       [](const SeenFrame& frame, int64_t time) { return frame.t_ns < time; });
  return static_cast<size_t>(at - published.begin());
}

/// Of the frames [from, to), against the times in the file whose turn it was.
void account_for_part(const RecordingPart& part, const std::vector<int64_t>& times,
                      const std::vector<SeenFrame>& published, size_t from, size_t to,
                      SampleAccount& account) {
  const int64_t open_ns = open_chunk_ns(part);
  auto next = times.begin();
  for (size_t i = from; i < to; ++i) {
    const SeenFrame& frame = published[i];
    while (next != times.end() && *next < frame.t_ns) ++next;
    ++account.published;
    if (next != times.end() && *next == frame.t_ns) {
      // a time that comes twice is to be in the file twice
      ++next;
      ++account.recorded;
      continue;
    }
    // a file ends early, it has no gaps
    const bool is_tail = next == times.end();
    const bool was_open = part.killed_ns != 0 && frame.seen_ns >= open_ns;
    const bool explained = is_tail && (i >= part.n_seen || was_open);
    ++(explained ? account.explained : account.unexplained);
  }
}

}  // namespace

SampleAccount account_for_samples(const std::vector<RecordingPart>& parts,
                                  const std::vector<SeenFrame>& published) {
  SampleAccount account;
  std::vector<std::vector<int64_t>> times(parts.size());
  for (size_t i = 0; i < parts.size(); ++i) {
    try {
      times[i] = recorded_times(parts[i].path, account.told);
    } catch (const McapError& error) {
      account.unreadable.push_back(error.what());
    }
  }
  // from its first frame to the first of its successor
  size_t end = published.size();
  for (size_t i = parts.size(); i-- > 0;) {
    if (times[i].empty()) continue;
    const size_t from = index_of(published, times[i].front());
    account_for_part(parts[i], times[i], published, from, end, account);
    end = from;
  }
  return account;
}

}  // namespace haptic
