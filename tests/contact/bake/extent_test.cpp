// SPDX-License-Identifier: GPL-3.0-or-later
// The limits of a mesh's size, and the messages outside them.
#include <catch2/catch.hpp>
#include <fstream>
#include <string>

#include "contact/bake/bake.h"
#include "tests/support/hostile_text.h"
#include "tests/support/mesh_files.h"
#include "tests/support/temporary_folder.h"

namespace haptic {
namespace {

using Catch::Contains;

/// A cube of this edge in a file, baked without the cache.
class Cube {
 public:
  explicit Cube(double edge, const std::string& name = "cube.off")
      : path_(folder_.path() + "/" + name) {
    std::ofstream(path_) << test::as_off(make_box({edge, edge, edge}));
  }

  double size_at(double unit, double size) const {
    ShapeConfig object;
    assign(object.mesh, path_);
    object.unit = unit;
    object.size = size;
    return bake_object(object, test::kPlenty).report.size;
  }
  std::string problem_at(double unit, double size) const {
    return test::refusal<MeshError>([&] { size_at(unit, size); });
  }

 private:
  test::TemporaryCache folder_;
  std::string path_;
};

}  // namespace

TEST_CASE("bake: coordinates beyond all scenes are refused with file, figure and mend") {
  const Cube huge(2e150);
  for (const double unit : {1.0, 1e-3, 0.0}) {
    const std::string problem = huge.problem_at(unit, unit == 0 ? 0 : 0.1);
    CAPTURE(unit, problem);
    CHECK_THAT(problem, Contains("cube.off: its largest coordinate is 1e+150, at most ") &&
                            Contains("(1e+06 m) is allowed at unit ") &&
                            Contains("state the right unit, or unit = \"any\" and a size"));
    CHECK(test::problem_of_message(problem + "\n") == "");
  }
  CHECK_THAT(huge.problem_at(1e-3, 0), Contains("at most 1e+09 (1e+06 m)"));
  // scaled to its size it is valid
  CHECK(huge.size_at(0, 0.1) == Approx(0.1));
}

TEST_CASE("bake: a mesh is between a micrometre and a thousand kilometres long") {
  const Cube metre(1);
  CHECK(metre.size_at(1e-6, 0) == Approx(1e-6));
  CHECK(metre.size_at(0, 1e-6) == Approx(1e-6));
  CHECK(metre.size_at(1e6, 0) == Approx(1e6));
  CHECK(metre.size_at(0, 1e6) == Approx(1e6));
  CHECK_THAT(metre.problem_at(1e-7, 0),
             Contains("cube.off: its longest side is 1, at least 10 (1e-06 m) is wanted"));
  CHECK_THAT(metre.problem_at(1e-200, 0), Contains("its longest side is 1"));
  CHECK_THAT(metre.problem_at(3e6, 0), Contains("its largest coordinate is 0.5"));
  CHECK_THAT(metre.problem_at(1e300, 0), Contains("its largest coordinate is 0.5"));
  CHECK_THAT(Cube(1.7e308).problem_at(1, 0), Contains("its largest coordinate is 8.5e+307"));
}

TEST_CASE("bake: what is said of a file with a hostile name is one printable line") {
  const Cube cube(2e150, "\x1b[2J\n.off");
  const std::string problem = cube.problem_at(1, 0);
  CHECK_THAT(problem, Contains("\\x1b[2J\\n.off: its largest coordinate"));
  CHECK(test::problem_of_message(problem + "\n") == "");
}

}  // namespace haptic
