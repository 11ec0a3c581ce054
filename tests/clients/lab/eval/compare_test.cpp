// SPDX-License-Identifier: GPL-3.0-or-later
// One hand pressed into a wall, through the ways of rendering: each against its closed form.
#include "clients/lab/eval/compare/compare.h"

#include <catch2/catch.hpp>
#include <fstream>
#include <sstream>

#include "clients/log/log_columns.h"
#include "proto/config/devices.h"
#include "proto/log/trace.h"
#include "tests/support/temporary_folder.h"

namespace haptic {
namespace {

constexpr double kCoupling = 500;  // [N/m]
constexpr double kPoint = 1000;    // of a point of the tool [N/m]
constexpr double kPoints = 10;     // from ten on, points share what ten would give
// of the 11 × 11 points on the face those of its edges face aside
constexpr double kContact = kPoints * kPoint * 81 / 121;  // [N/m]
constexpr double kTop = 0.04;                             // upper face of the wall [m]
constexpr double kHalf = 0.005;                           // of the tool's edge [m]
constexpr double kPress = 2e-3;  // the hand leads the tool's face so deep into the wall [m]

const char* const kScene = R"(
[session]
name = "wall"
renderer = "voxel"
[tool]
primitive = "box"
extent = ["10 mm", "10 mm", "10 mm"]
mass = "50 g"
[proxy]
contact_damping = "10 N·s/m"
[contact.voxel]
size = "1 mm"
offset_layers = 0
point_spacing = "1 mm"
stiffness = "1000 N/m"
[device]
kind = "simulated-hand"
max_force = "100 N"
[coupling]
stiffness = "500 N/m"
damping = "10 N·s/m"
rotational_stiffness = "2 N·m/rad"
rotational_damping = "0.01 N·m·s/rad"
[safety]
max_force = "50 N"
[[object]]
name = "wall"
primitive = "box"
extent = ["80 mm", "80 mm", "80 mm"]
)";

/// Down from 12 mm above the face, and held in it.
std::string hand_file(const std::string& path, double seconds) {
  std::ofstream csv(path);
  csv.precision(17);
  csv << "t_s,x_m,y_m,z_m\n";
  const double held = kTop + kHalf - kPress;
  for (int i = 0; i <= static_cast<int>(seconds * 1e3); ++i) {
    csv << i * 1e-3 << ",0,0," << held + std::max(0.0, 0.014 - 0.05 * std::max(0.0, i * 1e-3 - 0.1))
        << '\n';
  }
  return path;
}

CompareEval wall(const std::string& hand, const std::string& output) {
  CompareEval eval;
  eval.config = parse_config(kScene, "wall.toml");
  eval.config_text = kScene;
  use_trace(eval.config, hand);
  eval.columns = {"god-object6", "constrained6", "voxel/quasi-static", "voxel/penalty-dynamics",
                  "voxel/direct"};
  eval.output = output;
  return eval;
}

std::string bytes_of(const std::string& path) {
  std::stringstream all;
  all << std::ifstream(path, std::ios::binary).rdbuf();
  return all.str();
}

/// The depth of the tool's lower face in the wall, at the proxy.
double depth_of(const ServoFrame& frame) {
  return kTop - (frame.X_WP.p.z - kHalf);
}

}  // namespace

TEST_CASE("compare: springs in series are F/k deep, a constraint not at all, free space is free") {
  const test::TemporaryFolder folder;
  const std::string hand = hand_file(folder.path() + "/hand.csv", 2.5);
  const std::vector<CompareFigures> all = compare_renderers(wall(hand, folder.path() + "/a.mcap"));
  // coupling and contact in series; F is what both carry
  const TraceReader trace(folder.path() + "/a.mcap");
  for (const CompareFigures& column : all) {
    CAPTURE(column.name);
    const double felt = column.last.F_coupling_W.f.z;
    CHECK(column.free_ticks > 50);
    if (column.is_massless) CHECK(column.free_force == 0);
    if (column.name.starts_with("voxel") && column.name != "voxel/direct") {
      const ContactSet set =
          trace.read(Topic<ContactSet>{column_of_comparison(column.name).contact}).back();
      double contact = 0, moment = 0;
      for (const Contact& c : set.contacts) {
        contact += c.stiffness;
        moment += c.stiffness * (c.tool_point_T.z + kHalf - (c.object_point_O.z - kTop));
      }
      CHECK(contact == Approx(kContact).epsilon(1e-12));
      const double inset = moment / contact;  // points and field are stored in single precision
      const double force = (kPress - inset) * kCoupling * contact / (kCoupling + contact);
      CHECK(felt == Approx(force).epsilon(1e-7));
      CHECK(std::fabs(depth_of(column.last) - inset - force / contact) < 1e-9);
    } else if (column.name == "god-object6") {
      CHECK(depth_of(column.last) < 1e-9);
      CHECK(column.depth_max < 1e-9);
      // its proxy keeps a small distance: the margin of the verified pose
      CHECK(felt == Approx(kCoupling * (kPress - depth_of(column.last))).epsilon(1e-9));
    } else if (column.name == "voxel/direct") {
      CHECK(depth_of(column.last) == Approx(kPress).epsilon(1e-9));
    }
  }
  CHECK(all[0].is_massless);
  CHECK_FALSE(all[3].is_massless);
  CHECK(all[3].free_force > 0);
}

TEST_CASE("compare: the same comparison is the same file, with the topics of each column") {
  const test::TemporaryFolder folder;
  const std::string hand = hand_file(folder.path() + "/hand.csv", 0.5);
  const std::string a = folder.path() + "/a.mcap", b = folder.path() + "/b.mcap";
  compare_renderers(wall(hand, a));
  compare_renderers(wall(hand, b));
  const std::string bytes = bytes_of(a);
  CHECK(bytes.size() > 10'000);
  CHECK(bytes == bytes_of(b));
  const TraceReader trace(a);
  const std::vector<LogColumn> columns = log_columns(trace);
  REQUIRE(columns.size() == 5);
  CHECK(columns[2].name == "voxel/quasi-static");
  for (const LogColumn& column : columns) {
    CHECK(trace.read(Topic<ServoFrame>{column.servo}).size() == 501);
    CHECK(trace.read(Topic<ContactSet>{column.contact}).size() > 490);
  }
}

TEST_CASE("compare: each column has its place among the ways of rendering") {
  const CompareEval eval = wall("hand.csv", "");
  const auto way = [&](const std::string& column) {
    return way_of_column(config_of_column(eval.config, column));
  };
  CHECK(way("voxel/direct") == "direct, penalty");
  CHECK(way("direct6") == "direct, penalty");
  CHECK(way("voxel") == "virtual coupling, penalty");
  CHECK(way("god-object6") == "virtual coupling, constraint");
  CHECK_THROWS_WITH(way("voxel/magic"), Catch::Contains("penalty-dynamics"));
  CHECK_THROWS_WITH(way("god-object6/direct"), Catch::Contains("only voxel, direct6"));
  CHECK_THROWS(way("nothing"));
}

}  // namespace haptic
