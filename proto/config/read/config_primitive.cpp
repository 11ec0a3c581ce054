// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <initializer_list>
#include <string>

#include "proto/config/read/config_shape.h"

namespace haptic {
namespace {

constexpr int64_t kMaxSubdivisions = 8;            // 1.3 million triangles
constexpr int64_t kMaxSteps = 1000;                // two million triangles
constexpr int64_t kMinTeeth = 6, kMaxTeeth = 200;  // of a gear
constexpr int64_t kMaxSideSteps = 250;             // 1.25 million triangles
constexpr uint32_t kToothSteps = 24;               // around a gear, for each of its teeth
// a socket's cavity: from a dish to one that holds the ball
constexpr Range kCovers{10 * kDegree, 150 * kDegree};

/// A length that must be there, and an example of it.
struct RequiredLength {
  std::string_view key;
  const char* example;
  double& out;
};

void read_lengths(Section& section, std::initializer_list<RequiredLength> lengths) {
  for (const auto& [key, example, out] : lengths) {
    section.require(key, std::string(key) + " = \"" + example + "\"");
    section.read_quantity(key, Dimension::kLength, kPositive, out);
  }
}

void read_extent(Section& section, Vec3& extent) {
  section.read_all({{"extent", Dimension::kLength, kPositive, extent,
                     "extent = [\"100 mm\", \"100 mm\", \"20 mm\"]"}});
}

void read_grid(Section& section, PartGrid& grid) {
  section.read_all({{"around", 3, kMaxSteps, grid.around}, {"along", 1, kMaxSteps, grid.along}});
}

/// Steps around a part that is made of sectors: a multiple of `sectors`, and the least of them.
void read_around(Section& section, uint32_t sectors, int64_t least, const char* who,
                 uint32_t& around) {
  section.read_integer("around", least, kMaxSteps, around);
  if (around % sectors != 0) {
    section.fail_at("around",
                    "is no multiple of " + std::to_string(sectors) + ", as " + who + " needs it");
  }
}

/// Throws ConfigError at the key if a part cannot be of these dimensions.
void refuse(const Section& section, bool is_wrong, std::string_view key, const char* why) {
  if (is_wrong) section.fail_at(key, why);
}

void read_sixfold(Section& section, uint32_t& around) {
  read_around(section, 6, 6, "this part", around);
}

void read_frame(Section& section, primitive::Frame& frame) {
  read_lengths(section, {{"length", "180 mm", frame.length},
                         {"width", "24 mm", frame.width},
                         {"diameter", "8 mm", frame.diameter}});
  read_around(section, 4, 8, "a hole", frame.around);
  refuse(section, frame.length < 4 * frame.width, "length",
         "is too short for its lugs; four widths are the least");
}

void read_thread(Section& section, primitive::Thread& thread) {
  read_lengths(section, {{"diameter", "20 mm", thread.diameter},
                         {"pitch", "2.5 mm", thread.pitch},
                         {"depth", "1.4 mm", thread.depth}});
  refuse(section, thread.depth >= 0.5 * thread.diameter, "depth",
         "reaches the axis; half the diameter is too much");
}

}  // namespace

void read_keys(Section& section, primitive::Box& box) {
  read_extent(section, box.extent);
}

void read_keys(Section& section, primitive::Sphere& sphere) {
  section.read_all(
      {{"size", Dimension::kLength, kMeshSizes, sphere.diameter, "size = \"100 mm\", the diameter"},
       {"subdivisions", 0, kMaxSubdivisions, sphere.subdivisions}});
}

void read_keys(Section& section, primitive::Peg& peg) {
  read_lengths(section, {{"diameter", "20 mm", peg.diameter}, {"length", "40 mm", peg.length}});
  read_grid(section, peg.grid);
}

void read_keys(Section& section, primitive::Hole& hole) {
  read_lengths(section, {{"diameter", "20 mm", hole.diameter},
                         {"length", "40 mm", hole.length},
                         {"clearance", "0.2 mm", hole.clearance},
                         {"block", "60 mm", hole.block}});
  read_grid(section, hole.grid);
  refuse(section, hole.diameter + 2 * hole.clearance >= hole.block, "block",
         "is no wider than the hole; diameter + 2 clearance must fit into it");
}

void read_keys(Section& section, primitive::Gear& gear) {
  section.read_all({{"teeth", kMinTeeth, kMaxTeeth, gear.teeth, "teeth = 20"}});
  read_lengths(section, {{"module", "3 mm", gear.module},
                         {"width", "10 mm", gear.width},
                         {"bore", "10 mm", gear.bore}});
  section.read_quantity("backlash", Dimension::kLength, kNotNegative, gear.backlash);
  gear.grid.around = std::min(kToothSteps * gear.teeth, static_cast<uint32_t>(kMaxSteps));
  read_grid(section, gear.grid);
  refuse(section, gear.bore >= gear.module * (gear.teeth - 2.5), "bore",
         "reaches the foot of the teeth, at module · (teeth - 2.5); make it smaller");
  refuse(section, gear.backlash >= gear.module, "backlash",
         "is as large as the module and leaves no teeth; write a part of a millimetre");
}

void read_keys(Section& section, primitive::Bolt& bolt) {
  read_thread(section, bolt);
  read_lengths(section, {{"length", "40 mm", bolt.length}});
  read_grid(section, bolt.grid);
}

void read_keys(Section& section, primitive::Nut& nut) {
  read_thread(section, nut);
  read_lengths(section, {{"clearance", "0.05 mm", nut.clearance},
                         {"height", "16 mm", nut.height},
                         {"width", "32 mm", nut.width}});
  nut.grid.along = 128;  // half a bolt's: it is about half as long
  read_grid(section, nut.grid);
  refuse(section, nut.diameter + 2 * nut.clearance >= nut.width, "width",
         "is no wider than the thread; diameter + 2 clearance must fit into it");
}

void read_keys(Section& section, primitive::LowerMolar& molar) {
  read_lengths(section, {{"width", "11 mm", molar.width}});
  read_sixfold(section, molar.around);
}

void read_keys(Section& section, primitive::UpperMolar& molar) {
  read_lengths(section,
               {{"width", "11 mm", molar.width}, {"clearance", "0.05 mm", molar.clearance}});
  read_sixfold(section, molar.around);
}

void read_keys(Section& section, primitive::JointBall& ball) {
  read_lengths(section, {{"diameter", "40 mm", ball.diameter},
                         {"stem", "16 mm", ball.stem},
                         {"length", "50 mm", ball.length}});
  read_sixfold(section, ball.around);
  refuse(section, ball.stem >= ball.diameter, "stem",
         "is no thinner than the ball; write less than its diameter");
  refuse(section, 2 * ball.length <= ball.diameter, "length",
         "ends within the ball; write more than half its diameter");
}

void read_keys(Section& section, primitive::JointSocket& socket) {
  read_lengths(section, {{"diameter", "40 mm", socket.diameter},
                         {"clearance", "0.1 mm", socket.clearance},
                         {"width", "60 mm", socket.width},
                         {"height", "30 mm", socket.height}});
  section.read_quantity("cover", Dimension::kAngle, kCovers, socket.cover);
  read_sixfold(section, socket.around);
  const double cavity = 0.5 * socket.diameter + socket.clearance;
  refuse(section, 2 * cavity >= socket.width, "width",
         "is no wider than the cavity; diameter + 2 clearance must fit into it");
  refuse(section, cavity >= socket.height, "height",
         "ends above the cavity; half the diameter and the clearance must fit into it");
}

void read_keys(Section& section, primitive::DimpledBall& ball) {
  read_lengths(section, {{"diameter", "42.7 mm", ball.diameter}, {"depth", "0.25 mm", ball.depth}});
  section.read_integer("along", 1, kMaxSideSteps, ball.along);
  refuse(section, 10 * ball.depth > ball.diameter, "depth",
         "is more than a tenth of the diameter; write less");
}

void read_keys(Section& section, primitive::FrameRail& rail) {
  read_frame(section, rail);
  read_lengths(section,
               {{"height", "16 mm", rail.height}, {"clearance", "0.1 mm", rail.clearance}});
  refuse(section, rail.diameter + 2 * rail.clearance > 0.5 * rail.width, "diameter",
         "leaves too little of the lugs; diameter + 2 clearance may be half the width");
  refuse(section, rail.height < 0.5 * rail.width, "height",
         "is lower than half the width, and the channel has no room below");
}

void read_keys(Section& section, primitive::PinRest& rest) {
  read_frame(section, rest);
  read_lengths(section, {{"height", "20 mm", rest.height}});
  refuse(section, rest.diameter > 0.5 * rest.width, "diameter",
         "is too thick for its post; half the width is the most");
}

void read_keys(Section& section, primitive::Window& window) {
  read_extent(section, window.extent);
  read_lengths(section, {{"width", "60 mm", window.width}, {"height", "40 mm", window.height}});
  refuse(section, window.width >= window.extent.x, "width",
         "is no less than that of the plate; make the extent larger");
  refuse(section, window.height >= window.extent.y, "height",
         "is no less than that of the plate; make the extent larger");
}

}  // namespace haptic
