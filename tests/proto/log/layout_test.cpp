// SPDX-License-Identifier: GPL-3.0-or-later
// Records of another layout, by schemas written here by hand. What they mean is laid out here byte
// by byte, as CDR says: every number at a multiple of its own size.
#include "proto/log/layout.h"

#include <algorithm>
#include <array>
#include <bit>
#include <catch2/catch.hpp>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <random>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "proto/log/trace.h"
#include "tests/proto/log/mcap_bytes.h"
#include "tests/support/frames.h"
#include "tests/support/hostile_text.h"
#include "tests/support/temporary_folder.h"

namespace haptic {
namespace {

using test::McapBytes;

const std::string kVector =
    "================\nMSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n";

/// The content of `bytes`, laid out as `stored`, as a record of `ours`.
std::vector<std::byte> translated(const std::string& schema, const std::string& ours,
                                  const std::string& stored, const McapBytes& bytes) {
  const Fields theirs = flatten_definition(stored);
  std::vector<std::byte> record, out;
  REQUIRE(
      unpack_message(std::as_bytes(std::span(bytes.bytes())), theirs.parts, theirs.bytes, record));
  apply(translate(schema, flatten(ours), theirs), record.data(), out);
  return out;
}

/// Noise, and parts that are empty, full, or anything between.
template <typename T>
T filled(std::mt19937_64& random, int round) {
  std::array<uint64_t, sizeof(T) / 8> words;
  for (uint64_t& word : words) word = random();
  for (const RecordPart& part : kParts<T>) {
    const uint64_t most = round % 4 == 2 ? std::min<size_t>(part.most, 3) : part.most;
    words[part.offset / 8] = round % 4 < 2 ? round % 4 * most : random() % (most + 1);
  }
  return std::bit_cast<T>(words);
}

template <typename T>
std::vector<std::byte> in_use(const T& record) {
  if constexpr (!kParts<T>.empty()) return test::bytes_in_use(record);
  const auto bytes = std::as_bytes(std::span(&record, 1));
  return {bytes.begin(), bytes.end()};
}

template <typename T>
T number_at(const std::vector<std::byte>& record, size_t at) {
  T value{};
  REQUIRE(at + sizeof value <= record.size());
  std::memcpy(&value, &record[at], sizeof value);
  return value;
}

std::string refusal(const std::string& ours, const std::string& stored) {
  return test::refusal([&] { translate("x/msg/Any", flatten(ours), flatten_definition(stored)); });
}

}  // namespace

TEST_CASE("layout: fields are found by their names, whatever their order, and the rest left out") {
  McapBytes record;
  record.number(uint32_t{7}).number(uint32_t{0}).number(1.5).number(uint8_t{9});
  record.raw(std::string(7, '\0')).number(int64_t{-3});
  const auto out =
      translated("x/msg/Any", "int64 t_ns\nuint32 Flags # of it\nfloat64 depth\n",
                 "uint32 flags\nfloat64 depth # [m]\nuint8 gone\nint64 t_ns\n", record);
  CHECK(number_at<int64_t>(out, 0) == -3);
  CHECK(number_at<uint32_t>(out, 8) == 7);
  CHECK(number_at<double>(out, 16) == 1.5);
}

TEST_CASE("layout: one value becomes each element, of arrays the common part is copied") {
  McapBytes record;
  record.number(1.0).number(2.0).number(3.0);
  const auto longer = translated("x/msg/Any", "float64[5] k\n", "float64[3] k\n", record);
  for (size_t i = 0; i < 5; ++i)
    CHECK(number_at<double>(longer, 8 * i) == (i < 3 ? static_cast<double>(i + 1) : 0));
  const auto shorter = translated("x/msg/Any", "float64[2] k\n", "float64[3] k\n", record);
  CHECK(shorter.size() == 16);
  CHECK(number_at<double>(shorter, 8) == 2);
  const auto filled = translated("x/msg/Any", "geometry_msgs/Vector3[4] p\n",
                                 "geometry_msgs/Vector3 p\n" + kVector, record);
  for (size_t i = 0; i < 12; ++i)
    CHECK(number_at<double>(filled, 8 * i) == static_cast<double>(i % 3 + 1));
}

TEST_CASE("layout: of a sequence as much as both have room for is copied") {
  McapBytes record;
  record.number(uint64_t{7}).number(uint32_t{2}).number(uint32_t{0}).number(1.0).number(2.0);
  const std::string n = "uint64 n\n";
  for (const size_t most : {1, 2, 5}) {
    const std::string ours = n + "float64[<=" + std::to_string(most) + "] k\n";
    const auto out = translated("x/msg/Any", ours, n + "float64[<=3] k\n", record);
    CHECK(out.size() == 16 + 8 * most);
    CHECK(number_at<uint32_t>(out, 8) == std::min<size_t>(most, 2));
    CHECK(number_at<double>(out, 16) == 1);
    if (most > 1) CHECK(number_at<double>(out, 24) == 2);
  }
}

TEST_CASE("layout: a message holds what is in use of a record, as CDR says") {
  const Fields fields = flatten("uint64 n\nfloat64[<=3] a\nuint64[<=2] b\nfloat64[<=1] c\n");
  REQUIRE(fields.bytes == 8 + 32 + 24 + 16);
  for (uint32_t n_a = 0; n_a <= 4; ++n_a) {
    for (uint32_t n_b = 0; n_b <= 2; ++n_b) {
      McapBytes record, message;
      // what is not in use is noise, which stays behind; a number too high counts as the most
      record.number(uint64_t{7}).number(n_a).number(0u).number(1.5).number(2.5).number(3.5);
      record.number(n_b).number(0u).number(uint64_t{4}).number(uint64_t{5});
      record.number(uint64_t{0}).number(9.5);
      const uint32_t used = std::min(n_a, 3u);
      message.number(uint64_t{7}).number(used);
      if (used > 0) message.number(0u);
      for (uint32_t i = 0; i < used; ++i) message.number(1.5 + i);
      message.number(n_b);
      // behind a number that stands at a multiple of eight
      if (n_b > 0 && used > 0) message.number(0u);
      for (uint32_t i = 0; i < n_b; ++i) message.number(uint64_t{4} + i);
      message.number(0u);
      std::vector<std::byte> packed, out;
      pack_message(std::as_bytes(std::span(record.bytes())), fields.parts, packed);
      CAPTURE(n_a, n_b);
      CHECK(std::ranges::equal(packed, std::as_bytes(std::span(message.bytes()))));
      REQUIRE(unpack_message(packed, fields.parts, fields.bytes, out));
      CHECK(number_at<uint32_t>(out, 8) == used);
      for (size_t i = 0; i < used; ++i) {
        CHECK(number_at<double>(out, 16 + 8 * i) == 1.5 + static_cast<double>(i));
      }
      CHECK(number_at<uint32_t>(out, 40) == n_b);
      for (size_t i = 0; i < n_b; ++i) CHECK(number_at<uint64_t>(out, 48 + 8 * i) == 4 + i);
      CHECK(number_at<uint64_t>(out, 64) == 0);
    }
  }
}

TEMPLATE_TEST_CASE("layout: a record is packed and unpacked, whatever is in its parts", "",
                   ServoFrame, ContactSet, SceneFrame, ControlFrame) {
  const Fields fields = flatten(Schema<TestType>::text);
  std::mt19937_64 random(5);
  std::vector<std::byte> message, out, again;
  for (int round = 0; round < 200; ++round) {
    const TestType record = filled<TestType>(random, round);
    message.clear();
    pack_message(std::as_bytes(std::span(&record, 1)), kParts<TestType>, message);
    CAPTURE(round, message.size());
    REQUIRE(unpack_message(message, fields.parts, fields.bytes, out));
    CHECK(in_use(*reinterpret_cast<const TestType*>(out.data())) == in_use(record));
    // cut anywhere, or too long; alone in memory, so that the sanitizer knows where it ends
    const size_t step = message.size() < 4000 ? 1 : 1 + random() % 2000;
    for (size_t length = 0; length < message.size(); length += step) {
      const std::vector<std::byte> cut(message.begin(),
                                       message.begin() + static_cast<std::ptrdiff_t>(length));
      REQUIRE_FALSE(unpack_message(cut, fields.parts, fields.bytes, out));
    }
    std::vector<std::byte> longer = message;
    longer.push_back({});
    REQUIRE_FALSE(unpack_message(longer, fields.parts, fields.bytes, out));
    // a few bytes and numbers changed: refused, or a record as long
    for (int change = 0; change < 50; ++change) {
      std::vector<std::byte> changed = message;
      for (size_t k = 0; k <= random() % 4; ++k) {
        changed[random() % changed.size()] = static_cast<std::byte>(random() >> random() % 64);
      }
      if (!unpack_message(changed, fields.parts, fields.bytes, out)) continue;
      again.clear();
      pack_message(out, kParts<TestType>, again);
      REQUIRE(again.size() == changed.size());
    }
  }
}

TEST_CASE("layout: comments and the names of types mean nothing") {
  std::string stored = full_definition(Schema<ContactSet>::text);
  for (size_t at = 0; (at = stored.find(" # ", at)) != std::string::npos; at += 3) {
    stored.replace(at, 3, " # once ");
  }
  const Fields ours = flatten(Schema<ContactSet>::text), theirs = flatten_definition(stored);
  const Translation same = translate(Schema<ContactSet>::name, ours, theirs);
  CHECK(same.lacking.empty());
  CHECK(theirs.bytes == sizeof(ContactSet));
  // all but the four bytes behind the number of values of each part
  REQUIRE(same.copies.size() == 1 + ours.parts.size());
  size_t left_out = sizeof(ContactSet);
  for (const Translation::Copy& copy : same.copies) {
    CHECK(copy.from == copy.to);
    left_out -= copy.size;
  }
  CHECK(left_out == 4 * ours.parts.size());
}

TEST_CASE("layout: no two fields of a struct differ by capital letters alone") {
  for (const TopicInfo& topic : kTopics) {
    std::set<std::string> names;
    for (const Field& field : flatten(topic.text)) {
      CHECK(names.insert(lower_case(field.name)).second);
    }
  }
}

TEST_CASE("layout: a field that is missing or of another type is named") {
  CHECK(refusal("float64 depth\n", "int64 depth\n") ==
        "'depth' is a int64 there and a float64 here");
  CHECK(refusal("uint64 n\n", "uint32 n\n") == "'n' is a uint32 there and a uint64 here");
  CHECK(refusal("float64[2] k\n", "uint32 k\n") == "'k[0]' is a uint32 there and a float64 here");
  CHECK(refusal("float64 depth\nfloat64 F\n", "float64 depth\n") ==
        "it lacks 'F', which has no default");
  // a vector is no number, nor the other way round
  CHECK(refusal("float64 p\n", "geometry_msgs/Vector3 p\n" + kVector) ==
        "it lacks 'p', which has no default");
  CHECK(refusal("geometry_msgs/Vector3 p\n", "float64 p\n") ==
        "it lacks 'p.x', which has no default");
}

TEST_CASE("layout: a schema that describes no record is refused") {
  const std::string chain = [] {
    std::string text = "p/A0 a\n";
    for (int i = 0; i < 20; ++i) {
      text += "====\nMSG: p/A" + std::to_string(i) + "\np/A" + std::to_string(i + 1) + " a\n";
    }
    return text + "====\nMSG: p/A20\nfloat64 a\n";
  }();
  // 10^12 messages without a number in them
  const std::string wide =
      "p/A[10000] a\n====\nMSG: p/A\np/B[10000] b\n====\nMSG: p/B\np/C[10000] c\n====\nMSG: p/C\n";
  const std::string sparse = "p/A[16000] a\n====\nMSG: p/A\n" + std::string(50'000, '\n');
  std::string types = "float64 f\n";
  for (int i = 0; i < 70; ++i) types += "====\nMSG: p/A" + std::to_string(i) + "\nfloat64 f\n";
  const std::vector<std::pair<std::string, std::string>> all{
      {"p/A a\n====\nMSG: p/A\np/A a\n", "nests types too deep"},
      {chain, "nests types too deep"},
      {wide, "nests types too deep or too often"},
      {"float64[16384] k\nfloat64 l\n", "more than 16384 numbers"},
      {types, "more than 64 types"},
      {"float64 f #" + std::string(70'000, '#') + "\n", "more than 64 KiB"},
      {"float64[] k\n", "only arrays and sequences of up to 16384"},
      {"float64[4 k\n", "only arrays and sequences of up to 16384"},
      {"float64[0] k\n", "only arrays and sequences of up to 16384"},
      {"float64[-1] k\n", "no field"},
      {"float64[18446744073709551617] k\n", "only arrays and sequences of up to 16384"},
      {"float64[99999999999999999999999999999999999] k\n",
       "only arrays and sequences of up to 16384"},
      {"float64[4][4] k\n", "only arrays and sequences of up to 16384"},
      {"float64] k\n", "lacks the definition of a type"},
      {"string name\n", "lacks the definition of a type"},
      {"p/Nothing a\n", "lacks the definition of a type"},
      {"float64\n", "no field"},
      {"float64 a b\n", "no field"},
      {"float64 a=1\n", "no field"},
      {"float64 \x1b[2J\n", "no field"},
      {"float64 " + std::string(65, 'a') + "\n", "no field"},
      {"float64 f\n====\nMSG: p/A\n====\nMSG: p/A\n", "defines a type twice"},
      {"float64 f\nfloat64 f\n", "has 'f' twice"},
      {"float64 b\nfloat64 B\n", "has 'B' twice"},
      {"float64[2] f\n" + std::string("f"), "no field"}};
  for (const auto& [stored, says] : all) {
    CAPTURE(stored.substr(0, 80));
    CHECK_THAT(refusal("float64 f\n", stored), Catch::Contains(says));
  }
  // text that is read for each element is read without what means nothing
  CHECK(refusal("float64 f\n", sparse + "float64 f\n") == "it lacks 'f', which has no default");
  CHECK(refusal("float64 f\n", "") == "it lacks 'f', which has no default");
}

TEST_CASE("layout: a sequence is of whole words, has a bound, and is behind all fields") {
  const std::vector<std::pair<std::string, std::string>> all{
      {"float64[<=] k\n", "only arrays and sequences of up to 16384"},
      {"float64[<=0] k\n", "only arrays and sequences of up to 16384"},
      {"float64[<=16385] k\n", "only arrays and sequences of up to 16384"},
      {"float64[=4] k\n", "only arrays and sequences of up to 16384"},
      {"float64[<=8000] k\nfloat64[<=9000] l\n", "more than 16384 numbers"},
      {"float64[<=2] k\nfloat64 f\n", "a field behind a sequence"},
      {"p/A a\n====\nMSG: p/A\nfloat64[<=2] k\n", "a sequence in another type"},
      {"p/A[<=2] a\n====\nMSG: p/A\nfloat64[<=2] k\n", "a sequence in another type"},
      {"uint32[<=4] k\n", "a sequence of values that are not whole words"},
      {"uint8[<=8] k\n", "a sequence of values that are not whole words"},
      {"p/A[<=4] a\n====\nMSG: p/A\nfloat64 f\nuint32 n\n", "that are not whole words"},
      {"p/A[<=4] a\n====\nMSG: p/A\nuint32 m\nuint32 n\n", "that are not whole words"},
      {"p/A[<=4] a\n====\nMSG: p/A\n", "that are not whole words"},
      {"uint32 a\nfloat64[<=2] k\n", "a sequence that begins within a word"},
      {"uint64 n_k\nfloat64[<=2] k\n", "has 'n_k' twice"}};
  for (const auto& [stored, says] : all) {
    CAPTURE(stored);
    CHECK_THAT(refusal("float64 f\n", stored), Catch::Contains(says));
  }
}

TEST_CASE("layout: a record is as long as its own definition says, or refused") {
  const test::TemporaryFolder folder;
  const std::string path = folder.path() + "/events.mcap";
  const auto events = [&](size_t bytes) {
    McapBytes schema, channel, packed;
    schema.number(uint16_t{1}).text("haptic_msgs/msg/Event").text("ros2msg");
    schema.text("float64 more\nint64 t_ns\nuint32 code\nuint32 source\nfloat64[5] numbers\n");
    channel.number(uint16_t{1}).number(uint16_t{1}).text("/events").text("cdr");
    channel.number(uint32_t{0});
    McapBytes record;
    record.raw(std::string_view("\0\1\0\0", 4)).number(0.5).number(int64_t{7}).number(uint32_t{2});
    std::string payload = record.bytes();
    payload.resize(4 + bytes);
    packed.record(0x05, test::message(payload));
    McapBytes file;
    file.raw(test::kMcapMagic).record(0x03, schema).record(0x04, channel);
    file.record(0x06, test::chunk(packed.size(), "", packed.bytes()));
    std::ofstream(path, std::ios::binary) << file.bytes();
    return TraceReader(path).read(kEventTopic);
  };
  const std::vector<Event> read = events(sizeof(Event) + 8);
  REQUIRE(read.size() == 1);
  CHECK(read[0].t_ns == 7);
  CHECK(read[0].code == 2);
  for (const size_t wrong : {size_t{0}, sizeof(Event), sizeof(Event) + 7, sizeof(Event) + 9}) {
    CHECK_THROWS_WITH(events(wrong), Catch::Contains("that is not its struct"));
  }
}

}  // namespace haptic
