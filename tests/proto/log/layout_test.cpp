// SPDX-License-Identifier: GPL-3.0-or-later
// Records of another layout, by schemas written here by hand. What they mean is laid out here byte
// by byte, as CDR says: every number at a multiple of its own size.
#include "proto/log/layout.h"

#include <catch2/catch.hpp>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <set>
#include <string>
#include <vector>

#include "proto/log/trace.h"
#include "tests/proto/log/mcap_bytes.h"
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
  const Translation t = translate(schema, flatten(ours), stored);
  REQUIRE(t.stored_size == bytes.size());
  std::vector<std::byte> out;
  apply(t, reinterpret_cast<const std::byte*>(bytes.bytes().data()), out);
  return out;
}

template <typename T>
T number_at(const std::vector<std::byte>& record, size_t at) {
  T value{};
  REQUIRE(at + sizeof value <= record.size());
  std::memcpy(&value, &record[at], sizeof value);
  return value;
}

std::string refusal(const std::string& ours, const std::string& stored) {
  return test::refusal([&] { translate("x/msg/Any", flatten(ours), stored); });
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

TEST_CASE("layout: comments and the names of types mean nothing") {
  std::string stored = full_definition(Schema<ContactSet>::text);
  for (size_t at = 0; (at = stored.find(" # ", at)) != std::string::npos; at += 3) {
    stored.replace(at, 3, " # once ");
  }
  const std::vector<Field> ours = flatten(Schema<ContactSet>::text);
  const Translation same = translate(Schema<ContactSet>::name, ours, stored);
  CHECK(same.lacking.empty());
  CHECK(same.stored_size == sizeof(ContactSet));
  REQUIRE(same.copies.size() == 1);
  CHECK(same.copies[0].size == sizeof(ContactSet));
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
      {"float64[] k\n", "only arrays of a fixed size"},
      {"float64[<=4] k\n", "no field"},
      {"float64[4 k\n", "only arrays of a fixed size"},
      {"float64[0] k\n", "only arrays of a fixed size"},
      {"float64[-1] k\n", "no field"},
      {"float64[18446744073709551617] k\n", "only arrays of a fixed size"},
      {"float64[99999999999999999999999999999999999] k\n", "only arrays of a fixed size"},
      {"float64[4][4] k\n", "only arrays of a fixed size"},
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
