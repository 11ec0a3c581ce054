// SPDX-License-Identifier: GPL-3.0-or-later
// Recordings (MCAP) that are damaged or malicious: refused in one line, or read within bounded time
// and memory.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <ostream>
#include <string>
#include <vector>

#include "clients/log/log_eyes.h"
#include "clients/log/trace_writer.h"
#include "proto/ipc/eye_file.h"
#include "proto/log/csv.h"
#include "proto/log/hand_trace.h"
#include "tests/fuzz/fuzz_run.h"
#include "tests/fuzz/hostile_input.h"
#include "tests/proto/log/mcap_bytes.h"
#include "tests/support/data.h"
#include "tests/support/temporary_folder.h"

namespace haptic {
namespace {

using test::FuzzRandom;
using test::McapBytes;

struct Record {
  uint8_t op = 0;
  std::string content;
};

constexpr uint8_t kFooter = 0x02, kSchema = 0x03, kMessage = 0x05, kChunk = 0x06;
constexpr uint8_t kDataEnd = 0x0F;

std::string bytes_of(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return std::string((std::istreambuf_iterator<char>(in)), {});
}

/// A file of the program: five topics, three chunks, metadata and an end.
std::string valid_file(const std::string& folder) {
  const std::string path = folder + "/seed.mcap";
  {
    const std::vector<std::byte> eye = write_eye({});
    // the same bytes on every machine
    TraceWriter trace(path, {{"session", "fuzz"}, {"config", "[session]\nname = \"fuzz\"\n"}});
    for (int i = 0; i < 12; ++i) {
      ServoFrame frame{};
      frame.tick = static_cast<uint64_t>(i);
      frame.t_ns = frame.device.t_ns = 1'000'000 * i;
      frame.device.flags = kDeviceFresh;
      const Stamp stamp{frame.t_ns, frame.t_ns, frame.tick};
      trace.write(servo_topic(kFirstHand), frame, stamp);
      if (i % 6 == 0) trace.write(contact_topic(kFirstHand), ContactSet{}, stamp);
      trace.write(kEventTopic, Event{}, stamp);
      if (i % 4 == 3) trace.flush();
      if (i == 5) trace.add_attachment("eye/tool", kEyeMediaType, 5, eye);
    }
  }
  return bytes_of(path);
}

template <typename T>
T number_at(const std::string& bytes, size_t at) {
  T value{};
  if (at + sizeof value <= bytes.size()) std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

/// Records between two places of a file.
std::vector<Record> records_of(const std::string& file, size_t begin, size_t end) {
  std::vector<Record> records;
  for (size_t at = begin; at + 9 <= end;) {
    const size_t length = number_at<uint64_t>(file, at + 1);
    records.push_back({static_cast<uint8_t>(file[at]), file.substr(at + 9, length)});
    at += 9 + length;
  }
  return records;
}

/// A message of a topic: a moving hand or noise, with lists of any length; some with an implausible
/// number.
std::string payload(const TopicInfo& topic, uint64_t tick, FuzzRandom& random) {
  std::vector<std::byte> record(topic.size), message;
  const size_t fields = topic.parts.empty() ? topic.size : topic.parts[0].offset;
  const bool is_hand = topic.name == servo_topic(kFirstHand).name;
  const bool is_noise = !is_hand && random.below(2) == 0;
  const auto make_noise = [&](size_t begin, size_t length) {
    for (size_t i = begin; is_noise && i < begin + length; ++i) {
      if (random.below(4) == 0) record[i] = static_cast<std::byte>(random.bits());
    }
  };
  if (is_hand) {
    ServoFrame frame{};
    frame.device.t_ns = static_cast<int64_t>(tick);
    frame.device.flags = kDeviceFresh;
    const std::vector<double> odd{NAN, INFINITY, -INFINITY, 1e308, 1e-320, 2};
    double* const numbers[] = {&frame.device.X_BH.p.x, &frame.device.X_BH.q.w,
                               &frame.device.V_BH.v.y, &frame.device.V_BH.w.z, &frame.device.grip};
    if (random.below(8) == 0) *numbers[random.below(5)] = random.pick(odd);
    std::memcpy(record.data(), &frame, fields);
  }
  make_noise(0, fields);
  for (const RecordPart& part : topic.parts) {
    const auto n = static_cast<uint32_t>(random.below(random.below(8) == 0 ? part.most + 1 : 3));
    std::memcpy(&record[part.offset], &n, sizeof n);
    make_noise(part.offset + kPartHeader, n * part.element);
  }
  pack_message(record, topic.parts, message);
  return std::string("\0\1\0\0", 4)
      .append(reinterpret_cast<const char*>(message.data()), message.size());
}

/// An uncompressed chunk of messages like those of the program.
std::string plain_chunk(const test::Damage& damage, FuzzRandom& random) {
  McapBytes inside;
  const uint64_t begin = random.below(1'000'000'000);
  for (uint64_t i = 0, n = random.below(6); i < n; ++i) {
    const size_t topic = random.below(kTopics.size());
    McapBytes content;
    content.number(static_cast<uint16_t>(topic + 1)).number(uint32_t{0}).number(i).number(i);
    const std::string bytes = payload(kTopics[topic], begin + i, random);
    inside.record(kMessage,
                  content.raw(random.below(8) != 0 ? bytes : damage.apply(bytes, random)));
  }
  return test::chunk(inside.size(), "", inside.bytes()).bytes();
}

/// A compression bomb: a small chunk that unpacks to a large one, or claims to.
std::string bomb(FuzzRandom& random) {
  const uint32_t blocks = 1u << random.below(13), each = 1u << random.below(18);
  const uint64_t size = uint64_t{blocks} * each;
  const uint64_t claims[] = {size, size + 1, 0, 1 << 20, uint64_t{1} << 62, ~uint64_t{0}};
  return test::chunk(claims[random.below(6)], "zstd",
                     test::repeating_frame(blocks, each, claims[random.below(6)]))
      .bytes();
}

/// A definition after a line was lost, doubled, moved, or given another type or count.
void change_definition(std::string& text, FuzzRandom& random) {
  static const std::vector<std::string> kTypes{"float64",
                                               "uint32",
                                               "int64",
                                               "uint8",
                                               "bool",
                                               "float64[3]",
                                               "float64[16384]",
                                               "float64[]",
                                               "float64[<=16384]",
                                               "haptic_msgs/Contact[64]",
                                               "haptic_msgs/Contact[<=64]",
                                               "geometry_msgs/Pose[1000]",
                                               "MSG:",
                                               "haptic_msgs/ContactSet"};
  const size_t begin = text.find('\n', random.below(text.size() + 1)) + 1;
  const size_t end = std::min(text.find('\n', begin), text.size() - 1) + 1;
  if (begin == 0 || begin >= end) return;
  const std::string line = text.substr(begin, end - begin);
  const size_t choice = random.below(4);
  if (choice < 3) text.erase(begin, end - begin);
  if (choice == 2) return;
  if (choice == 3) {
    const size_t type_end = std::min(text.find(' ', begin), end - 1);
    text.replace(begin, type_end - begin, random.pick(kTypes));
    return;
  }
  // elsewhere, or twice in a row
  const size_t at = choice == 0 ? text.find('\n', random.below(text.size() + 1)) + 1 : begin;
  text.insert(at, choice == 0 ? line : line + line);
}

/// Other definitions in a file without an end, which is read from its start: an index would point
/// beside the chunks.
void change_schemas(std::vector<Record>& records, const test::Damage& damage, FuzzRandom& random) {
  const auto end = std::find_if(records.begin(), records.end(),
                                [](const Record& record) { return record.op == kDataEnd; });
  records.erase(end, records.end());
  for (Record& record : records) {
    if (record.op != kSchema || random.below(3) == 0) continue;
    size_t at = sizeof(uint16_t);
    for (int texts = 0; texts < 2; ++texts) at += 4 + number_at<uint32_t>(record.content, at);
    if (at + 4 > record.content.size()) continue;
    std::string text = record.content.substr(at + 4);
    for (size_t left = 1 + random.below(3); left > 0; --left) change_definition(text, random);
    if (random.below(8) == 0) text = damage.apply(text, random);
    record.content.resize(at);
    record.content += McapBytes().text(text).bytes();
  }
}

void change_record(std::vector<Record>& records, const test::Damage& damage, FuzzRandom& random) {
  const size_t at = random.below(records.size());
  const auto place = records.begin() + static_cast<std::ptrdiff_t>(at);
  switch (random.below(7)) {
    case 0:
      records.erase(place);
      break;
    case 1:
      records.insert(place, random.pick(std::vector<Record>(records)));
      break;
    case 2:
      std::swap(records[at], records[random.below(records.size())]);
      break;
    case 3:
      records[at].content = damage.apply(records[at].content, random);
      break;
    case 4:
      records[at].op = static_cast<uint8_t>(random.below(17));
      break;
    default:
      records.insert(place,
                     {kChunk, random.below(2) == 0 ? bomb(random) : plain_chunk(damage, random)});
  }
}

/// Reassembles the file with correct lengths and a summary that can be found, if any.
std::string file_of(const std::vector<Record>& records, FuzzRandom& random) {
  McapBytes file;
  file.raw(test::kMcapMagic);
  uint64_t data_end = 0;
  for (const Record& record : records) {
    if (record.op == kFooter && random.below(4) != 0) {
      McapBytes footer;
      footer.number(data_end).number(uint64_t{0}).number(uint32_t{0});
      file.record(kFooter, footer);
    } else {
      file.record(record.op, McapBytes().raw(record.content));
    }
    if (record.op == kDataEnd) data_end = file.size();
  }
  return file.raw(test::kMcapMagic).bytes();
}

std::string log_input(const std::string& seed, const test::Damage& damage, FuzzRandom& random) {
  if (random.below(3) == 0) return damage.apply(seed, random, 1 << 20);
  const size_t magic = test::kMcapMagic.size();
  std::vector<Record> records = records_of(seed, magic, seed.size() - magic);
  if (random.below(3) == 0) {
    change_schemas(records, damage, random);
  } else {
    for (size_t left = 1 + random.below(4); left > 0 && !records.empty(); --left) {
      change_record(records, damage, random);
    }
  }
  const std::string file = file_of(records, random);
  return random.below(8) == 0 ? damage.apply(file, random, 1 << 20) : file;
}

/// Everything the program does with a recording.
void use(const std::string& path) {
  const TraceReader trace(path);
  std::ostream nowhere(nullptr);
  for (const TopicInfo& topic : trace.topics()) export_csv(trace, topic, nowhere);
  const LogEyes eyes = read_log_eyes(trace.mcap());
  for (const auto& [object, bytes] : eyes.objects) {
    if (object >= kMaxObjects) throw std::runtime_error("no such object:\n");
  }
  for (const McapAttachment& attachment : trace.mcap().attachments()) {
    try {
      trace.mcap().read_attachment(attachment);
    } catch (const McapError&) {
      // a damaged one does not spoil the others
    }
  }
  ReplayConfig config;
  assign(config.path, path);
  for (const DeviceState& s : load_hand_trace(config).samples) {
    const bool finite = is_finite(s.X_BH) && is_finite(s.V_BH) && std::isfinite(s.grip);
    if (!finite) throw std::runtime_error("a number is not finite:\n");
    const Quat& q = s.X_BH.q;
    const double length = std::hypot(std::hypot(q.x, q.y), std::hypot(q.z, q.w));
    if (std::abs(length - 1) > 1e-5) throw std::runtime_error("no unit quaternion:\n");
  }
}

}  // namespace

TEST_CASE("fuzz: a recording is refused in one line or read in bounded time and memory") {
  const test::TemporaryFolder folder;
  std::vector<std::string> seeds{valid_file(folder.path())};
  for (uint32_t layout = 1; layout < kAbiMajor; ++layout) {
    const std::string name = "tests/proto/log/golden/layout_" + std::to_string(layout) + ".mcap";
    seeds.push_back(bytes_of(test::from_source(name)));
    REQUIRE_FALSE(seeds.back().empty());
  }
  const test::Damage damage({"zstd", "lz4", "", "/servo0/frame", "cdr", "ros2msg", "eye/0",
                             std::string(test::kMcapMagic), std::string(9, '\0'), "\n\x1b[2J"});
  const std::string path = folder.path() + "/fuzzed.mcap";
  // a schema has ten thousand numbers: an input takes 40 ms
  test::FuzzRun fuzz("log", 3, 250);
  fuzz.run([&](FuzzRandom& random) {
    std::ofstream(path, std::ios::binary) << log_input(random.pick(seeds), damage, random);
    use(path);
  });
  CHECK(fuzz.accepted() > fuzz.inputs() / 50);
  CHECK(fuzz.accepted() < fuzz.inputs() * 9 / 10);
}

}  // namespace haptic
