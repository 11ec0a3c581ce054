// SPDX-License-Identifier: GPL-3.0-or-later
// hapt wire: the records of the rings and of recordings, field by field.
#include <fmt/format.h>

#include <iostream>
#include <memory>
#include <string>
#include <utility>

#include "clients/hapt/commands.h"
#include "proto/os/json.h"
#include "proto/wire/schema.h"

namespace haptic {
namespace {

constexpr std::string_view kIntroduction =
    R"(# The records

What the rings hold, what a recording holds, and what every client reads: `hapt wire` prints this page from the list that the structs themselves are made of, [proto/wire/records.def](../proto/wire/records.def). `hapt wire --json` says the same to programs, with the place of every field.

Numbers are little endian, and every record is a multiple of 8 bytes without padding. A `Vec3` is x, y, z; a `Pose` is position and orientation, a quaternion x, y, z, w; a `Twist` is v and ω; a `Wrench` is force and torque: all `double`. The frame is what the name ends with: W world, B device base, H handle, T tool, P proxy, G verified proxy, O object; `X_WT` is the pose of T in W, `V_WT` its velocity, both with the axes of W. *Since* is the layout that brought the field: an older recording is read with the value that stands there.

A list `T[≤ most]` has at most that many values, and lies behind all other fields: first how many there are, eight bytes of which the last four are zero, then room for `most`. A ring and the library's structs hold it so, a ring without the room that is not in use. A recording holds it as ROS 2 does: four bytes say how many, and behind the next multiple of eight, counted from behind the four bytes that a message of CDR begins with, come the values; where there are no values no gap follows. *Since* of a list says how many values it is taken to have had.

What nobody reads yet waits for what comes:

| field | comes with |
|---|---|
| `Contact::giver`, the flag *given* of a set | clients that push and touch |
| `GuideRow::guide`, `tangent_O`, `curvature`, `stiffness`, `flags` | guides that lead a hand along paths; the flag *field* of a set with fields that pull |
| `behind_since_ns` of three processes | the words of a process that has fallen behind |
| `ContactSet::compliance` | objects that give way |
| the segments of points and of edits | what clients draw; paint, clay and drills, which change shapes |
| `SceneFrame::flags` | nothing yet: it fills a word |
)";

/// The unit at the start of a field's doc, or that of its type; and the rest.
std::pair<std::string, std::string> unit_and_text(const RecordField& field) {
  const std::string doc(field.doc);
  if (doc.starts_with('[')) {
    const size_t end = doc.find("] ");
    return {doc.substr(1, end - 1), doc.substr(end + 2)};
  }
  const std::string_view type = field.type;
  return {type == "Pose"     ? "m, 1"
          : type == "Twist"  ? "m/s, rad/s"
          : type == "Wrench" ? "N, N·m"
                             : "",
          doc};
}

/// "W", or of X_WT and V_WT "T in W"; empty: the name ends with none.
std::string frame_of(std::string_view name) {
  constexpr std::string_view kFrames = "WBHTPGO";
  const auto are_frames = [&](std::string_view letters) {
    return !letters.empty() && letters.find_first_not_of(kFrames) == letters.npos;
  };
  const size_t first = name.find('_');
  if (first == name.npos) return "";
  const std::string_view pair = name.substr(first + 1, 2), last = name.substr(name.rfind('_') + 1);
  if (first == 1 && pair.size() == 2 && are_frames(pair)) {
    return fmt::format("{} in {}", pair[1], pair[0]);
  }
  return last.size() == 1 && are_frames(last) ? std::string(last) : "";
}

std::string value_of(const Since& since) {
  return since.value == kOwnIndex ? "its index" : std::to_string(since.value);
}

std::string row_of(const RecordField& field) {
  const auto [unit, text] = unit_and_text(field);
  const std::string count =
      field.count > 0 ? fmt::format("[{}{}]", field.is_part ? "≤ " : "", field.count) : "";
  const Since& since = field.since;
  const std::string age =
      since.layout > 1 ? fmt::format("{}: {}, {}", since.layout, value_of(since), since.why) : "";
  return fmt::format("| `{}` | {}{} | {} | {} | {} | {} | {} | {} |\n", field.name, field.type,
                     count, field.offset, unit, frame_of(field.name), text,
                     field.readers.empty() ? "nobody yet" : field.readers, age);
}

void print_page(std::ostream& out) {
  out << kIntroduction;
  for (const RecordRow& record : all_records()) {
    out << fmt::format("\n## {}\n{} Written by {}; {} bytes.\n\n", record.name, record.doc,
                       record.writer, record.size)
        << "| field | type | at | unit | frame | what it is | read by | since |\n"
        << "|---|---|---|---|---|---|---|---|\n";
    for (const RecordField& field : record.fields) out << row_of(field);
  }
}

Json layout_of(const RecordRow& record) {
  Json fields = Json::array();
  for (const RecordField& field : record.fields) {
    const auto [unit, text] = unit_and_text(field);
    Json row{{"name", field.name},     {"type", field.type},         {"count", field.count},
             {"offset", field.offset}, {"size", field.size},         {"unit", unit},
             {"what", text},           {"since", field.since.layout}};
    if (field.is_part) row["is_part"] = true;
    fields.push_back(std::move(row));
  }
  return {{"size", record.size}, {"fields", fields}};
}

void print_layouts(std::ostream& out) {
  Json records;
  for (const RecordRow& record : all_records()) {
    records[std::string(record.name)] = layout_of(record);
  }
  out << json_line({{"abi", kAbiMajor}, {"records", records}}) << '\n';
}

}  // namespace

void add_wire_command(Command& app) {
  const auto as_json = std::make_shared<bool>(false);
  Command command = app.subcommand("wire", "Print the records of the rings, field by field");
  command.flag("--json", *as_json, "for programs, with the place of every field");
  command.example("hapt wire --json");
  command.action([as_json] { *as_json ? print_layouts(std::cout) : print_page(std::cout); });
}

}  // namespace haptic
