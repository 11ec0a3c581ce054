// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/support/measurement.h"

#include <array>
#include <boost/lockfree/spsc_queue.hpp>
#include <cstring>
#include <stdexcept>
#include <string>
#include <tuple>

#include "clients/lab/bench/workloads/burst.h"
#include "proto/ipc/segment.h"
#include "proto/math/units.h"
#include "proto/os/progress.h"

namespace haptic {

template <size_t kBytes>
struct BenchMessage {
  int64_t sent_ns;
  std::array<uint64_t, kBytes / 8 - 1> words;
};

inline constexpr uint64_t kBenchSlots = 1024;  // of a ring, as in a session

template <size_t kBytes>
struct BenchChannels {
  static constexpr SegmentId kId = SegmentId::kSim;
  static constexpr const char* kName = "bench";
  Ring<BenchMessage<kBytes>, kBenchSlots> messages;
  using Rings = std::tuple<decltype(messages)>;
};

namespace {

constexpr const char* kPeer = "boost::lockfree::spsc_queue";

/// Our ring in a sealed segment, read through a read-only mapping.
template <size_t kBytes>
class RingLink {
 public:
  using Message = BenchMessage<kBytes>;
  RingLink() : writer_(1), view_(reopen_read_only(writer_.fd())) {}
  void push(const Message& message, const Burst& burst) {
    // credit: at most half a ring ahead of the reader
    while (next_ - taken_ >= kBenchSlots / 2) {
      taken_ = burst.taken.load(std::memory_order_acquire);
    }
    writer_.channels().messages.publish(message);
    ++next_;
  }
  bool pop(Message& out) { return read_next(view_.channels().messages, cursor_, out); }
  uint64_t lost() const { return cursor_.lost; }

 private:
  SegmentWriter<BenchChannels<kBytes>> writer_;
  SegmentView<BenchChannels<kBytes>> view_;
  uint64_t next_ = 0, taken_ = 0;
  Cursor cursor_;
};

/// The peer. Both its indices are in one mapping that both ends must be able to write.
template <size_t kBytes>
class QueueLink {
 public:
  using Message = BenchMessage<kBytes>;
  void push(const Message& message, const Burst&) {
    while (!queue_->push(message)) {
    }
  }
  bool pop(Message& out) { return queue_->pop(out); }
  uint64_t lost() const { return 0; }

