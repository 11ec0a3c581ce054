// SPDX-License-Identifier: GPL-3.0-or-later
#include "proto/ipc/ring.h"

#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <csignal>
#include <cstring>
#include <memory>
#include <new>
#include <random>
#include <thread>
#include <vector>

#include "clients/lab/support/forked_process.h"
#include "proto/ipc/ring_source.h"
#include "tests/support/frames.h"
#include "tests/support/self_describing.h"
#include "tests/support/torture_scale.h"

namespace haptic {
namespace {

using test::SelfDescribing;
using test::VaryingRecord;
using Record = SelfDescribing<32>;  // 256 bytes
// fewer words than its slots could hold
template <size_t kWords>
using Varying = PackedRing<VaryingRecord<kWords>, 16, 24 * kWords>;

template <auto kMember>
struct TypeOf;
template <typename Class, typename Member, Member Class::*kMember>
struct TypeOf<kMember> {
  using Type = Member;
};
template <auto kMember>
using RingOf = typename TypeOf<kMember>::Type;

/// How many values each part of a record has.
template <typename Item>
using Counts = std::array<uint32_t, kParts<Item>.size()>;

template <typename Item>
void set_counts(Item& item, const Counts<Item>& counts) {
  for (size_t k = 0; k < counts.size(); ++k) {
    std::memcpy(reinterpret_cast<std::byte*>(&item) + kParts<Item>[k].offset, &counts[k], 4);
  }
}

template <typename Item>
Counts<Item> random_counts(std::mt19937_64& random) {
  Counts<Item> counts;
  for (size_t k = 0; k < counts.size(); ++k) {
    counts[k] = static_cast<uint32_t>(random() % (std::min<size_t>(kParts<Item>[k].most, 20) + 1));
  }
  return counts;
}

/// A record of random words whose parts have these counts.
template <typename Item>
std::unique_ptr<Item> noisy(uint64_t seed, const Counts<Item>& counts) {
  std::mt19937_64 random(seed);
  std::vector<uint64_t> words(sizeof(Item) / 8);
  for (uint64_t& word : words) word = random() | 1;
  auto item = std::make_unique<Item>();
  std::memcpy(reinterpret_cast<std::byte*>(item.get()), words.data(), sizeof(Item));
  set_counts(*item, counts);
  return item;
}

/// `old`, over which what is in use of `item` was copied.
template <typename Item>
std::vector<std::byte> overwritten(const Item& old, const Item& item) {
  std::vector<std::byte> bytes(sizeof(Item));
  std::memcpy(bytes.data(), &old, sizeof(Item));
  Packing<Item>::for_each_run(item, [&](const std::byte* begin, size_t length) {
    const auto at = begin - reinterpret_cast<const std::byte*>(&item);
    std::copy_n(begin, length, bytes.begin() + at);
  });
  return bytes;
}

template <typename Item>
bool is_same(const Item& item, const std::vector<std::byte>& bytes) {
  return std::memcmp(&item, bytes.data(), sizeof(Item)) == 0;
}

// Places in a packed ring [words]: its counters, then ticket, begin and length of each slot
constexpr size_t kHeadWords = 16, kSlotWords = 4;

template <typename RingType>
constexpr size_t words_begin() {
  return sizeof(RingType) - (8 * RingType::kWords + 127) / 128 * 128;
}

template <typename RingType>
uint64_t word_at(const RingType& ring, size_t place) {
  uint64_t word;
  std::memcpy(&word, reinterpret_cast<const std::byte*>(&ring) + place, 8);
  return word;
}

template <typename RingType>
void copy_ring(const RingType& from, RingType& to) {
  std::memcpy(static_cast<void*>(&to), static_cast<const void*>(&from), sizeof to);
}

/// A ring in memory shared with a forked writer.
template <typename RingType>
class SharedRing {
 public:
  SharedRing()
      : ring_(new (mmap(nullptr, sizeof(RingType), PROT_READ | PROT_WRITE,
                        MAP_SHARED | MAP_ANONYMOUS, -1, 0)) RingType) {}
  ~SharedRing() { munmap(ring_, sizeof(RingType)); }
  SharedRing(const SharedRing&) = delete;
  RingType& operator*() const { return *ring_; }

