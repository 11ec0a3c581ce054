// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <memory>
#include <numeric>
#include <random>
#include <thread>

#include "clients/lab/support/forked_process.h"
#include "proto/os/realtime.h"
#include "tests/process/ring_torture.h"

namespace haptic::test {

inline constexpr size_t kFlatOutReaders = 8;

struct FlatOutFindings {
  uint64_t published = 0;
  uint64_t reads = 0, lost = 0, torn = 0, disorder = 0, vanished = 0, miscounted = 0;
  uint64_t stops = 0, kills = 0, crashes = 0;
  uint64_t faults() const { return torn + disorder + vanished + miscounted + crashes; }
};

/// A writer process that publishes without pause, and eight reader processes over its sealed
/// segment, mapped read-only: four that only read, one slow, one late, one that is stopped and
/// continued, one that is killed and replaced, both at random.
template <typename RingType>
class FlatOutTorture {
 public:
  /// Runs until that many items were read or the time is over, or with `stop_at_fault` at a fault.
  FlatOutFindings run(uint64_t wanted_reads, int64_t patience_ns, bool stop_at_fault = false) {
    const int64_t give_up = now_ns() + patience_ns;
    for (size_t i = 0; i < kFlatOutReaders; ++i) {
      if (i != kLate) readers_[i] = fork_reader(i);
    }
    ForkedProcess writer([this] { write(); });
    while (sum(&ReaderFindings::reads) < wanted_reads && now_ns() < give_up &&
           !(stop_at_fault && sum_findings().faults() > 0)) {
      disturb(sum(&ReaderFindings::reads) > wanted_reads / 10);
    }
    shared_->stop_writer = true;
    writer.wait();
    shared_->stop_readers = true;
    FlatOutFindings found = sum_findings();
    for (ForkedProcess& reader : readers_) {
      reader.signal(SIGCONT);
      found.crashes += reader.wait() != 0;
    }
    const uint64_t crashes = found.crashes;
    found = sum_findings();
    found.crashes = crashes;
    return found;
  }

 private:
  using Channels = TortureChannels<RingType>;
  using Item = typename RingType::Item;
  enum Role : size_t { kLagging = 4, kLate, kStopped, kKilled };
  static constexpr uint64_t kBatch = 64;
  struct Control {
    std::atomic<bool> stop_writer, stop_readers;
    std::array<ReaderFindings, kFlatOutReaders> findings;
  };

  void write() {
    pin_to_processor(0);
    RingType& ring = writer_->channels().records;
    for (uint64_t n = 0; !shared_->stop_writer.load(std::memory_order_relaxed); ++n) {
      ring.publish(Item::make(n));
    }
  }

  ForkedProcess fork_reader(size_t i) {
    return ForkedProcess([this, i] {
      pin_to_processor(1);
      FileDescriptor fd = reopen_read_only(writer_->fd());
      writer_.reset();  // unmaps the writable mapping in this process
      const SegmentView<Channels> view(std::move(fd));
      read(view.channels().records, i);
    });
  }

  void read(const RingType& ring, size_t i) {
    ReaderFindings& findings = shared_->findings[i];
    ReaderTally tally;
    Cursor cursor;
    // the first four readers were there before the first item
    if (i >= kLagging) cursor.next = ring.published();
    const uint64_t from = cursor.next;
    uint64_t got = 0, oldest_seen = 0;
    for (bool last_look = false; !last_look;) {
      last_look = shared_->stop_readers.load(std::memory_order_acquire);
      uint64_t batch = last_look ? ~uint64_t{0} : kBatch;
      uint64_t next = cursor.next;
      for (Item out; batch > 0 && read_next(ring, cursor, out); --batch, ++got) {
        tally.torn += !out.is_whole() || out.n + 1 != cursor.next;
        tally.disorder += out.n < next;
        next = out.n + 1;
        ++tally.reads;
      }
      oldest_seen = look_at_ends(ring, oldest_seen, tally);
      tally.hand_over(findings);
      if (i == kLagging) std::this_thread::sleep_for(std::chrono::microseconds(200));
    }
    findings.lost += cursor.lost;
    findings.miscounted += from + got + cursor.lost != ring.published();
  }

  /// The oldest item, whose slot is overwritten next, and the newest, which must exist. Returns the
  /// number of the oldest, so that it is not counted as read twice.
  static uint64_t look_at_ends(const RingType& ring, uint64_t oldest_seen, ReaderTally& tally) {
    Item out;
    const uint64_t oldest = ring.oldest(ring.published());
    if (ring.read(oldest, out)) {
      tally.torn += !out.is_whole() || out.n != oldest;
      tally.reads += out.n > oldest_seen;
      oldest_seen = out.n;
    }
    const uint64_t end = ring.published();
    if (end == 0) return oldest_seen;
    if (ring.read(end - 1, out)) {
      tally.torn += !out.is_whole() || out.n != end - 1;
    } else {
      // half a ring: far from being overwritten, even if the count is seen late
      const uint64_t now = ring.published();
      tally.vanished += end > std::midpoint(ring.oldest(now), now);
    }
    return oldest_seen;
  }

  /// A few milliseconds in which one reader is stopped and another killed.
  void disturb(bool is_late) {
    const auto pause = [this] {
      std::this_thread::sleep_for(std::chrono::microseconds(200 + random_() % 3000));
    };
    if (is_late && !late_is_there_) {
      readers_[kLate] = fork_reader(kLate);
      late_is_there_ = true;
    }
    readers_[kStopped].signal(SIGSTOP);
    pause();
    readers_[kStopped].signal(SIGCONT);
    ++stops_;
    pause();
    readers_[kKilled].kill();
    readers_[kKilled] = fork_reader(kKilled);
    ++kills_;
  }

  uint64_t sum(std::atomic<uint64_t> ReaderFindings::*count) const {
    uint64_t total = 0;
    for (const ReaderFindings& findings : shared_->findings) total += findings.*count;
    return total;
  }

  FlatOutFindings sum_findings() const {
    return {.published = writer_->channels().records.published(),
            .reads = sum(&ReaderFindings::reads),
            .lost = sum(&ReaderFindings::lost),
            .torn = sum(&ReaderFindings::torn),
            .disorder = sum(&ReaderFindings::disorder),
            .vanished = sum(&ReaderFindings::vanished),
            .miscounted = sum(&ReaderFindings::miscounted),
            .stops = stops_,
            .kills = kills_};
  }

  std::unique_ptr<SegmentWriter<Channels>> writer_ = std::make_unique<SegmentWriter<Channels>>(1);
  Shared<Control> shared_;
  std::array<ForkedProcess, kFlatOutReaders> readers_;
  std::mt19937_64 random_{17};
  uint64_t stops_ = 0, kills_ = 0;
  bool late_is_there_ = false;
};

}  // namespace haptic::test
