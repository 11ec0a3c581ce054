// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <array>
#include <memory>
#include <numeric>
#include <random>
#include <stdexcept>
#include <thread>
#include <vector>

#include "clients/lab/support/forked_process.h"
#include "proto/ipc/attachments.h"
#include "proto/ipc/handout_server.h"
#include "proto/ipc/sessions.h"
#include "proto/os/realtime.h"
#include "tests/process/ring_torture.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/torture_scale.h"

namespace haptic::test {

struct KillFindings {
  uint64_t seed = 0;  // of kill times and disturbances
  uint64_t kills = 0;
  uint64_t published = 0, reads = 0, lost = 0;
  uint64_t in_mid_copy = 0;  // kills that left a slot begun but not counted
  uint64_t unreadable = 0;   // counted, not the oldest, but not readable
  uint64_t torn = 0, disorder = 0, miscounted = 0;
  uint64_t balances = 0;  // readers whose items were compared with those published
  uint64_t reader_stops = 0, reader_kills = 0, crashes = 0;
  uint64_t faults() const { return unreadable + torn + disorder + miscounted + crashes; }
};

/// A series of writers, each killed with -9 at a random point of publishing without pause. The next
/// is one generation higher and reaches its readers as in a session: offered to a HandoutServer,
/// attached by Attachments. Of the four reader processes one only reads, one is slow, one is
/// stopped and continued, and one is killed and replaced, so that it starts late.
template <typename RingType>
class KillTorture {
 public:
  KillFindings run(uint64_t kills) {
    for (size_t i = 0; i < kReaders; ++i) readers_[i] = fork_reader(i);
    ends_.push_back(0);  // generations count from 1
    kill_at_random(fork_first_writer());
    while (found_.kills < kills) {
      disturb();
      kill_at_random(fork_writer());
    }
    readers_[kStopped].signal(SIGCONT);
    say_goodbye();
    balance();
    return found_;
  }

 private:
  using Channels = TortureChannels<RingType>;
  using Item = typename RingType::Item;
  enum Role : size_t { kSteady, kLagging, kStopped, kKilled, kReaders };
  /// Position of a reader; `first_*`: at its first item.
  struct Reader {
    std::atomic<uint64_t> generation, first_generation, first_n, first_lost, reads, lost;
    std::atomic<uint64_t> torn, disorder;
  };
  struct Control {
    std::atomic<bool> go;
    std::atomic<uint64_t> last_generation;  // 0: unknown
    std::array<Reader, kReaders> readers;
  };
  using View = SegmentView<Channels>;

  ForkedProcess fork_reader(size_t i) {
    Reader& reader = shared_->readers[i];
    // the findings of a killed reader are kept, its position is not
    reader.generation = reader.first_generation = reader.reads = 0;
    return ForkedProcess([this, i, &reader] { read(reader, i == kLagging); });
  }

  void read(Reader& reader, bool lags) {
    Attachments attachments(connect_session(kSession));
    auto records = attachments.template ring<&Channels::records>(Start::kOldest);
    attachments.start();
    uint64_t next = 0, reads = 0;
    // the last generation has a single item
    while (shared_->last_generation == 0 || reader.generation < shared_->last_generation) {
      Item out;
      if (!records.next(out)) {
        std::this_thread::sleep_for(std::chrono::microseconds(lags ? 3000 : 20));
        continue;
      }
      const uint64_t generation = records.item_generation();
      if (reads++ == 0) {
        reader.first_n = out.n;
        reader.first_lost = records.lost();
        reader.first_generation = generation;
      }
      if (generation != reader.generation) next = 0;
      reader.torn += !out.is_whole();
      reader.disorder += generation < reader.generation || out.n < next;
      next = out.n + 1;
      reader.lost = records.lost();
      reader.reads = reads;
      reader.generation = generation;
    }
  }

  /// Every reader must have an item of the first generation, from its beginning, before it goes on.
  ForkedProcess fork_first_writer() {
    ForkedProcess writer = fork_writer();
    const auto has_item = [](const Reader& r) { return r.reads > 0; };
    serve_until(
        [&] { return std::all_of(shared_->readers.begin(), shared_->readers.end(), has_item); });
    shared_->go = true;
    return writer;
  }

