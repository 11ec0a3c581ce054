// SPDX-License-Identifier: GPL-3.0-or-later
// A recording in the bridge: what a page is shown against the records that were written, its slider
// at times that the test gives, and the bridge as a browser sees it.
#include <atomic>
#include <catch2/catch.hpp>
#include <cmath>
#include <sstream>
#include <thread>

#include "clients/log/log_eyes.h"
#include "clients/log/trace_writer.h"
#include "clients/view/bridge.h"
#include "clients/view/log_source.h"
#include "clients/view/scene.h"
#include "proto/ipc/eye_file.h"
#include "proto/log/csv.h"
#include "proto/math/units.h"
#include "proto/os/message.h"
#include "tests/support/frames.h"
#include "tests/support/temporary_folder.h"
#include "tests/view/layout_reader.h"
#include "tests/view/socket_client.h"

namespace haptic {
namespace {

using test::kBinary;
using test::LayoutReader;
using test::Message;
using Json = nlohmann::json;

constexpr uint64_t kFirst = 100;

/// A frame that differs in each tick and column; ticks 600 to 699 touch, 900 has a fault.
ServoFrame frame_of(uint64_t tick, size_t column = 0) {
  ServoFrame frame{};
  const auto t = static_cast<double>(tick), c = static_cast<double>(column);
  frame.tick = tick;
  frame.t_ns = frame.realtime_ns = static_cast<int64_t>(tick) * kMs;
  frame.X_WT.p = {std::sin(t * t), t + c, std::cos(t)};
  frame.X_WP.p = {std::cos(t * t), c, 0};
  frame.F_device_B.f = {0, std::sin(t), c};
  frame.depth = 1e-3 * std::sin(t / 50);
  frame.contact_seq = frame.contact_tick = tick;
  frame.scene_seq = tick / 8;
  frame.n_contacts = static_cast<uint32_t>(tick % 3);
  if (tick >= 600 && tick < 700) frame.flags |= kServoContact;
  if (tick == 900) frame.flags |= kServoFault;
  return frame;
}

ContactSet set_of(uint64_t tick, size_t column) {
  ContactSet set{};
  set.seq = set.answers_tick = tick;
  set.answers_t_ns = static_cast<int64_t>(tick) * kMs;
  set.contacts.resize(1 + (tick + column) % 3);
  for (size_t i = 0; i < set.contacts.size(); ++i) {
    set.contacts[i].object_point_O = {static_cast<double>(tick), static_cast<double>(i), 0.25};
  }
  return set;
}

std::vector<TopicInfo> topics_of(const std::vector<LogColumn>& columns) {
  std::vector<TopicInfo> topics;
  for (const LogColumn& column : columns) {
    topics.push_back(info_of(Topic<ServoFrame>{column.servo}));
    topics.push_back(info_of(Topic<ContactSet>{column.contact}));
    topics.push_back(info_of(Topic<SceneFrame>{column.sim}));
  }
  return topics;
}

void write_ticks(TraceWriter& trace, uint64_t from, uint64_t to,
                 const std::vector<LogColumn>& columns) {
  for (uint64_t tick = from; tick < to; ++tick) {
    for (size_t i = 0; i < columns.size(); ++i) {
      const ServoFrame frame = frame_of(tick, i);
      const Stamp stamp{frame.t_ns, frame.realtime_ns, tick};
      if (tick % 8 == 0 || tick == kFirst) {
        SceneFrame scene{};
        scene.seq = tick / 8, scene.t_ns = frame.t_ns;
        const Vec3 place_W{0, 0, static_cast<double>(tick / 8)};
        scene.objects.push_back(test::scene_object({place_W, {}}, {}, frame.t_ns));
        trace.write(Topic<SceneFrame>{columns[i].sim}, scene, stamp);
      }
      trace.write(Topic<ContactSet>{columns[i].contact}, set_of(tick, i), stamp);
      trace.write(Topic<ServoFrame>{columns[i].servo}, frame, stamp);
    }
  }
}

const std::vector<LogColumn> kSession{
    {std::string(kSessionColumn), std::string(servo_topic(kFirstHand).name),
     std::string(contact_topic(kFirstHand).name), std::string(kSimTopic.name)}};

std::string write_log(const std::string& folder, uint64_t ticks = 2000) {
  const std::string path = folder + "/a.mcap";
  TraceWriter trace(path, {});
  write_ticks(trace, kFirst, kFirst + ticks, kSession);
  trace.close();
  return path;
}

/// The frames of what a page is shown, as a browser reads them.
std::vector<std::vector<double>> frames_of(Viewer& viewer) {
  std::vector<std::vector<double>> frames;
  for (const std::string& bytes : next_log_frames(viewer, 0)) {
    frames.push_back(LayoutReader::numbers(bytes));
  }
  return frames;
}

void check_frame(const LayoutReader& layout, const std::vector<double>& got, uint64_t tick,
                 size_t column) {
  CAPTURE(tick, column);
  const ServoFrame wanted = frame_of(tick, column);
  CHECK(layout.one(got, "tick") == static_cast<double>(tick));
  CHECK(layout.one(got, "column") == static_cast<double>(column));
  const auto tool = layout.fixed(got, "tool"), proxy = layout.fixed(got, "proxy");
  CHECK((tool[0] == wanted.X_WT.p.x && tool[1] == wanted.X_WT.p.y && tool[2] == wanted.X_WT.p.z));
  CHECK((proxy[0] == wanted.X_WP.p.x && proxy[1] == wanted.X_WP.p.y));
  CHECK(layout.fixed(got, "force")[1] == wanted.F_device_B.f.y);
  CHECK(layout.one(got, "depth") == wanted.depth);
  CHECK(layout.one(got, "n_pushing") == wanted.n_contacts);
  const ContactSet set = set_of(tick, column);
  REQUIRE(layout.count(got, "n_listed") == set.contacts.size());
  CHECK(layout.contact(got, 0, "point")[0] == static_cast<double>(tick));
  REQUIRE(layout.count(got, "n_objects") == 1);
  CHECK(layout.object(got, 0, "pose")[2] == static_cast<double>(tick / 8) + 0);
}

Viewer viewer_of(const LogSource& log) {
  Viewer viewer;
  viewer.log = log.open_page();
  return viewer;
}

}  // namespace

TEST_CASE("view log: a page's slider plays, stops, steps and loops") {
  const LogTicks log{100, 10'100, 1000};
  Playback page(100);
  int64_t now = 5'000 * kMs;
  const auto after = [&](int64_t ms) { return page.at(now += ms * kMs, log); };
  CHECK(after(0) == 100);
  CHECK(after(1000) == 100);  // it stands still
  page.take(PlayMessage{1});
  CHECK(after(500) == 600);
  page.take(PlayMessage{0.1});
  CHECK(after(1000) == 700);
  page.take(PlayMessage{4});
  CHECK(after(100) == 1100);
  page.take(StepMessage{-3});
  CHECK(after(100) == 1097);
  page.take(SeekMessage{1'000'000});
  CHECK(after(0) == 10'100);
  page.take(StepMessage{-1'000'000});
  CHECK(after(0) == 100);
  page.take(LoopMessage{{{200, 300}}});
  page.take(PlayMessage{1});
  CHECK(after(200) == 300);
  CHECK(after(1) == 200);
  CHECK(after(50) == 250);
  page.take(LoopMessage{});
  CHECK(after(1000) == 1250);
  page.take(StopMessage{});
  CHECK(after(1000) == 1250);
  // at the end it waits, and goes on where there is more
  page.take(SeekMessage{10'000});
  page.take(PlayMessage{1});
  CHECK(after(500) == 10'100);
  CHECK(page.at(now += 100 * kMs, {100, 20'000, 1000}) == 10'200);
}

TEST_CASE("view log: pages begin at the tightest place, and the scene says where that is") {
  const test::TemporaryFolder folder;
  const std::string path = write_log(folder.path());
  const std::string printed =
      R"({"objects": [{"name": "far"}, {"name": "a\u001b", "index": 1, "distance_m": 0.0012,
      "tick": 777, "t_s": 0.677, "tool_point_W": [1, 2, 3], "object_point_W": [4, 5, 6],
      "X_WT": {"position": [7, 8, 9], "orientation": [0, 1, 0, 0]}}], "nearest": 1})";
  const TightestPlace place = parse_tightest(printed, "x.json");
  CHECK(words_of(place) == "The tool is nearest to 'a\\x1b' at 0.677 s: 1.2 mm");
  LogSource log(path, place);
  CHECK(log.advance(1) == SourceNews::kArrived);
  const Json scene = Json::parse(scene_json(log.scene(), log.view(), false));
  CHECK(scene["clearance"]["object"] == 1);
  CHECK(scene["clearance"]["tick"] == 777);
  CHECK(scene["clearance"]["tool"] == Json({7., 8., 9., 0., 1., 0., 0.}));
  CHECK(scene["clearance"]["tool_point"] == Json({1., 2., 3.}));
  CHECK(scene["clearance"]["object_point"] == Json({4., 5., 6.}));
  Viewer viewer = viewer_of(log);
  CHECK(log.show(*viewer.log, 0));
  check_frame(LayoutReader(layout_json()), frames_of(viewer).at(0), 777, 0);
  // without one there is none
  CHECK_FALSE(
      Json::parse(scene_json(LogSource(path).scene(), View{}, false)).contains("clearance"));

  for (const std::string& damaged :
       {std::string("[]"), std::string("{"), printed.substr(0, 200),
        std::string(printed).replace(printed.find("[0, 1, 0, 0]"), 12, "[0, 2, 0, 0]"),
        std::string(printed).replace(printed.find("0.0012"), 6, "-0.001"),
        std::string(printed).replace(printed.find("\"nearest\": 1"), 12, "\"nearest\": 7")}) {
    CHECK_THROWS_AS(parse_tightest(damaged, "x.json"), InputError);
  }
  CHECK_THROWS_WITH(read_tightest(folder.path()), Catch::Contains("is a folder"));
}

TEST_CASE("view log: frames of any tick have the numbers of the records") {
  const test::TemporaryFolder folder;
  LogSource log(write_log(folder.path()));
  CHECK(log.advance(1) == SourceNews::kArrived);
  const LayoutReader layout(layout_json());
  Viewer viewer = viewer_of(log), other = viewer_of(log);
  CHECK(log.show(*viewer.log, 0));
  check_frame(layout, frames_of(viewer).at(0), kFirst, 0);
  CHECK_FALSE(log.show(*viewer.log, 1));  // it has that
  for (uint64_t n = 0; n < 100; ++n) {
    const uint64_t tick = kFirst + n * 7919 % 2000;
    log.take(*viewer.log, SeekMessage{tick}, 1);
    if (!log.show(*viewer.log, 1)) continue;
    const auto frame = frames_of(viewer).at(0);
    check_frame(layout, frame, tick, 0);
    CHECK(frame.size() == layout.length(frame));
    CHECK(layout.one(frame, "sequence") == static_cast<double>(viewer.sequence - 1));
  }
  // a step on has the samples of the ticks since
  log.take(*viewer.log, SeekMessage{500}, 1);
  log.show(*viewer.log, 1);
  frames_of(viewer);
  log.take(*viewer.log, StepMessage{20}, 1);
  CHECK(log.show(*viewer.log, 1));
  const auto frame = frames_of(viewer).at(0);
  REQUIRE(layout.count(frame, "n_samples") == 20);
  CHECK(layout.one(frame, "unseen") == 19);
  for (size_t i = 0; i < 20; ++i) {
    CHECK(layout.sample(frame, i, "force")[1] == std::sin(501.0 + static_cast<double>(i)));
    CHECK(layout.sample(frame, i, "contact_rate")[0] == Approx(1000));
  }
  // the other page has stayed where it was
  CHECK(log.show(*other.log, 1));
  check_frame(layout, frames_of(other).at(0), kFirst, 0);
}

TEST_CASE("view log: a comparison has a frame of each column, of one instant") {
  const test::TemporaryFolder folder;
  const std::vector<LogColumn> columns{column_of_comparison("penalty3"),
                                       column_of_comparison("voxel/quasi-static")};
  const std::string path = folder.path() + "/compared.mcap";
  {
    const auto topics = topics_of(columns);
    TraceWriter trace(path, {}, topics);
    trace.add_metadata("comparison", {{"columns", "penalty3,voxel/quasi-static"}});
    write_ticks(trace, kFirst, kFirst + 300, columns);
  }
  LogSource log(path);
  log.advance(1);
  CHECK(log.columns() == std::vector<std::string>{"penalty3", "voxel/quasi-static"});
  const LayoutReader layout(layout_json());
  Viewer viewer = viewer_of(log);
  log.take(*viewer.log, SeekMessage{333}, 1);
  REQUIRE(log.show(*viewer.log, 1));
  const auto frames = frames_of(viewer);
  REQUIRE(frames.size() == 2);
  for (size_t i = 0; i < 2; ++i) check_frame(layout, frames[i], 333, i);
  CHECK(viewer.sequence == 2);
  CHECK_FALSE(viewer.has_shown);
}

TEST_CASE("view log: marks are found, and a page goes to the next one") {
  const test::TemporaryFolder folder;
  const std::string path = write_log(folder.path());
  LogSource log(path);
  log.advance(1);
  LogStudy study(path, {});
  for (bool has_more = true; has_more;) {
    const LogStudy::Piece piece = study.advance();
    log.add_marks(piece.marks, piece.is_news);
    has_more = piece.has_more;
  }
  CHECK(log.advance(1'000 * kMs) == SourceNews::kChanged);
  CHECK(log.advance(1'001 * kMs) == SourceNews::kNothing);
  const Json scene = Json::parse(scene_json(log.scene(), log.view(), false));
  CHECK(scene["first_tick"] == kFirst);
  CHECK(scene["last_tick"] == kFirst + 1999);
  CHECK(scene["first_time"].get<double>() == Approx(0.1));
  CHECK(scene["growing"] == false);
  REQUIRE(scene["marks"].size() == 2);
  CHECK(scene["marks"][0]["kind"] == "contact");
  CHECK(scene["marks"][0]["tick"] == 600);
  CHECK(scene["marks"][1]["time"].get<double>() == Approx(0.9));
  Viewer viewer = viewer_of(log);
  const auto tick_after = [&](const LogMessage& message) {
    log.take(*viewer.log, message, 1);
    log.show(*viewer.log, 1);
    return *viewer.log->shown;
  };
  CHECK(tick_after(NextMessage{MarkKind::kFault, true}) == 900);
  CHECK(tick_after(NextMessage{MarkKind::kFault, true}) == 900);  // there is no other
  CHECK(tick_after(NextMessage{MarkKind::kContact, false}) == 600);
}

TEST_CASE("view log: overview and table, against the frames that were written") {
  const test::TemporaryFolder folder;
  const std::string path = write_log(folder.path());
  LogStudy study(path, {});
  while (study.advance().has_more) {
  }
  const auto overview = [&](const std::string& query) {
    const WebAnswer answer = study.overview(query);
    REQUIRE(answer.status == 200);
    return Json::parse(*answer.body);
  };
  const Json some = overview("from=0.3&to=0.5&columns=4");
  REQUIRE(some["time"].size() == 4);
  CHECK(some["time"][1].get<double>() == Approx(0.35));
  const Json& depth = some["columns"][0]["depth"];
  for (size_t k = 0; k < 4; ++k) {
    double low = 1, high = -1;
    for (uint64_t tick = 300 + 50 * k; tick < 350 + 50 * k; ++tick) {
      low = std::min(low, frame_of(tick).depth), high = std::max(high, frame_of(tick).depth);
    }
    CHECK(depth["min"][k].get<double>() == low);
    CHECK(depth["max"][k].get<double>() == high);
  }
  // longer than what is read frame by frame: out of steps, and nothing beyond the log
  const Json all = overview("from=-10&to=20&columns=30");
  CHECK(all["columns"][0]["force"]["max"][0].is_null());
  CHECK(all["columns"][0]["force"]["max"][29].is_null());
  CHECK(all["columns"][0]["depth"]["max"][10].get<double>() == Approx(1e-3).epsilon(1e-3));
  for (const char* wrong : {"", "from=1", "from=1&to=0&columns=3", "from=0&to=1&columns=1e9",
                            "from=nan&to=1&columns=3", "from=x&to=1&columns=3"}) {
    CHECK(study.overview(wrong).status == 400);
  }

  std::ostringstream whole;
  const TraceReader trace(path);
  export_csv(trace, *find_topic(servo_topic(kFirstHand).name), whole);
  std::istringstream rows(whole.str());
  std::string line, wanted;
  for (uint64_t row = 0; std::getline(rows, line); ++row) {
    if (row == 0 || (row > 500 && row <= 700)) wanted += line + "\n";  // ticks 600 to 799
  }
  const WebAnswer table = study.table("from=600&to=799");
  CHECK(table.type == "text/csv");
  CHECK(*table.body == wanted);
  CHECK(study.table("from=5&to=1").status == 400);
  CHECK(study.table("from=0&to=5&column=1").status == 400);
}

TEST_CASE("view log: a file that grows, from before its first frame on") {
  const test::TemporaryFolder folder;
  const std::string path = folder.path() + "/grows.mcap";
  TraceWriter trace(path, {});
  LogSource log(path);
  int64_t now = kNsPerSecond;
  const auto later = [&] { return log.advance(now += kNsPerSecond); };
  CHECK(later() == SourceNews::kNothing);
  CHECK(log.open_page() == nullptr);
  write_ticks(trace, kFirst, kFirst + 500, kSession);
  trace.flush();
  CHECK(later() == SourceNews::kArrived);
  CHECK(later() == SourceNews::kNothing);
  Viewer viewer = viewer_of(log);
  log.take(*viewer.log, SeekMessage{5000}, 1);
  log.show(*viewer.log, 1);
  CHECK(viewer.log->shown == kFirst + 499);
  write_ticks(trace, kFirst + 500, kFirst + 1000, kSession);
  trace.flush();
  CHECK(later() == SourceNews::kChanged);
  CHECK(log.scene().log->last_tick == kFirst + 999);
  CHECK(log.scene().log->growing);
  log.take(*viewer.log, SeekMessage{5000}, 1);
  CHECK(log.show(*viewer.log, 1));
  const LayoutReader layout(layout_json());
  check_frame(layout, frames_of(viewer).at(0), kFirst + 999, 0);
  trace.close();
  CHECK(later() == SourceNews::kChanged);
  CHECK_FALSE(log.scene().log->growing);

  const std::string empty = folder.path() + "/empty.mcap";
  TraceWriter(empty, {}).close();
  CHECK_THROWS_WITH(LogSource(empty), Catch::Contains("has no servo frames"));
}

TEST_CASE("view log: meshes come from the attachments, a damaged one is left out") {
  const test::TemporaryFolder folder;
  const std::string path = folder.path() + "/eyes.mcap";
  const std::vector<EyePoint> points{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  const std::vector<EyeTriangle> triangles{{0, 1, 2}};
  const auto eye = [&](uint32_t object) {
    EyeFile file;
    file.object = object;
    file.name = "eye";
    file.vertices = file.normals = points;
    file.triangles = triangles;
    return write_eye(file);
  };
  {
    TraceWriter trace(path, {});
    trace.add_attachment("eye/1", kEyeMediaType, 1, eye(0));  // replaced below
    trace.add_attachment("eye/0", kEyeMediaType, 1, std::vector<std::byte>(100));
    trace.add_attachment("eye/" + std::to_string(kMaxObjects), kEyeMediaType, 1, eye(1));
    trace.add_attachment("eye/tool", "image/png", 1, eye(kEyeOfTool));
    write_ticks(trace, kFirst, kFirst + 10, kSession);
    trace.add_attachment("eye/1", kEyeMediaType, 2, eye(1));
  }
  const LogSource log(path);
  const EyeFiles& eyes = log.scene().eyes;
  CHECK(eyes.tool == nullptr);
  REQUIRE(eyes.objects.size() == 2);
  CHECK(eyes.objects[0] == nullptr);
  REQUIRE(eyes.objects[1] != nullptr);
  const auto wanted = eye(1);
  CHECK(*eyes.objects[1] ==
        std::string(reinterpret_cast<const char*>(wanted.data()), wanted.size()));
}

TEST_CASE("view log: a browser plays a recording, and its pages move apart") {
  const test::TemporaryFolder folder;
  BridgeOptions options;
  options.token = "secret";
  Bridge bridge(log_source(write_log(folder.path())), options);
  std::atomic<bool> stop{false};
  std::thread thread([&] { bridge.run([&] { return stop.load(); }); });
  const uint16_t port = bridge.port();
  const std::string host = "127.0.0.1:" + std::to_string(port);
  {
    const LayoutReader layout(test::get(port, "/layout.json").body);
    test::SocketClient page(port), other(port);
    const auto open = [&](test::SocketClient& client) {
      return client.upgrade("/view", host, "http://" + host, "hapticd.view.v1");
    };
    REQUIRE((open(page) == 101 && open(other) == 101));
    const Json hello = Json::parse(page.text_of("hello"));
    CHECK(hello["source"] == "log");
    CHECK(hello["session"] == "a.mcap");
    CHECK(hello["columns"] == Json{"session"});
    const auto tick_of = [&](test::SocketClient& client) {
      for (;;) {
        const Message message = client.message();
        if (message.opcode == -1) return -1.0;
        if (message.opcode != kBinary) continue;
        const auto frame = LayoutReader::numbers(message.bytes);
        const auto sequence = static_cast<int64_t>(layout.one(frame, "sequence"));
        client.tell(R"({"type":"shown","sequence":)" + std::to_string(sequence) + "}");
        return layout.one(frame, "tick");
      }
    };
    CHECK(tick_of(page) == kFirst);
    page.tell(R"({"type":"seek","tick":777})");
    CHECK(tick_of(page) == 777);
    page.tell(R"({"type":"play","speed":4})");
    CHECK(tick_of(page) > 777);
    CHECK(tick_of(other) == kFirst);
    // until the survey has the marks
    std::string marks;
    for (int i = 0; i < 200 && marks.find("fault") == std::string::npos; ++i) {
      marks = test::get(port, "/scene.json").body;
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    other.tell(R"({"type":"next","kind":"fault","direction":1})");
    CHECK(tick_of(other) == 900);
    const test::Reply table = test::get(port, "/export.csv?from=100&to=109");
    CHECK(table.status == 200);
    CHECK(std::count(table.body.begin(), table.body.end(), '\n') == 11);
    CHECK(Json::parse(test::get(port, "/overview.json?from=0.1&to=2&columns=9").body)["time"]
              .size() == 9);
    CHECK(test::get(port, "/overview.json").status == 400);
    test::SocketClient foxglove(port);
    CHECK(foxglove.upgrade("/", host, "", "foxglove.sdk.v1") == 400);
  }
  stop = true;
  thread.join();
}

}  // namespace haptic