 private:
  Shared<boost::lockfree::spsc_queue<Message, boost::lockfree::capacity<kBenchSlots>>> queue_;
};

/// Sends `count` messages from one process to another; `one_at_a_time`: the next only after the
/// previous one was taken. Leaves one-way times in the burst, or start and end.
template <typename Link>
void send(Burst& burst, uint64_t count, bool one_at_a_time) {
  const int64_t start_ns = now_ns();
  Link link;
  using Message = typename Link::Message;
  ForkedProcess reader([&] {
    burst.begin(kReaderProcessor);
    // asleep: a process that spins at FIFO for two seconds is killed, and the other may be late
    burst.wait_for(2);
    Message out;
    for (uint64_t n = 0; n < count;) {
      if (!link.pop(out)) continue;
      ++n;
      if (one_at_a_time) burst.add_sample(now_ns() - out.sent_ns);
      if (one_at_a_time || n % 64 == 0) burst.taken.store(n, std::memory_order_release);
    }
    burst.end_ns = now_ns();
    if (link.lost() > 0) throw std::logic_error("lost a message in spite of credit");
  });
  ForkedProcess writer([&] {
    burst.begin(kWriterProcessor);
    burst.wait_for(2);
    Message message{};
    burst.start_ns = now_ns();
    for (uint64_t n = 0; n < count; ++n) {
      message.words[0] = n;
      if (one_at_a_time) {
        while (burst.taken.load(std::memory_order_acquire) < n) {
        }
        // until the reader polls again
        for (const int64_t until = now_ns() + 500; now_ns() < until;) {
        }
        message.sent_ns = now_ns();
      }
      link.push(message, burst);
    }
  });
  check_ends({{&writer, "a writer"}, {&reader, "a reader"}});
  pause_after(start_ns);
}

/// Percentiles of bursts, one value per round.
struct Times {
  std::vector<double> p50, p99;
  void add(const Burst& burst, Rights& rights) {
    p50.push_back(percentile(burst, 50));
    p99.push_back(percentile(burst, 99));
    rights.take(burst);
  }
};

/// Figures of one kind of link at one size.
struct LinkFigures : Times {
  std::vector<double> rate;
};

template <typename Link>
void measure_link(LinkFigures& figures, Rights& rights) {
  Shared<Burst> one_way;
  send<Link>(*one_way, kMaxSamples, true);
  figures.add(*one_way, rights);
  Shared<Burst> flow;
  const uint64_t count = sizeof(typename Link::Message) > 1024 ? 50'000 : 400'000;
  send<Link>(*flow, count, false);
  figures.rate.push_back(static_cast<double>(count) / seconds(flow->end_ns - flow->start_ns));
  rights.take(*flow);
}

template <size_t kBytes>
void bench_size(int rounds, Rights& rights, const Rows& all) {
  LinkFigures ring, queue;
  Progress progress(std::to_string(kBytes) + " B", rounds);
  for (int round = 0; round < rounds; ++round) {
    progress.at(round);
    measure_link<RingLink<kBytes>>(ring, rights);
    measure_link<QueueLink<kBytes>>(queue, rights);
  }
  Rows rows = all.of(std::to_string(kBytes) + " B");
  const std::string size = std::to_string(kBytes) + " B, ";
  rows.add_beside(size + "one way p50", median(ring.p50), "s", kPeer, median(queue.p50));
  rows.add_beside(size + "one way p99", median(ring.p99), "s", kPeer, median(queue.p99));
  rows.add_beside(size + "throughput, nothing lost", median(ring.rate), "1/s", kPeer,
                  median(queue.rate));
}

using ServoRing = decltype(ServoChannels::frames);

enum class Audience { kOneFast, kEightSlow, kEightStopped };

size_t n_readers(Audience audience) {
  return audience == Audience::kOneFast ? 1 : kReaders;
}

void watch_frames(const SegmentView<ServoChannels>& view, Audience audience, Burst& burst) {
  burst.begin(kReaderProcessor);
  burst.wait_for(n_readers(audience) + 1);
  Cursor cursor{view.channels().frames.published(), 0};
  ServoFrame out;
  while (!read_next(view.channels().frames, cursor, out) && !burst.stop) {
    sleep_until(now_ns() + kMs);
  }
  ++burst.n_reading;
  while (!burst.stop.load(std::memory_order_relaxed)) {
    while (read_next(view.channels().frames, cursor, out)) {
    }
    if (audience != Audience::kOneFast) sleep_until(now_ns() + 5 * kMs);
  }
}

void spin_until(int64_t t_ns) {
  while (now_ns() < t_ns) {
  }
}

constexpr int64_t kStepNs = 2'000;  // [ns]; a short servo step between wake-up and publish
constexpr uint64_t kWarmUp = 100;   // uncounted publishes of a new process

/// The writer of a burst: publishes periodically and times each call once `counts` is set.
void write_frames(ServoRing& frames, Burst& burst, int64_t period, uint64_t count) {
  burst.begin(kWriterProcessor);
  ServoFrame frame{};
  // the mapping is its parent's: once round, so that it has touched each page
  for (uint64_t n = 0; n < ServoRing::kCapacity; ++n) frames.publish(frame);
  int64_t deadline_ns = now_ns();
  for (uint64_t n = 0; n < kWarmUp + count; ++frame.tick) {
    const bool is_time = burst.counts;
    deadline_ns = is_time ? deadline_ns + period : now_ns() + period;
    // as the servo does at 1 kHz; a sleep is too coarse for the short period
    if (period >= kMs || !is_time) sleep_until(deadline_ns);
    spin_until(deadline_ns);
    frames.prefetch();
    spin_until(now_ns() + kStepNs);
    const int64_t begin_ns = now_ns();
    frames.publish(frame);
    const int64_t end_ns = now_ns();
    if (is_time && n++ >= kWarmUp) burst.add_sample(end_ns - begin_ns);
  }
  burst.stop = true;
}

/// Publishes servo frames to an audience.
void publish_frames(Burst& burst, Audience audience, int64_t period, uint64_t count) {
  const int64_t start_ns = now_ns();
  SegmentWriter<ServoChannels> segment(1);
  const SegmentView<ServoChannels> view(reopen_read_only(segment.fd()));
  std::vector<ForkedProcess> readers;
  for (size_t i = 0; i < n_readers(audience); ++i) {
    readers.emplace_back([&] { watch_frames(view, audience, burst); });
  }
  await(burst.n_ready, n_readers(audience));
  const bool are_stopped = audience == Audience::kEightStopped;
  burst.counts = !are_stopped;
  ForkedProcess writer([&] { write_frames(segment.channels().frames, burst, period, count); });
  if (are_stopped) {
    // stopped only after they have read, so that they are readers and not just mappings
    await(burst.n_reading, n_readers(audience));
    for (const ForkedProcess& reader : readers) reader.signal(SIGSTOP);
    burst.counts = true;
  }
  // stopped readers end after the writer, others in any order
  if (are_stopped) check_end({&writer, "a writer"});
  std::vector<Part> parts;
  if (!are_stopped) parts.push_back({&writer, "a writer"});
  for (ForkedProcess& reader : readers) {
    reader.signal(SIGCONT);
    parts.push_back({&reader, "a reader"});
  }
  check_ends(std::move(parts));
  pause_after(start_ns);
}

void bench_publish(int rounds, Rights& rights, const Rows& all) {
  constexpr int64_t kServoPeriod = 1'000'000, kShortPeriod = 10'000;
  std::array<Times, 3> of;  // by audience
  Times servo;
  std::vector<double> slow_ratio, stopped_ratio;
  Progress progress("publishing", rounds);
  for (int round = 0; round < rounds; ++round) {
    progress.at(round);
    for (size_t i = 0; i < of.size(); ++i) {
      Shared<Burst> burst;
      publish_frames(*burst, static_cast<Audience>(i), kShortPeriod, 10'000);
      of[i].add(*burst, rights);
    }
    slow_ratio.push_back(of[1].p50.back() / of[0].p50.back());
    stopped_ratio.push_back(of[2].p50.back() / of[0].p50.back());
    Shared<Burst> burst;
    // one second: enter_realtime allows a spinning reader two
    publish_frames(*burst, Audience::kOneFast, kServoPeriod, 1000);
    servo.add(*burst, rights);
  }
  // [s]; of a frame whose objects stand still: 0.8 kB
  constexpr double kGoalP99 = 1e-6, kGoalRatio = 1.2;
  // without real-time rights, or with a shared core, the figures are meaningless
  Rows rows = all.of("ServoFrame", rights.all());
  rows.add(
      {{"ServoFrame, bytes", 8.0 * Packing<ServoFrame>::kLeastWords, "B"},
       {"publish every 10 µs, one fast reader p50", median(of[0].p50), "s"},
       {"publish every 10 µs, one fast reader p99", median(of[0].p99), "s", at_most(kGoalP99)},
       {"publish at 1 kHz, one fast reader p50", median(servo.p50), "s"},
       {"publish at 1 kHz, one fast reader p99", median(servo.p99), "s", at_most(kGoalP99)},
       {"publish every 10 µs, 8 slow readers p50", median(of[1].p50), "s"},
       {"publish every 10 µs, 8 slow readers p99", median(of[1].p99), "s"},
       {"publish every 10 µs, 8 stopped readers p50", median(of[2].p50), "s"},
       {"publish every 10 µs, 8 stopped readers p99", median(of[2].p99), "s"},
       {"8 slow readers over one fast, publish p50", median(slow_ratio), "", at_most(kGoalRatio)},
       {"8 stopped readers over one fast, publish p50", median(stopped_ratio), "",
        at_most(kGoalRatio)}});
}

void all_rows(const int& rounds, const Rows& all) {
  if (allowed_processors().size() < 2) {
    throw std::runtime_error(
        "bench ring: writer and reader each keep a processor busy, and this process may use only "
        "one; run it where two are free (see taskset -p $$)");
  }
  Rights rights;
  const Rows cases;
  bench_size<64>(rounds, rights, cases);
  bench_size<256>(rounds, rights, cases);
  bench_size<1024>(rounds, rights, cases);
  bench_size<8192>(rounds, rights, cases);
  bench_publish(rounds, rights, cases);
  Rows rows = all.machine("ring");
  rows.note("pinned", rights.pin_refused ? "no: refused, or a single processor"
                                         : "writer and readers, each side to one processor");
  rows.note("rights", rights.refused != 0
                          ? std::string("SCHED_FIFO or locked memory refused (") +
                                std::strerror(rights.refused) + "); " + kMendRealtime
                          : "SCHED_FIFO " + std::to_string(kFifo) + ", memory locked");
  rows.add("rounds", rounds);
  rows.append(cases.rows());
}

}  // namespace

/// Cost of the ring between two processes, each on its own processor at SCHED_FIFO if granted;
/// refused rights are reported in a row.
///
/// One way: from before the writer's copy to after the reader's, one message at a time, so that no
/// backlog is measured. Throughput: with credit, so that nothing is lost; the queue blocks instead.
/// Publish: a ServoFrame of objects that stand still into the servo's segment. Ring and queue
/// alternate within each round; a figure is the median over the rounds.
Measured bench_ring(Command& command) {
  const auto rounds = std::make_shared<int>(5);
  add_counts(command, {rounds_of(*rounds, "alternations; medians are reported")});
  return measured(all_rows, rounds);
}

}  // namespace haptic
