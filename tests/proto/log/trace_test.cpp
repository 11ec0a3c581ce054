// SPDX-License-Identifier: GPL-3.0-or-later
#include "proto/log/trace.h"
#include "clients/log/trace_writer.h"

#include <signal.h>
#include <sys/mount.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <bit>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "clients/log/log_eyes.h"
#include "clients/log/recover.h"
#include "proto/log/csv.h"
#include "proto/log/hand_trace.h"
#include "tests/support/data.h"
#include "tests/support/frames.h"
#include "tests/support/hostile_text.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/tolerance.h"

namespace haptic {
namespace {

namespace fs = std::filesystem;

/// A file name used by this test only; the file does not exist yet.
std::string fresh_file(const std::string& name) {
  static const test::TemporaryFolder folder;
  fs::remove(folder.path() + "/" + name);
  return folder.path() + "/" + name;
}

std::string written(const std::string& name, const std::string& text) {
  std::string path = fresh_file(name);
  std::ofstream(path) << text;
  return path;
}

/// Any bytes are a record, and any number of values a part has; these differ in every word and
/// cannot be compressed.
template <typename T>
T random_record(uint64_t seed) {
  std::mt19937_64 random(seed);
  std::array<uint64_t, sizeof(T) / 8> words;
  for (uint64_t& word : words) word = random();
  for (const RecordPart& part : kParts<T>) words[part.offset / 8] %= part.most + 1;
  return std::bit_cast<T>(words);
}

/// A finite number in every field: its position in the record, scaled so that no digit is zero. Of
/// each part a few values.
template <typename T>
T counted_record(uint64_t seed) {
  alignas(8) std::array<std::byte, sizeof(T)> bytes{};
  double n = static_cast<double>(seed);
  for (const Field& field : flatten(Schema<T>::text)) {
    n += 1;
    const double real = n / 3;
    const uint64_t whole = static_cast<uint64_t>(n) + (uint64_t{1} << 60);
    const uint32_t count = static_cast<uint32_t>(n);
    const void* value = field.type == "float64"  ? static_cast<const void*>(&real)
                        : field.type == "uint32" ? static_cast<const void*>(&count)
                                                 : static_cast<const void*>(&whole);
    std::memcpy(&bytes[field.offset], value, field.type == "uint32" ? 4 : 8);
  }
  for (const RecordPart& part : kParts<T>) {
    const uint64_t values = 2 + (seed + part.offset) % 3;
    std::memcpy(&bytes[part.offset], &values, sizeof values);
  }
  return std::bit_cast<T>(bytes);
}

template <typename T>
bool same_bytes(const T& a, const T& b) {
  if constexpr (!kParts<T>.empty()) return test::bytes_in_use(a) == test::bytes_in_use(b);
  // wire structs have no padding: NOLINTNEXTLINE(bugprone-suspicious-memory-comparison)
  return std::memcmp(&a, &b, sizeof a) == 0;
}

ServoFrame traced_frame(uint64_t tick) {
  ServoFrame frame{};
  frame.tick = tick;
  frame.t_ns = static_cast<int64_t>(tick) * 1'000'000;
  frame.realtime_ns = frame.t_ns + 1'700'000'000'000'000'000;
  frame.device.t_ns = frame.t_ns - 1000;
  frame.device.flags = kDeviceFresh | kDeviceHomed;
  frame.device.X_BH.p = {0.1 / 3 * static_cast<double>(tick), 1e-300, -0.0};
  return frame;
}

Stamp stamp_of(const ServoFrame& frame) {
  return {frame.t_ns, frame.realtime_ns, frame.tick};
}

bool write_tick(TraceWriter& trace, uint64_t tick) {
  const ServoFrame frame = traced_frame(tick);
  return trace.write(servo_topic(kFirstHand), frame, stamp_of(frame));
}

/// Ticks 1, 2, 3, … as written, and nothing else.
uint64_t count_whole(const std::string& path) {
  uint64_t tick = 0;
  TraceReader(path).for_each<ServoFrame>(servo_topic(kFirstHand),
                                         [&](const ServoFrame& f, const Stamp& s) {
                                           ++tick;
                                           REQUIRE(same_bytes(f, traced_frame(tick)));
                                           REQUIRE(s.sequence == tick);
                                         });
  return tick;
}

ReplayConfig trace_replay(const std::string& path) {
  ReplayConfig config;
  assign(config.path, path);
  return config;
}

std::string trace_error(const std::string& path) {
  return test::refusal([&] { load_hand_trace(trace_replay(path)); });
}

}  // namespace

TEST_CASE("schema: a flattened struct has each number once, without holes") {
  for (const TopicInfo& topic : kTopics) {
    const Fields fields = flatten(topic.text);
    REQUIRE(fields.parts.size() == topic.parts.size());
    size_t end = 0, part = 0;
    for (const Field& field : fields) {
      CHECK(field.offset == end);
      end += field.type == "uint32" ? 4 : 8;
      // the number of values of a part, and four bytes of zero
      if (part == fields.parts.size() || field.offset != fields.parts[part].offset) continue;
      CHECK(field.name.starts_with("n_"));
      CHECK(field.offset == topic.parts[part].offset);
      CHECK(fields.parts[part].element == topic.parts[part].element);
      CHECK(fields.parts[part].most == topic.parts[part].most);
      ++part;
      end += 4;
    }
    CHECK(part == topic.parts.size());
    CHECK(end == topic.size);
    CHECK(fields.bytes == topic.size);
  }
}

TEST_CASE("schema: names, offsets and units are those of the struct") {
  const std::vector<Field> fields = flatten(Schema<ServoFrame>::text);
  const auto find = [&](const std::string& name) {
    for (const Field& f : fields) {
      if (f.name == name) return f;
    }
    FAIL("no field " << name);
    return Field{};
  };
  ServoFrame frame{};
  frame.pushes.resize(4);
  const auto offset_of = [&](const auto& member) {
    return static_cast<size_t>(reinterpret_cast<const char*>(&member) -
                               reinterpret_cast<const char*>(&frame));
  };
  CHECK(find("device.X_BH.position.y").offset == offset_of(frame.device.X_BH.p.y));
  CHECK(find("device.X_BH.orientation.w").offset == offset_of(frame.device.X_BH.q.w));
  CHECK(find("V_WP.angular.x").offset == offset_of(frame.V_WP.w.x));
  CHECK(find("pushes[3].impulse_W.torque.z").offset == offset_of(frame.pushes[3].impulse_W.t.z));
  CHECK(find("n_pushes").offset == offset_of(frame.pushes));
  CHECK(find("n_contacts").offset == offset_of(frame.n_contacts));
  CHECK(find("X_WP.position.x").unit == "m");
  CHECK(find("X_WP.orientation.x").unit.empty());
  CHECK(find("F_device_B.torque.y").unit == "N·m");
  CHECK(find("pushes[3].impulse_W.force.x").unit == "N·s");
  CHECK(find("pushes[3].impulse_W.torque.x").unit == "N·m·s");
  CHECK(find("n_contacts").type == "uint32");
}

TEST_CASE("schema: the full text defines every type it names, each once") {
  const std::string text = full_definition(Schema<ServoFrame>::text);
  for (const char* type : {"geometry_msgs/Pose", "geometry_msgs/Point", "geometry_msgs/Quaternion",
                           "geometry_msgs/Twist", "geometry_msgs/Wrench", "geometry_msgs/Vector3",
                           "haptic_msgs/DeviceState", "haptic_msgs/ObjectPush"}) {
    const std::string head = std::string("MSG: ") + type + "\n";
    CAPTURE(type);
    CHECK(text.find(head) != std::string::npos);
    CHECK(text.find(head) == text.rfind(head));
  }
  CHECK(text.find("MSG: haptic_msgs/Contact\n") == std::string::npos);
}

TEST_CASE("trace: every topic reads back bit for bit, whatever the bits") {
  const std::string path = fresh_file("all.mcap");
  constexpr uint64_t kRecords = 60;  // up to 90 kB each: several chunks
  {
    TraceWriter trace(path, recording_metadata("s", "[session]\n"));
    for (uint64_t i = 0; i < kRecords; ++i) {
      const Stamp stamp{int64_t(i), int64_t(2 * i), i};
      REQUIRE(trace.write(servo_topic(kFirstHand), random_record<ServoFrame>(i), stamp));
      REQUIRE(trace.write(contact_topic(kFirstHand), random_record<ContactSet>(i), stamp));
      REQUIRE(trace.write(kSimTopic, random_record<SceneFrame>(i), stamp));
      REQUIRE(trace.write(kControlTopic, random_record<ControlFrame>(i), stamp));
      REQUIRE(trace.write(kEventTopic, random_record<Event>(i), stamp));
    }
    REQUIRE(trace.close());
  }
  const TraceReader trace(path);
  CHECK(trace.mcap().finished());
  CHECK(trace.mcap().chunks().size() > 2);
  CHECK(trace.mcap().metadata().at("recording").at("config") == "[session]\n");
  const auto check = [&]<typename T>(const Topic<T>& topic) {
    uint64_t i = 0;
    trace.for_each<T>(topic, [&](const T& value, const Stamp& stamp) {
      CHECK(same_bytes(value, random_record<T>(i)));
      CHECK(stamp.t_ns == int64_t(i));
      CHECK(stamp.realtime_ns == int64_t(2 * i));
      CHECK(stamp.sequence == i);
      ++i;
    });
    CHECK(i == kRecords);
  };
  check(servo_topic(kFirstHand));
  check(contact_topic(kFirstHand));
  check(kSimTopic);
  check(kControlTopic);
  check(kEventTopic);
}

TEST_CASE("trace: an empty recording is a whole file") {
  const std::string path = fresh_file("empty.mcap");
  TraceWriter(path, {}).close();
  const TraceReader trace(path);
  CHECK(trace.mcap().finished());
  CHECK(trace.read(servo_topic(kFirstHand)).empty());
}

TEST_CASE("trace: a killed writer loses nothing that was flushed") {
  const std::string path = fresh_file("killed.mcap");
  constexpr uint64_t kFlushed = 1000;
  int ready[2];
  REQUIRE(::pipe(ready) == 0);
  const pid_t child = ::fork();
  REQUIRE(child >= 0);
  if (child == 0) {
    TraceWriter trace(path, {});
    for (uint64_t tick = 1; tick <= kFlushed; ++tick) write_tick(trace, tick);
    trace.flush();
    // these stay in the open chunk
    write_tick(trace, kFlushed + 1);
    if (::write(ready[1], "x", 1) != 1) ::_exit(1);
    for (;;) ::pause();
  }
  char byte;
  REQUIRE(::read(ready[0], &byte, 1) == 1);
  REQUIRE(::kill(child, SIGKILL) == 0);
  int status = 0;
  REQUIRE(::waitpid(child, &status, 0) == child);
  CHECK(WIFSIGNALED(status));
  CHECK_FALSE(TraceReader(path).mcap().finished());
  CHECK(count_whole(path) == kFlushed);
  ::close(ready[0]);
  ::close(ready[1]);
}

TEST_CASE("trace: a file cut at any byte gives the chunks before the cut and no more") {
  const std::string path = fresh_file("cut.mcap");
  std::vector<uint64_t> ends;  // of the file after each flush
  {
    TraceWriter trace(path, {});
    for (uint64_t tick = 1; tick <= 5; ++tick) {
      write_tick(trace, tick);
      trace.flush();
      ends.push_back(trace.size());
    }
  }
  for (uint64_t size = fs::file_size(path); size-- > 64;) {
    fs::resize_file(path, size);
    CAPTURE(size);
    // a chunk is readable as soon as it is complete; its index follows and is not needed
    uint64_t at_least = 0;
    while (at_least < ends.size() && ends[at_least] <= size) ++at_least;
    const uint64_t got = count_whole(path);
    CHECK(got >= at_least);
    CHECK(got <= at_least + 1);
  }
}

TEST_CASE("trace: a flipped bit is found, not read") {
  const std::string path = fresh_file("flipped.mcap");
  uint64_t chunk = 0;
  {
    TraceWriter trace(path, {});
    chunk = trace.size();
    for (uint64_t tick = 1; tick <= 20; ++tick) {
      trace.write(servo_topic(kFirstHand), random_record<ServoFrame>(tick), {});
    }
  }
  std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
  const std::streamoff at = static_cast<std::streamoff>(chunk) + 5000;
  file.seekg(at);
  const char byte = static_cast<char>(file.get() ^ 0x10);
  file.seekp(at);
  file.put(byte);
  file.close();
  CHECK_THROWS_WITH(TraceReader(path).read(servo_topic(kFirstHand)),
                    Catch::Contains("the file is damaged"));
}

TEST_CASE("trace: at a limit of the file size the recording ends whole and says so") {
  const std::string path = fresh_file("limit.mcap");
  // in a child process: the limit cannot be lifted again
  const pid_t child = ::fork();
  REQUIRE(child >= 0);
  if (child == 0) {
    const rlimit limit{200'000, 200'000};
    if (::setrlimit(RLIMIT_FSIZE, &limit) != 0) ::_exit(2);
    TraceWriter trace(path, {});
    uint64_t tick = 1;
    for (; tick < 100'000; ++tick) {
      if (!write_tick(trace, tick) || !trace.flush()) break;
    }
    const bool told = trace.error().find("the file is complete") != std::string::npos &&
                      trace.error().find('\n') == std::string::npos;
    ::_exit(told && tick > 10 ? 0 : 1);
  }
  int status = 0;
  REQUIRE(::waitpid(child, &status, 0) == child);
  CHECK(WIFEXITED(status));
  CHECK(WEXITSTATUS(status) == 0);
  CHECK(fs::file_size(path) <= 200'000);
  CHECK(TraceReader(path).mcap().finished());
  CHECK(count_whole(path) > 10);
}

TEST_CASE("trace: on a full disk the recording ends whole and says so") {
  const fs::path disk = fs::path(fresh_file("disk"));
  fs::create_directories(disk);
  if (::mount("none", disk.c_str(), "tmpfs", 0, "size=2m") != 0) {
    WARN("SKIPPED: mounting a small disk needs root");
    return;
  }
  const std::string path = (disk / "full.mcap").string();
  {
    // other data on the disk
    std::ofstream(disk / "other") << std::string(500'000, 'x');
    TraceWriter trace(path, {});
    uint64_t tick = 1;
    const auto written = [&] {
      return trace.write(kSimTopic, random_record<SceneFrame>(tick), {}) &&
             (tick % 16 != 0 || trace.flush());
    };
    while (tick < 100'000 && written()) ++tick;
    CHECK_THAT(trace.error(), Catch::StartsWith(path + ": No space left on device after ") &&
                                  Catch::Contains("the file is complete"));
    CHECK_FALSE(trace.write(servo_topic(kFirstHand), traced_frame(1), {}));
    CHECK_FALSE(trace.close());
    const TraceReader read(path);
    CHECK(read.mcap().finished());
    const uint64_t found = read.read(kSimTopic).size();
    CHECK(found * sizeof(SceneFrame) > 600'000);
    CHECK(trace.written(kSimTopic.name) == found);
    CHECK(found < tick);
    CHECK(found + 16 >= tick);
  }
  CHECK(::umount(disk.c_str()) == 0);
}

TEST_CASE("trace: what is no recording is told in one line") {
  CHECK_THROWS_WITH(TraceReader("/nowhere/x.mcap"), Catch::StartsWith("/nowhere/x.mcap: cannot"));
  CHECK_THROWS_WITH(TraceReader(written("no.mcap", "hello, this is text")),
                    Catch::Contains("is not an MCAP file"));
  CHECK_THROWS_WITH(TraceReader(written("none.mcap", "")), Catch::Contains("is not an MCAP file"));
  CHECK_THROWS_WITH(TraceWriter("/nowhere/x.mcap", {}), Catch::Contains("cannot be written"));
}

TEST_CASE("csv: the export has a row a record and reads back to the same bits") {
  const std::string path = fresh_file("export.mcap");
  {
    TraceWriter trace(path, {});
    for (uint64_t tick = 1; tick <= 200; ++tick) {
      ServoFrame frame = traced_frame(tick);
      frame.device.V_BH.w = random_record<Twist>(tick).w;
      frame.device.V_BH.w.y = 1.0 / static_cast<double>(tick);
      if (!is_finite(frame.device.V_BH.w)) frame.device.V_BH.w = {};
      frame.pushes.resize(2);
      frame.pushes[1].impulse_W.f.x = 2;
      trace.write(servo_topic(kFirstHand), frame, stamp_of(frame));
    }
  }
  const TraceReader trace(path);
  std::ostringstream text;
  CHECK(export_csv(trace, *find_topic("/servo0/frame"), text) == 200);
  const std::string csv = written("export.csv", text.str());

  const HandTrace from_csv = load_hand_trace(trace_replay(csv));
  const HandTrace from_mcap = load_hand_trace(trace_replay(path));
  REQUIRE(from_csv.samples.size() == 200);
  REQUIRE(from_mcap.samples.size() == 200);
  for (size_t i = 0; i < 200; ++i) CHECK(same_bytes(from_csv.samples[i], from_mcap.samples[i]));

  const CsvReader reader(csv);
  CHECK(reader.find("X_WP.position.x_m") != CsvReader::npos);
  CHECK(reader.find("F_device_B.torque.y_Nm") != CsvReader::npos);
  CHECK(reader.find("V_WT.linear.z_m_per_s") != CsvReader::npos);
  CHECK(reader.find("t_ns") != CsvReader::npos);
  CHECK(reader.find("pushes[1].impulse_W.torque.z_Nms") != CsvReader::npos);
  CHECK(reader.find("pushes[2].impulse_W.force.x_Ns") == CsvReader::npos);
}

TEST_CASE("trace: a sample for other programs has finite numbers in every field") {
  // tests/clients/library/mcap_reader.mjs names a folder and reads what is left there
  const char* given = std::getenv("HAPTIC_SAMPLE_FOLDER");
  const fs::path folder = given != nullptr ? fs::path(given) : fs::path(fresh_file("sample"));
  fs::create_directories(folder);
  const std::string path = (folder / "sample.mcap").string();
  constexpr uint64_t kRecords = 400;
  {
    TraceWriter trace(path, recording_metadata("sample", ""));
    const auto write = [&]<typename T>(const Topic<T>& topic, uint64_t i) {
      const Stamp stamp{int64_t(i), int64_t(1000 * i), i};
      trace.write(topic, counted_record<T>(i), stamp);
    };
    for (uint64_t i = 0; i < kRecords; ++i) {
      write(servo_topic(kFirstHand), i);
      if (i % 4 == 0) write(contact_topic(kFirstHand), i);
      if (i % 8 == 0) write(kSimTopic, i);
      if (i % 100 == 0) write(kControlTopic, i);
      if (i % 50 == 0) write(kEventTopic, i);
    }
    REQUIRE(trace.close());
  }
  const TraceReader trace(path);
  for (const TopicInfo& topic : kTopics) {
    std::string name(topic.name);
    std::replace(name.begin(), name.end(), '/', '_');
    std::ofstream csv(folder / (name + ".csv"));
    CHECK(export_csv(trace, topic, csv) >= 4);
  }
}

TEST_CASE(
    "csv: an array has as many columns as the fullest record and empty cells beyond its own") {
  const std::string path = fresh_file("sets.mcap");
  {
    TraceWriter trace(path, {});
    for (uint32_t n = 0; n < 3; ++n) {
      ContactSet set{};
      set.contacts.resize(n);
      for (Contact& c : set.contacts) c.extent = 7;
      trace.write(contact_topic(kFirstHand), set, {});
    }
  }
  std::ostringstream text;
  CHECK(export_csv(TraceReader(path), *find_topic("/contact0/set"), text) == 3);
  CsvReader reader(written("sets.csv", text.str()));
  const size_t first = reader.require("contacts[0].extent_m");
  const size_t second = reader.require("contacts[1].extent_m");
  CHECK(reader.find("contacts[2].extent_m") == CsvReader::npos);
  CHECK(reader.find("objects[0].X_WO.position.x_m") == CsvReader::npos);
  REQUIRE(reader.next());
  CHECK_THROWS_WITH(reader.number(first), Catch::Contains("is '', not a finite number"));
  REQUIRE(reader.next());
  CHECK(reader.number(first) == 7);
  CHECK_THROWS_AS(reader.number(second), CsvError);
  REQUIRE(reader.next());
  CHECK(reader.number(second) == 7);
  CHECK_FALSE(reader.next());
}

TEST_CASE("csv: mistakes are told with file and line") {
  const std::string head = "t_s,x_m,y_m,z_m\n0,1,2,3\n0.001,1,2,3\n";
  const auto [text, says] = GENERATE_COPY(table<std::string, std::string>({
      {"t_s,x_m,y_m\n0,1,2\n", ":1: has no column 'z_m'; it has t_s, x_m, y_m"},
      {"time,x,y,z\n0,1,2,3\n", ":1: has no column 't_s'; it has time, x, y, z"},
      {head + "0.0005,1,2,3\n", ":4: time does not advance: 0.000500 s after 0.001000 s"},
      {head + "0.001,1,2,3\n", ":4: time does not advance"},
      {head + "\n0.002,1,2\n", ":5: has 3 cells where the header has 4"},
      {head + "0.002,1,2,3,4\n", ":4: has 5 cells where the header has 4"},
      {head + "0.002,1,left,3\n", ":4: 'y_m' is 'left', not a finite number"},
      {head + "0.002,1,,3\n", ":4: 'y_m' is '', not a finite number"},
      {head + "0.002,1,nan,3\n", ":4: 'y_m' is 'nan', not a finite number"},
      {head + "0.002,1,2 m,3\n", ":4: 'y_m' is '2 m', not a finite number"},
      {head + "0.002,1,2,3,", ":4: has 5 cells"},
      {"", ":0: is empty"},
      {"t_s,x_m,y_m,z_m\n", ": holds 0 samples of the hand"},
  }));
  const std::string path = written("bad.csv", text);
  const std::string error = trace_error(path);
  CHECK_THAT(error, Catch::StartsWith(path + says));
  CHECK(error.find('\n') == std::string::npos);
}

TEST_CASE("csv: what is no recording at all is said to be none") {
  const std::string folder = fs::path(fresh_file("folder")).parent_path().string();
  CHECK(trace_error(folder) == folder + ": is a folder; name a recording (.mcap or .csv)");
  // an MCAP file is recognised by its content, not by its name
  const std::string path = written("renamed.csv", std::string("\x89MCAP0\r\n", 8) + "rest");
  CHECK_THAT(trace_error(path), !Catch::Contains("has no column"));
  CHECK_THAT(trace_error(written("lever.csv", "t_s,lever_rad\n0,0\n1,1\n")),
             Catch::EndsWith("`column` in [device.replay], as configs/lever.toml does"));
}

TEST_CASE("csv: holes are not refused") {
  const HandTrace trace = load_hand_trace(
      trace_replay(written("gaps.csv",
                           "t_s,x_m,y_m,z_m\r\n0,0,0,0\r\n0.01,1,0,0\r\n0.05,2,0,0\r\n"
                           "0.06,3,0,0\r\n0.2,4,0,0\r\n")));
  REQUIRE(trace.samples.size() == 5);
  CHECK(trace.samples[2].t_ns == 50'000'000);
}

TEST_CASE("csv: a lever angle becomes a position along the axis") {
  ReplayConfig config =
      trace_replay(written("lever.csv", "t_s,lever_rad\n0,0\n0.5,0.1\n1,0.2\n1.5,0.3\n"));
  assign(config.column, "lever_rad");
  config.lever_arm = 0.075;
  config.axis_B = {0, -1, 0};
  const HandTrace trace = load_hand_trace(config);
  REQUIRE(trace.samples.size() == 4);
  CHECK(trace.samples[2].X_BH.p == Vec3{0, -0.075 * 0.2, 0});
}

TEST_CASE("csv: the recordings of a real lever load whole") {
  ReplayConfig config = trace_replay(test::data_file("tue-1dof-bilateral/m2_question1c_rigid.csv"));
  assign(config.column, "master_rad");
  config.lever_arm = 0.075;
  const HandTrace trace = load_hand_trace(config);
  // 2 kHz without a gap, 4 to 5 s, according to the notes of the data set
  CHECK(trace.duration() > 3.9);
  CHECK(trace.duration() < 5.1);
  CHECK(trace.samples.front().X_BH.p == Vec3{0.075 * -0.07026696, 0, 0});
  CHECK(trace.samples.size() == static_cast<size_t>(trace.duration() * 2000 + 1.5));

  const HandTrace wipe =
      load_hand_trace(trace_replay(test::data_file("epfl-wiping/wipe_rim_1.csv")));
  CHECK(wipe.samples.front().X_BH.p == Vec3{-0.437303, -0.0395946, 0.644698});
}

TEST_CASE(
    "trace: attachments are read back, by the index, without an end, and from a recovered copy") {
  const test::TemporaryFolder folder;
  const std::string path = folder.path() + "/a.mcap", cut = folder.path() + "/cut.mcap";
  std::vector<std::byte> large(300'000);
  for (size_t i = 0; i < large.size(); ++i) large[i] = static_cast<std::byte>(i * i);
  const std::vector<std::byte> small{std::byte{7}};
  {
    TraceWriter trace(path, {});
    trace.add_attachment("eye/tool", kEyeMediaType, 11, large);
    trace.write(servo_topic(kFirstHand), ServoFrame{}, {1, 1, 0});
    trace.add_attachment("eye/3", kEyeMediaType, 12, large);
    trace.add_attachment("eye/3", kEyeMediaType, 13, small);
    trace.add_attachment("notes", "text/plain", 14, small);
    trace.write(servo_topic(kFirstHand), ServoFrame{}, {2, 2, 1});
  }
  std::filesystem::copy_file(path, cut);
  std::filesystem::resize_file(cut, McapReader(path).chunks().back().offset + 30);
  const std::string recovered = folder.path() + "/recovered.mcap";
  CHECK(recover_log(cut, recovered).attachments == 4);
  for (const std::string& file : {path, cut, recovered}) {
    CAPTURE(file);
    const McapReader reader(file);
    CHECK(reader.finished() == (file != cut));
    REQUIRE(reader.attachments().size() == 4);
    CHECK(reader.attachments()[3].name == "notes");
    CHECK(reader.attachments()[3].log_time_ns == 14);
    CHECK(reader.attachments()[0].size == large.size());
    const LogEyes eyes = read_log_eyes(reader);
    CHECK(eyes.tools[kFirstHand] == large);
    REQUIRE(eyes.objects.size() == 1);
    CHECK(eyes.objects.at(3) == small);  // the newest
  }
  // one byte of the data
  {
    std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(static_cast<std::streamoff>(McapReader(path).attachments()[0].offset + 1000));
    file.put('x');
  }
  const McapReader damaged(path);
  CHECK_THROWS_WITH(damaged.read_attachment(damaged.attachments()[0]),
                    Catch::Contains("attachment 'eye/tool'") && Catch::Contains("wrong CRC"));
  CHECK(read_log_eyes(damaged).tools[kFirstHand].empty());
}

}  // namespace haptic