 private:
  RingType* ring_;
};

/// Lets a forked writer publish without end and kills it with -9 after that time.
template <typename RingType>
void write_until_killed(RingType& ring, std::chrono::microseconds lifetime) {
  const pid_t pid = fork();
  REQUIRE(pid >= 0);
  if (pid == 0) {
    for (uint64_t n = 0;; ++n) ring.publish(RingType::Item::make(n));
  }
  while (ring.published() == 0) std::this_thread::yield();
  std::this_thread::sleep_for(lifetime);
  kill(pid, SIGKILL);
  waitpid(pid, nullptr, 0);
}

#ifdef __SANITIZE_THREAD__
std::atomic<int> thread_sanitizer_reports{0};

/// Types that Ring must reject.
template <typename T>
class Plain {
 public:
  static constexpr bool is_always_lock_free = true;
  Plain(T value = 0) : value_(value) {}
  void store(T value, std::memory_order) { value_ = value; }
  T load(std::memory_order) const { return value_; }

 private:
  T value_;
};
#endif

}  // namespace

TEST_CASE("ring: an empty ring has nothing to read") {
  const Ring<Record, 8> ring;
  Record out;
  Cursor cursor;
  CHECK(ring.published() == 0);
  CHECK_FALSE(ring.latest(out));
  CHECK_FALSE(ring.read(0, out));
  CHECK_FALSE(read_next(ring, cursor, out));
  CHECK(cursor.lost == 0);
}

TEMPLATE_TEST_CASE("ring: zeroed memory is an empty ring", "", (Ring<Record, 8>), Varying<32>) {
  const TestType ring;
  const std::vector<std::byte> zeros(sizeof ring);
  CHECK(std::memcmp(zeros.data(), static_cast<const void*>(&ring), sizeof ring) == 0);
}

TEST_CASE("ring: a reader that keeps up gets each item once and in order") {
  Ring<Record, 8> ring;
  Cursor cursor;
  Record out;
  for (uint64_t n = 0; n < 100; ++n) {
    ring.publish(Record::make(n));
    REQUIRE(read_next(ring, cursor, out));
    CHECK(out.n == n);
    CHECK(out.is_whole());
    CHECK_FALSE(read_next(ring, cursor, out));
    REQUIRE(ring.latest(out));
    CHECK(out.n == n);
  }
  CHECK(cursor.lost == 0);
}

TEMPLATE_TEST_CASE("ring: exactly as many of the newest items as fit can be read", "",
                   (Ring<Record, 8>), Varying<32>) {
  using Item = typename TestType::Item;
  TestType ring;
  const uint64_t published = GENERATE(1u, 2u, 3u, 7u, 8u, 9u, 16u, 17u, 1003u);
  for (uint64_t n = 0; n < published; ++n) ring.publish(Item::make(n));
  const uint64_t oldest = published - 1 - test::reach<TestType>(published - 1);
  CHECK(ring.oldest(published) == oldest);
  Item out;
  for (uint64_t n = 0; n < published + 8; ++n) {
    CAPTURE(published, n);
    REQUIRE(ring.read(n, out) == (n < published && n >= oldest));
    if (n < published && n >= oldest) CHECK((out.n == n && out.is_whole()));
  }
}

TEMPLATE_TEST_CASE("ring: of every length of every part a reader gets what is in use, no more", "",
                   (PackedRing<ServoFrame, 4, 2 * sizeof(ServoFrame)>),
                   (PackedRing<ContactSet, 4, 2 * sizeof(ContactSet)>),
                   (PackedRing<SceneFrame, 4, 2 * sizeof(SceneFrame)>),
                   (PackedRing<GivenFrame, 4, 2 * sizeof(GivenFrame)>),
                   (PackedRing<DrawnPiece, 4, 2 * sizeof(DrawnPiece)>), (Varying<32>)) {
  using Item = typename TestType::Item;
  std::mt19937_64 random(23);
  const auto ring = std::make_unique<TestType>();
  Counts<Item> counts{};
  const auto item = noisy<Item>(1, counts), out = noisy<Item>(2, counts);
  const auto fields = noisy<Item>(3, counts);
  uint64_t n = 0, wraps = 0, end = 0;
  const auto look = [&](bool is_sound) {
    set_counts(*item, counts);
    const auto expected = is_sound ? overwritten(*out, *item) : overwritten(*out, *out);
    const size_t words = test::bytes_in_use(*item).size() / 8;
    wraps += end % TestType::kWords + words > TestType::kWords;
    end += words;
    ring->publish(*item);
    CAPTURE(n, counts);
    REQUIRE(ring->read(n++, *out) == is_sound);
    REQUIRE(is_same(*out, expected));
    // who asks for the fields alone gets no list
    REQUIRE(ring->read(n - 1, *fields, Take::kFields));
    REQUIRE(std::memcmp(fields.get(), item.get(), Packing<Item>::kFixedBytes) == 0);
    REQUIRE(test::bytes_in_use(*fields).size() == 8 * Packing<Item>::kLeastWords);
  };
  for (size_t k = 0; k < counts.size(); ++k) {
    const auto most = static_cast<uint32_t>(kParts<Item>[k].most);
    // alone, and beside others
    for (uint32_t count = 0; count <= most; ++count) {
      counts = count % 2 == 0 ? Counts<Item>{} : random_counts<Item>(random);
      counts[k] = count;
      look(true);
    }
    // what a sound part cannot have
    for (const uint32_t count : {most + 1, 1000u * most, ~0u}) {
      counts[k] = count;
      look(false);
    }
    counts[k] = 0;
    look(true);
  }
  for (size_t k = 0; k < counts.size(); ++k) {
    counts[k] = static_cast<uint32_t>(kParts<Item>[k].most);
  }
  for (int i = 0; i < 9; ++i) look(true);
  CHECK(wraps > 4);
}

TEST_CASE("ring: those of the channels hold for as long as channels.h says") {
  const auto fits = []<typename RingType>(const RingType&, const auto& item) {
    const auto ring = std::make_unique<RingType>();
    for (int n = 0; n < 10'000; ++n) ring->publish(item);
    // what a ring of whole records took
    CHECK(sizeof *ring < RingType::kCapacity * (sizeof item + 8));
    return ring->published() - ring->oldest(ring->published());
  };
  const auto servo = std::make_unique<RingOf<&ServoChannels::frames>>();
  const auto frame = std::make_unique<ServoFrame>();
  for (const size_t pushed : {0, 7, 64}) {
    frame->pushes.resize(pushed);
    CHECK(fits(*servo, *frame) >= (pushed <= 7 ? 4000u : 900u));
  }
  const auto contact = std::make_unique<RingOf<&ContactChannels::sets>>();
  const auto set = std::make_unique<ContactSet>();
  set->objects.resize(1);
  for (const size_t touching : {0, 7, 64}) {
    set->contacts.resize(touching);
    CHECK(fits(*contact, *set) >= (touching <= 7 ? 4000u : 1000u));
  }
  const auto sim = std::make_unique<RingOf<&SimChannels::frames>>();
  const auto scene = std::make_unique<SceneFrame>();
  for (const size_t objects : {20, 256}) {
    scene->objects.resize(objects);
    CHECK(fits(*sim, *scene) >= (objects <= 20 ? 2000u : 170u));
  }
  scene->objects.resize(4);
  scene->responses.resize(4);
  scene->seen.resize(4);
  CHECK(fits(*sim, *scene) >= 2000u);
}

TEST_CASE(
    "ring: whatever lies in one of varying records, a reader stays in it and comes to an end") {
  std::mt19937_64 random(19);
  const auto ring = std::make_unique<Varying<32>>();
  std::vector<uint64_t> words(sizeof *ring / 8);
  uint64_t looks = 0;
  for (int round = 0; round < 2000; ++round) {
    // sometimes small numbers, so that some items look complete
    const uint64_t span = round % 2 == 0 ? ~uint64_t{0} : 12;
    for (uint64_t& word : words) word = random() % span;
    std::memcpy(static_cast<void*>(ring.get()), words.data(), sizeof *ring);
    Cursor living{random() % span, 0}, dead = living;
    const uint64_t before = looks;
    VaryingRecord<32> out{};
    while (read_next(*ring, living, out)) ++looks;
    while (read_final(*ring, dead, out)) ++looks;
    looks += ring->latest(out);
    ring->prefetch();
    ring->prefetch_newest();
    REQUIRE(looks <= before + 2 * ring->kCapacity + 1);
  }
  CHECK(looks > 0);
}

// 10^5 in a normal run; HAPTIC_TORTURE_SCALE=10 gives 10^6
TEMPLATE_TEST_CASE("ring: a slot with a wrong count, begin or length is refused or read in bounds",
                   "", (PackedRing<ServoFrame, 4, 2 * sizeof(ServoFrame)>),
                   (PackedRing<ContactSet, 4, 2 * sizeof(ContactSet)>),
                   (PackedRing<SceneFrame, 4, 2 * sizeof(SceneFrame)>),
                   (PackedRing<GivenFrame, 4, 2 * sizeof(GivenFrame)>),
                   (PackedRing<DrawnPiece, 4, 2 * sizeof(DrawnPiece)>), (Varying<32>)) {
  using Item = typename TestType::Item;
  std::mt19937_64 random(37);
  // alone, so that the address sanitizer knows where it ends
  const auto good = std::make_unique<TestType>(), ring = std::make_unique<TestType>();
  const auto out = std::make_unique<Item>(), before = std::make_unique<Item>();
  *out = {};
  uint64_t refused = 0, taken = 0;
  const auto rounds = static_cast<size_t>(10'000 * test::torture_scale());
  for (size_t round = 0; round < rounds; ++round) {
    const Counts<Item> counts = random_counts<Item>(random);
    const auto item = noisy<Item>(random(), counts);
    good->publish(*item);
    copy_ring(*good, *ring);
    const uint64_t n = good->published() - 1;
    const size_t slot = 8 * (kHeadWords + kSlotWords * (n % TestType::kCapacity));
    const uint64_t begin = word_at(*good, slot + 8), length = word_at(*good, slot + 16);
    const auto patch = [&](size_t at, uint64_t value) {
      std::memcpy(reinterpret_cast<std::byte*>(ring.get()) + at, &value, 8);
    };
    const uint64_t odd = round % 4 == 0 ? random() : random() % (sizeof(Item) / 8 + 8);
    // of the slot its begin and its length, of the words a few at random, where the counts are too
    const size_t kind = round % 6;
    if (kind == 0 || kind == 3) patch(slot + 8, odd);
    if (kind == 1 || kind == 3) patch(slot + 16, odd);
    for (size_t k = 0; kind >= 2 && kind < 5 && k < 1 + random() % 16; ++k) {
      patch(words_begin<TestType>() + 8 * (random() % TestType::kWords), random() >> random() % 64);
    }
    // or the count of one part alone
    const size_t part = random() % counts.size();
    const auto count = static_cast<uint32_t>(round % 4 == 0 ? random() : random() % 24);
    if (kind == 5) {
      size_t at = begin + Packing<Item>::kFixedBytes / 8;
      for (size_t k = 0; k < part; ++k) at += 1 + counts[k] * kParts<Item>[k].element / 8;
      const size_t place = words_begin<TestType>() + 8 * (at % TestType::kWords);
      patch(place, (word_at(*good, place) >> 32 << 32) | count);
    }
    std::memcpy(static_cast<void*>(before.get()), out.get(), sizeof(Item));
    const bool got = ring->read(n, *out);
    got ? ++taken : ++refused;
    // one that gets nothing keeps its old item, and one that gets some what is not in use
    REQUIRE(is_same(*out, got ? overwritten(*before, *out) : overwritten(*before, *before)));
    // a length that the counts do not make is no writer of ours
    if (kind == 1) REQUIRE(got == (odd == length));
    if (kind == 5) REQUIRE(got == (count == counts[part]));
    if (got && (kind == 1 || kind == 5)) REQUIRE(is_same(*out, overwritten(*before, *item)));
    ring->prefetch();
    ring->prefetch_newest();
    typename TestType::Item other{};
    ring->latest(other);
  }
  CHECK(refused > rounds / 100);
  CHECK(taken > rounds / 100);
}

TEST_CASE("ring: a lapped reader counts exactly what it lost") {
  std::mt19937_64 random(7);
  Ring<Record, 16> ring;
  Cursor cursor;
  uint64_t published = 0, got = 0, expected_next = 0;
  for (int round = 0; round < 2000; ++round) {
    for (uint64_t burst = random() % 40; burst > 0; --burst)
      ring.publish(Record::make(published++));
    Record out;
    for (uint64_t reads = random() % 20; reads > 0 && read_next(ring, cursor, out); --reads) {
      REQUIRE(out.is_whole());
      REQUIRE(out.n >= expected_next);
      expected_next = out.n + 1;
      ++got;
      // everything before this item was delivered or counted
      REQUIRE(got + cursor.lost == expected_next);
    }
  }
  Record out;
  while (read_next(ring, cursor, out)) ++got;
  CHECK(got + cursor.lost == published);
  CHECK(cursor.lost > 0);
}

// short, so that the writer is always close behind the reader
TEMPLATE_TEST_CASE(
    "ring: readers beside a hammering writer see no torn item and lose none uncounted", "",
    (Ring<Record, 4>), (PackedRing<VaryingRecord<32>, 8, 640>)) {
  using Item = typename TestType::Item;
  TestType ring;
  constexpr uint64_t kItems = 200'000;
  std::atomic<bool> done{false};
  struct Result {
    uint64_t got = 0, torn = 0, disorder = 0, lost = 0;
  };
  std::vector<Result> results(3);
  std::vector<std::thread> readers;
  readers.reserve(results.size());
  for (Result& result : results) {
    readers.emplace_back([&ring, &done, &result] {
      Cursor cursor;
      Item out;
      uint64_t next = 0;
      for (;;) {
        const bool last_look = done.load(std::memory_order_acquire);
        while (read_next(ring, cursor, out)) {
          ++result.got;
          result.torn += !out.is_whole();
          result.disorder += out.n < next;
          next = out.n + 1;
        }
        // the oldest item, whose slot is overwritten next
        const uint64_t oldest = ring.oldest(ring.published());
        if (ring.read(oldest, out)) result.torn += !out.is_whole() || out.n != oldest;
        if (last_look) break;
      }
      result.lost = cursor.lost;
    });
  }
  for (uint64_t n = 0; n < kItems; ++n) ring.publish(Item::make(n));
  done.store(true, std::memory_order_release);
  for (std::thread& reader : readers) reader.join();
  for (const Result& result : results) {
    CHECK(result.torn == 0);
    CHECK(result.disorder == 0);
    CHECK(result.got + result.lost == kItems);
  }
}

TEST_CASE("ring: without its tickets the same hammering does tear items") {
  // negative control: shows that the payload and the load above can reveal a torn read
  std::array<std::atomic<uint64_t>, 32> slot{};
  std::atomic<bool> done{false};
  std::thread writer([&] {
    for (uint64_t n = 0; !done.load(std::memory_order_relaxed); ++n) {
      const auto words = std::bit_cast<std::array<uint64_t, 32>>(Record::make(n));
      for (size_t i = 0; i < 32; ++i) slot[i].store(words[i], std::memory_order_release);
    }
  });
  bool torn = false;
  const auto give_up = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (!torn && std::chrono::steady_clock::now() < give_up) {
    std::array<uint64_t, 32> words;
    for (size_t i = 0; i < 32; ++i) words[i] = slot[i].load(std::memory_order_acquire);
    const auto record = std::bit_cast<Record>(words);
    torn = words[31] != 0 && !record.is_whole();
  }
  done.store(true, std::memory_order_relaxed);
  writer.join();
  CHECK(torn);
}

#ifdef __SANITIZE_THREAD__
}  // namespace haptic

// called by the sanitizer's runtime
extern "C" void __tsan_on_report(void*) {
  ++haptic::thread_sanitizer_reports;
}

namespace haptic {

TEST_CASE("ring: one of plain words is reported by the thread sanitizer") {
  // negative control, in a separate process: a report would fail this one
  ForkedProcess racing([] {
    Ring<Record, 8, Plain> ring;
    std::thread writer([&] {
      for (uint64_t n = 0; n < 10'000; ++n) ring.publish(Record::make(n));
    });
    Record out;
    for (int i = 0; i < 10'000; ++i) ring.latest(out);
    writer.join();
    _exit(thread_sanitizer_reports > 0 ? 3 : 0);
  });
  const int status = racing.wait();
  CHECK(WIFEXITED(status));
  CHECK(WEXITSTATUS(status) == 3);
}
#endif

TEMPLATE_TEST_CASE("ring: after kill -9 of the writer every counted item but the oldest is whole",
                   "", (Ring<SelfDescribing<8>, 16>), (Ring<SelfDescribing<128>, 16>),
                   Varying<128>) {
  std::mt19937_64 random(11);
  for (int round = 0; round < 60; ++round) {
    SharedRing<TestType> shared;
    write_until_killed(*shared, std::chrono::microseconds(random() % 300));
    const TestType& ring = *shared;
    const uint64_t end = ring.published();
    typename TestType::Item out;
    CAPTURE(round, end);
    REQUIRE(end > 0);
    REQUIRE(end - ring.oldest(end) >= test::reach<TestType>(end));
    // an item that was never counted may have half overwritten the slot of the oldest
    for (uint64_t n = std::max(ring.oldest(end), end - std::min<uint64_t>(end, 15)); n < end; ++n) {
      REQUIRE(ring.read(n, out));
      REQUIRE(out.is_whole());
      REQUIRE(out.n == n);
    }
    // killed between the ticket and the count: complete, but not announced
    if (ring.read(end, out)) CHECK(out.is_whole());
    REQUIRE(ring.latest(out));
    CHECK(out.n == end - 1);
  }
}

TEMPLATE_TEST_CASE("ring: what a killed writer left behind is drained with an exact count", "",
                   (Ring<Record, 16>), Varying<32>) {
  std::mt19937_64 random(13);
  uint64_t most_lost_of_the_last_ring = 0;
  for (int round = 0; round < 60; ++round) {
    SharedRing<TestType> shared;
    write_until_killed(*shared, std::chrono::microseconds(random() % 300));
    const uint64_t end = (*shared).published();
    Cursor cursor{random() % (end + 1), 0};
    const uint64_t from = cursor.next;
    uint64_t got = 0, last = 0;
    for (typename TestType::Item out; read_final(*shared, cursor, out); ++got) {
      REQUIRE(out.is_whole());
      last = out.n;
    }
    CAPTURE(round, from, end);
    CHECK(from + got + cursor.lost == end);
    if (got > 0) CHECK(last == end - 1);
    const uint64_t out_of_reach = std::max((*shared).oldest(end), from) - from;
    most_lost_of_the_last_ring = std::max(most_lost_of_the_last_ring, cursor.lost - out_of_reach);
  }
  CHECK(most_lost_of_the_last_ring <= 1);
}

}  // namespace haptic
