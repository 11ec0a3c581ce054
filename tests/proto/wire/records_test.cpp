// SPDX-License-Identifier: GPL-3.0-or-later
// The list of records against the sources that it speaks of.
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <sstream>
#include <string>

#include "proto/wire/parts.h"
#include "proto/wire/schema.h"
#include "tests/support/data.h"
#include "tests/support/frames.h"

namespace haptic {
namespace {

namespace fs = std::filesystem;

std::string text_of(const fs::path& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

bool is_source(const fs::path& path) {
  return path.extension() == ".h" || path.extension() == ".cpp";
}

/// The sources of a room, and the headers of proto/wire that they include: functions of records,
/// such as scene_pose.h. The list itself and what is made of it mention every field.
std::string sources_of(const std::string& room) {
  std::string all;
  for (const auto& file : fs::recursive_directory_iterator(test::from_source(room))) {
    if (is_source(file.path())) all += text_of(file.path());
  }
  for (const auto& file : fs::directory_iterator(test::from_source("proto/wire"))) {
    const std::string name = file.path().filename();
    const bool is_used = all.find("#include \"proto/wire/" + name + '"') != std::string::npos;
    if (is_source(file.path()) && name != "wire.h" && is_used) all += text_of(file.path());
  }
  return all;
}

/// Whether the text has `.name`, `->name` or `::name`.
bool mentions(const std::string& text, const std::string& name) {
  for (size_t at = 0; (at = text.find(name, at)) != std::string::npos; at += name.size()) {
    const size_t end = at + name.size();
    const char before = at > 0 ? text[at - 1] : ' ', after = end < text.size() ? text[end] : ' ';
    const bool ends = std::isalnum(static_cast<unsigned char>(after)) == 0 && after != '_';
    if (ends && (before == '.' || before == '>' || before == ':')) return true;
  }
  return false;
}

}  // namespace

TEST_CASE("records: each room that a field names as its reader mentions the field") {
  std::map<std::string, std::string> text;
  for (const RecordRow& record : all_records()) {
    for (const RecordField& field : record.fields) {
      std::istringstream rooms{std::string(field.readers)};
      for (std::string room; rooms >> room;) {
        if (room == "log") continue;
        if (!text.contains(room)) text[room] = sources_of(room);
        INFO(record.name << "::" << field.name << ": " << room
                         << " does not read it; correct its row in proto/wire/records.def");
        CHECK(mentions(text[room], std::string(field.name)));
      }
    }
  }
  CHECK(text.size() == 4);
}

TEST_CASE("records: of 256 still objects a servo's frame takes 4 kB at most, sim's 40 kB") {
  const auto scene = std::make_unique<SceneFrame>();
  scene->objects.resize(kMaxObjects);
  CHECK(test::bytes_in_use(*scene).size() <= 40'000);
  const auto frame = std::make_unique<ServoFrame>();
  frame->pushes.resize(scene->responses.size());
  CHECK(test::bytes_in_use(*frame).size() <= 4'000);
  // with 16 bodies that two hands push it was 11 kB, and of one object 2 kB
  scene->objects.resize(1);
  CHECK(test::bytes_in_use(*scene).size() <= 250);
}

TEST_CASE("records: the table of parts is what the list says") {
  size_t parts = 0;
  for (const RecordRow& record : all_records()) {
    for (const RecordField& field : record.fields) parts += field.is_part ? 1 : 0;
  }
  CHECK(parts == kParts<ServoFrame>.size() + kParts<ContactSet>.size() + kParts<SceneFrame>.size() +
                     kParts<GivenFrame>.size() + kParts<DrawnPiece>.size());
  constexpr RecordPart kSeen = kParts<SceneFrame>[3];
  CHECK(kSeen.offset == offsetof(SceneFrame, seen));
  CHECK(kSeen.element == sizeof(SeenPush));
  CHECK(kSeen.most == kMaxBodies * kMostHands);
}

}  // namespace haptic
