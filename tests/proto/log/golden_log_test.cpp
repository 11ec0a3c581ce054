// SPDX-License-Identifier: GPL-3.0-or-later
// Recordings of each layout that there was. golden/layout_N.mcap is from the recorder of its time;
// the CSV files beside it are that program's own export of it, so they are the truth here.
#include <array>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "clients/log/trace_writer.h"
#include "proto/log/csv.h"
#include "proto/log/hand_trace.h"
#include "proto/log/trace.h"
#include "proto/wire/scene_pose.h"
#include "tests/support/data.h"

namespace haptic {
namespace {

constexpr uint32_t kOldest = 1;

/// The file of a layout: its log, or with a topic that topic's export.
std::string golden(uint32_t layout, std::string_view topic = "") {
  std::string name = "layout_" + std::to_string(layout) + ".";
  for (const char c : topic.substr(topic.empty() ? 0 : 1)) name += c == '/' ? '_' : c;
  return test::from_source("tests/proto/log/golden/" + name + (topic.empty() ? "mcap" : ".csv"));
}

/// The codes of layout 1's events had other meanings, so these are refused.
bool is_refused(uint32_t layout, std::string_view topic) {
  return layout == 1 && topic == kEventTopic.name;
}

using Rows = std::vector<std::map<std::string, std::string>>;

/// Cells of a table by column, as text.
Rows rows_of(std::istream& in) {
  const auto cells_of = [](const std::string& line) {
    std::vector<std::string> cells(1);
    for (const char c : line) c == ',' ? cells.emplace_back() : cells.back() += c, void();
    return cells;
  };
  std::string line;
  std::getline(in, line);
  const std::vector<std::string> columns = cells_of(line);
  Rows rows;
  while (std::getline(in, line)) {
    const std::vector<std::string> cells = cells_of(line);
    REQUIRE(cells.size() == columns.size());
    rows.emplace_back();
    for (size_t i = 0; i < cells.size(); ++i) rows.back()[columns[i]] = cells[i];
  }
  return rows;
}

Rows golden_rows(uint32_t layout, std::string_view topic) {
  std::ifstream file(golden(layout, topic));
  REQUIRE(file);
  return rows_of(file);
}

Rows exported_rows(uint32_t layout, const TopicInfo& topic) {
  std::stringstream text;
  export_csv(TraceReader(golden(layout)), topic, text);
  return rows_of(text);
}

/// The present name of a column of an old export; "": it is left out.
std::string column_now(const std::string& column) {
  static const std::map<std::string, std::pair<std::string, std::string>> kMoved{
      {"X_WO", {"objects", ".X_WO"}},
      {"V_WO", {"objects", ".V_WO"}},
      {"clearance", {"objects", ".clearance"}},
      {"object_impulse_W", {"pushes", ".impulse_W"}},
      {"object_impulse_time_W", {"pushes", ".impulse_time_W"}}};
  if (column == "clearance_m") return "objects[0].clearance_m";
  const bool is_gone = column == "reserved" || column == "free_fraction" ||
                       column.ends_with("].material") ||
                       column.find("].texture_uv[") < column.size();
  if (is_gone) return "";
  const size_t begin = std::min(column.find('['), column.size()), end = column.find(']') + 1;
  const auto moved = kMoved.find(column.substr(0, begin));
  if (moved == kMoved.end()) return column;
  const auto& [part, field] = moved->second;
  return part + column.substr(begin, end - begin) + field + column.substr(end);
}

ReplayConfig replay_of(const std::string& path) {
  ReplayConfig config;
  assign(config.path, path);
  return config;
}

/// The first few records that are wanted.
template <typename T, typename Wanted>
void cut(const TraceReader& from, TraceWriter& to, const Topic<T>& topic, int most, Wanted wanted) {
  from.for_each<T>(topic, [&](const T& record, const Stamp& stamp) {
    if (most > 0 && wanted(record)) most -= to.write(topic, record, stamp) ? 1 : 0;
  });
}

}  // namespace

// not a test: makes the golden files of this layout from a session (docs/adding.md)
TEST_CASE("cut a session to a golden log", "[.][golden-cut]") {
  const char* session = std::getenv("HAPTIC_GOLDEN_FROM");
  REQUIRE(session != nullptr);
  const TraceReader from(session);
  uint64_t touch = 0;
  from.for_each<ServoFrame>(servo_topic(kFirstHand), [&](const ServoFrame& frame, const Stamp&) {
    if (touch == 0 && frame.n_contacts > 0 && frame.depth > 1e-4) touch = frame.tick;
  });
  {
    // without the machine's name
    const McapMetadata about = from.mcap().metadata().at("recording");
    const std::string abi = std::to_string(kAbiMajor) + "." + std::to_string(kAbiMinor);
    TraceWriter to(golden(kAbiMajor), {{"abi", abi}, {"session", about.at("session")}});
    const auto any = [](const auto&) { return true; };
    cut(from, to, servo_topic(kFirstHand), 10,
        [&](const ServoFrame& f) { return f.tick + 2 >= touch; });
    cut(from, to, contact_topic(kFirstHand), 2,
        [](const ContactSet& s) { return s.contacts.empty() && s.seq >= 100; });
    cut(from, to, contact_topic(kFirstHand), 2,
        [](const ContactSet& s) { return !s.contacts.empty() && s.contacts.size() <= 6; });
    cut(from, to, kSimTopic, 2, any);
    cut(from, to, kControlTopic, 2, any);
    cut(from, to, kEventTopic, 4, any);
    REQUIRE(to.close());
  }
  for (const TopicInfo& topic : kTopics) {
    std::ofstream csv(golden(kAbiMajor, topic.name));
    export_csv(TraceReader(golden(kAbiMajor)), topic, csv);
  }
}

TEST_CASE("golden: there is a log of each layout, and it is small") {
  for (uint32_t layout = kOldest; layout <= kAbiMajor; ++layout) {
    CAPTURE(layout);
    REQUIRE(std::filesystem::exists(golden(layout)));
    CHECK(std::filesystem::file_size(golden(layout)) < 40'000);
    CHECK(TraceReader(golden(layout)).layout() == std::to_string(layout));
  }
}

TEST_CASE("golden: an old log exports what the program that recorded it exported") {
  const uint32_t layout = GENERATE(range(kOldest, kAbiMajor + 1));
  for (const TopicInfo& topic : kTopics) {
    CAPTURE(layout, topic.name);
    if (is_refused(layout, topic.name)) {
      CHECK_THROWS_WITH(exported_rows(layout, topic), Catch::Contains("had other meanings"));
      continue;
    }
    const Rows then = golden_rows(layout, topic.name), now = exported_rows(layout, topic);
    CHECK(then.size() >= 2);
    REQUIRE(now.size() == then.size());
    for (size_t i = 0; i < then.size(); ++i) {
      for (const auto& [column, cell] : then[i]) {
        const std::string name = column_now(column);
        if (name.empty()) continue;
        CAPTURE(i, column);
        REQUIRE(now[i].contains(name));
        CHECK(now[i].at(name) == cell);
      }
    }
  }
}

TEST_CASE("golden: an old export has the columns of the present layout") {
  // columns of array elements that are not in use are left out
  const auto plain_columns = [](uint32_t layout, const TopicInfo& topic) {
    std::set<std::string> columns;
    const Rows rows = exported_rows(layout, topic);
    for (const auto& [column, cell] : rows.at(0)) {
      if (column.find('[') == std::string::npos) columns.insert(column);
    }
    return columns;
  };
  for (uint32_t layout = kOldest; layout < kAbiMajor; ++layout) {
    for (const TopicInfo& topic : kTopics) {
      if (is_refused(layout, topic.name)) continue;
      CAPTURE(layout, topic.name);
      CHECK(plain_columns(layout, topic) == plain_columns(kAbiMajor, topic));
    }
  }
}

TEST_CASE("golden: what a layout lacks is what the table of defaults says") {
  for (uint32_t layout = kOldest; layout <= kAbiMajor; ++layout) {
    CAPTURE(layout);
    const TraceReader trace(golden(layout));
    const Rows then = golden_rows(layout, contact_topic(kFirstHand).name);
    const std::vector<ContactSet> sets = trace.read(contact_topic(kFirstHand));
    REQUIRE(sets.size() == then.size());
    bool any_clear = false;
    for (size_t i = 0; i < sets.size(); ++i) {
      // one clearance for all objects in layout 6, none before
      const double first = layout == 6 ? std::atof(then[i].at("clearance_m").c_str()) : 0;
      any_clear |= sets[i].objects[0].clearance > 0;
      if (layout > 6) continue;
      for (const ObjectSeen& object : sets[i].objects) CHECK(object.clearance == first);
      if (layout < 5) CHECK(sets[i].tool.mass == 0);
      if (layout < 4) CHECK(sets[i].renderer == 0);
      if (layout < 2) CHECK(sets[i].reseeds == 0);
    }
    CHECK(any_clear == (layout >= 6));
    for (const SceneFrame& scene : trace.read(kSimTopic)) {
      CHECK(!scene.objects.empty());
      for (uint32_t k = 0; layout < 12 && k < scene.objects.size(); ++k) {
        CHECK(scene.objects[k].t_ns == scene.t_ns);
        CHECK(scene.objects[k].extrapolation_ns == kExtrapolationNs);
        CHECK(scene.objects[k].response == k);
      }
      if (layout < 12) CHECK((scene.n_hands == 2 && scene.seen.size() == 32));
    }
    for (const ControlFrame& control : trace.read(kControlTopic)) {
      if (layout < 3) CHECK((control.armed == 1 && control.fault == 0));
      // 0: as the session's file says
      if (layout < 8) CHECK((control.leading == 0 && control.solver == 0));
    }
  }
}

TEST_CASE("golden: the reader says which layout it was, and what that lacks") {
  const auto notice = [](uint32_t layout, const auto& topic) {
    return TraceReader(golden(layout)).notice(*find_topic(topic.name));
  };
  CHECK(notice(kAbiMajor, contact_topic(kFirstHand)).empty());
  const std::string alone = " (0: no process said since when it was behind)";
  const std::string none = " (0: the coupling in force was not recorded)";
  const std::string still = " (0: no object could be pushed away)";
  const std::string servo =
      "device.F_hand_B (0: no device measured the hand's wrench), X_command_B (0: no device was "
      "commanded a pose), forgotten_impulse_W" +
      still + ", impulses_since_ns" + still + ", translational_stiffness" + none +
      ", rotational_stiffness" + none + ", behind_since_ns" + alone +
      ", pushes (16: all objects were counted), pushes.impulse_time_W" + still +
      ", felt (0: no client gave a wrench or planes)";
  CHECK(notice(6, servo_topic(kFirstHand)) == "recorded with layout 6; fields it lacks: " + servo);
  const auto contact = [&](const std::string& clearance) {
    return "skipped (0: it did not say), behind_since_ns" + alone + ", objects" + clearance +
           ", contacts.reduction (0: all had the weight of the set), contacts.giver (0: contact "
           "found "
           "them all), guides (0: guide rows were the last of the contacts), compliance (0: "
           "nothing "
           "gave way), wrenches (0: no client gave a wrench), givers (0: no client gave a wrench "
           "or "
           "planes)";
  };
  CHECK(notice(6, contact_topic(kFirstHand)) ==
        "recorded with layout 6; fields it lacks: " + contact("[].clearance (one value for all)"));
  CHECK(notice(5, contact_topic(kFirstHand)) ==
        "recorded with layout 5; fields it lacks: " + contact(".clearance (0: not known)"));
  CHECK(notice(5, servo_topic(kFirstHand)) == "recorded with layout 5; fields it lacks: " + servo);
  const std::string nobody = "(0: nobody led the hand), ";
  const std::string led = "X_WT_intent " + nobody + "intent_t_ns " + nobody + "leading " + nobody +
                          "solver (0: as the session's file said), giving (0: no client gave)";
  CHECK(notice(7, kControlTopic) == "recorded with layout 7; fields it lacks: " + led);
  CHECK(notice(2, kControlTopic) ==
        "recorded with layout 2; fields it lacks: armed (1: nothing had to be armed), fault (0: "
        "faults ended with their servo), " +
            led);
}

TEST_CASE("golden: a hand that was recorded with any layout plays") {
  const uint32_t layout = GENERATE(range(kOldest, kAbiMajor + 1));
  CAPTURE(layout);
  const HandTrace log = load_hand_trace(replay_of(golden(layout)));
  const HandTrace table = load_hand_trace(replay_of(golden(layout, servo_topic(kFirstHand).name)));
  CHECK(log.samples.size() >= 8);
  CHECK(log.notice.empty() == (layout == kAbiMajor));
  REQUIRE(log.samples.size() == table.samples.size());
  for (size_t i = 0; i < log.samples.size(); ++i) {
    // no padding: NOLINTNEXTLINE(bugprone-suspicious-memory-comparison)
    CHECK(std::memcmp(&log.samples[i], &table.samples[i], sizeof(DeviceState)) == 0);
  }
}

}  // namespace haptic