  ForkedProcess fork_writer() {
    view_.reset();
    const uint64_t generation = ends_.size();
    FileDescriptor socket = server_.connect_child(Channels::kId, generation);
    ForkedProcess writer([this, generation, fd = socket.get()] {
      SegmentWriter<Channels> segment(generation);
      RingType& ring = segment.channels().records;
      // complete before any reader looks: a broken ring would lose it, and the first writer
      // publishes no more until every reader has it
      ring.publish(Item::make(0));
      offer_segment(fd, Channels::kId, generation, Channels::kName, segment.fd());
      while (!shared_->go) std::this_thread::yield();
      for (uint64_t n = 1;; ++n) ring.publish(Item::make(n));
    });
    serve_until([&] { return view_ != nullptr; });
    return writer;
  }

  void kill_at_random(ForkedProcess writer) {
    const int64_t end = now_ns() + static_cast<int64_t>(random_() % 1'500'000);
    serve_until([&] { return now_ns() >= end; });
    writer.kill();
    ++found_.kills;
    look_at_remains(view_->channels().records);
  }

  void look_at_remains(const RingType& ring) {
    const uint64_t end = ring.published();
    ends_.push_back(end);
    found_.published += end;
    Item out;
    for (uint64_t n = ring.oldest(end); n < end; ++n) {
      const bool is_there = ring.read(n, out);
      if (is_there) found_.torn += !out.is_whole() || out.n != n;
      // an item that was never counted may have half overwritten the slot of the oldest
      const bool may_be_spoilt = end - n == RingType::kCapacity;
      found_.in_mid_copy += !is_there && may_be_spoilt;
      found_.unreadable += !is_there && !may_be_spoilt;
    }
  }

  void disturb() {
    if (random_() % 4 == 0) {
      is_stopped_ = !is_stopped_;
      readers_[kStopped].signal(is_stopped_ ? SIGSTOP : SIGCONT);
      found_.reader_stops += is_stopped_;
    }
    if (random_() % 8 == 0) {
      readers_[kKilled].kill();
      found_.reads += shared_->readers[kKilled].reads;
      readers_[kKilled] = fork_reader(kKilled);
      ++found_.reader_kills;
    }
  }

  /// A last generation with one item makes the previous ones final for all readers.
  void say_goodbye() {
    SegmentWriter<Channels> last(ends_.size());
    last.channels().records.publish(Item::make(0));
    server_.announce(Channels::kId, ends_.size(), Channels::kName, last.fd());
    ends_.push_back(1);
    const auto has_last = [this](const Reader& r) { return r.generation == ends_.size() - 1; };
    shared_->last_generation = ends_.size() - 1;
    serve_until(
        [&] { return std::all_of(shared_->readers.begin(), shared_->readers.end(), has_last); });
    for (ForkedProcess& reader : readers_) found_.crashes += reader.wait() != 0;
  }

  /// From its first item on, the items delivered to a reader plus those counted as lost must be all
  /// those published by all writers.
  void balance() {
    for (const Reader& reader : shared_->readers) {
      const auto from = ends_.begin() + static_cast<ptrdiff_t>(reader.first_generation.load());
      const uint64_t there = std::accumulate(from, ends_.end(), uint64_t{0}) - reader.first_n;
      const uint64_t lost = reader.lost - reader.first_lost;
      found_.miscounted += reader.reads + lost != there;
      ++found_.balances;
      found_.reads += reader.reads;
      found_.lost += lost;
      found_.torn += reader.torn;
      found_.disorder += reader.disorder;
    }
  }

  template <typename Condition>
  void serve_until(Condition holds) {
    const int64_t give_up = now_ns() + kPatienceNs;
    while (!holds()) {
      if (now_ns() > give_up) throw std::runtime_error("a writer or reader hangs");
      server_.serve([this](const Announcement&, int fd) {
        view_ = std::make_unique<View>(reopen_read_only(fd));
      });
      std::this_thread::sleep_for(std::chrono::microseconds(20));
    }
  }

  static constexpr const char* kSession = "torture";
  TemporaryRuntimeFolder folder_;
  HandoutServer server_{kSession};
  Shared<Control> shared_;
  std::array<ForkedProcess, kReaders> readers_;
  std::unique_ptr<View> view_;  // this process's own view, of the current generation
  std::vector<uint64_t> ends_;  // items published, by generation
  const uint64_t seed_ = std::random_device{}();
  std::mt19937_64 random_{seed_};
  bool is_stopped_ = false;
  KillFindings found_{.seed = seed_};
};

}  // namespace haptic::test
