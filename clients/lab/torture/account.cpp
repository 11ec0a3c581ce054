// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/torture/account.h"

#include <algorithm>

#include "proto/ipc/channels.h"
#include "proto/log/trace.h"

namespace haptic {
namespace {

// [ns]; a chunk stays open for 250 ms, is checked every 10 ms, plus a margin
constexpr int64_t kOpenChunkNs = 290'000'000;

/// Times of the servo's frames in a file, in order; adds the losses that the recorder reported.
std::vector<int64_t> recorded_times(const std::string& path, uint64_t& told) {
  const TraceReader reader(path);
  std::vector<int64_t> times;
  reader.for_each<ServoFrame>(servo_topic(kFirstHand), [&](const ServoFrame&, const Stamp& stamp) {
    times.push_back(stamp.t_ns);
  });
  reader.for_each<Event>(kEventTopic, [&](const Event& event, const Stamp&) {
    // a client that floods its ring loses its own frames
    const bool is_clients = event.source >= static_cast<uint32_t>(ClientChannels::id(0)) &&
                            event.source < static_cast<uint32_t>(ClientChannels::id(kMostClients));
    if (event.code == static_cast<uint32_t>(EventCode::kRecordsLost) && !is_clients) {
      told += static_cast<uint64_t>(event.numbers[0]);
    }
  });
  std::sort(times.begin(), times.end());
  return times;
}

/// The earliest time at which a killed recorder can have opened its unwritten chunk: the time it
/// was stalled extends the chunk.
int64_t open_chunk_ns(const RecordingPart& part) {
  int64_t since_ns = part.killed_ns - kOpenChunkNs;
  for (int64_t before_ns = 0; since_ns != before_ns;) {
    before_ns = since_ns;
    since_ns = part.killed_ns - kOpenChunkNs - held_up(part.stalls, before_ns, part.killed_ns);
  }
  return since_ns;
}

/// Index of the first published frame not older than t_ns.
size_t index_of(const std::vector<SeenFrame>& published, int64_t t_ns) {
  const auto at =
      std::lower_bound(published.begin(), published.end(), t_ns,
                       [](const SeenFrame& frame, int64_t time) { return frame.t_ns < time; });
  return static_cast<size_t>(at - published.begin());
}

/// Accounts for the frames [from, to) by the times in the file of the recorder then running.
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
      // two frames with equal times must both be in the file
      ++next;
      ++account.recorded;
      continue;
    }
    // a file may end early, but it has no gaps
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
  // a recorder is responsible from its first frame to the first of its successor
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
