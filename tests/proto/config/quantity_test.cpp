// SPDX-License-Identifier: GPL-3.0-or-later
// One rule for quantities: errors in the text, and known units. The same at the inputs of the
// programs: tests/process/words/quantities_test.cpp.
#include "proto/config/quantity.h"

#include <catch2/catch.hpp>
#include <iostream>
#include <sstream>
#include <string>
#include <vector>

#include "proto/config/command_line.h"
#include "proto/config/read/config_shape.h"
#include "tests/support/config_text.h"
#include "tests/support/hostile_text.h"

namespace haptic {
namespace {

/// The error message for a length; empty if it is valid.
std::string problem_of(const std::string& text, const Range& range = kAny,
                       const std::string& bare_unit = "") {
  return test::refusal<QuantityError>(
      [&] { parse_quantity(text, Dimension::kLength, range, bare_unit); });
}

/// Standard error of a command line with `--size` and `--friction`.
struct Typed {
  std::optional<int> code;
  std::string said;
  double size = 0.5, friction = 0.25;
};

Typed type(std::vector<std::string> words) {
  Typed typed;
  CommandLine line("test", "a test");
  line.quantity("--size", typed.size, Dimension::kLength, {0.01, 1}, "a size", "m");
  line.number("--friction", typed.friction, {0, 10}, "μ");
  words.insert(words.begin(), "test");
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  std::ostringstream said;
  std::streambuf* const before = std::cerr.rdbuf(said.rdbuf());
  typed.code = line.read(static_cast<int>(argv.size()), argv.data());
  std::cerr.rdbuf(before);
  typed.said = said.str();
  return typed;
}

}  // namespace

TEST_CASE("quantity: what is wrong is said with the units that are known") {
  const auto [text, says] = GENERATE(table<std::string, std::string>({
      {"nan mm", "is not a finite number"},
      {"-inf mm", "is not a finite number"},
      {"1e300 m", "is too large; the most is 1e+06 m"},
      {"-1e300 m", "is too large; the most is 1e+06 m"},
      {"1e999 m", "is too large or too small"},
      {"80", "needs a unit"},
      {"8,5 mm", "has a comma; the decimal sign is a point, as in 8.5"},
      {"1,000 mm", "has a comma"},
      {"80 furlongs", "has an unknown unit"},
      {"80 mm mm", "has an unknown unit"},
      {"80 N", "is a force, not a length"},
      {"mm", "does not begin with a number"},
      {"", "does not begin with a number"},
      {"   ", "does not begin with a number"},
      {"+-1 mm", "does not begin with a number"},
      {"80\tmm", "\"80\\tmm\" has an unknown unit"},
      {"80 \x1b[31mmm", "\"80 \\x1b[31mmm\" has an unknown unit"},
      {"8 " + std::string(5000, 'm'), "…(5002 bytes)…"},
  }));
  CAPTURE(text);
  const std::string problem = problem_of(text);
  CHECK_THAT(problem, Catch::Contains(says) &&
                          Catch::EndsWith("; write for example \"100 mm\"; known units: m, cm, mm, "
                                          "um, µm, in"));
  CHECK(test::problem_of_message(problem + "\n") == "");
}

TEST_CASE("quantity: a bare number is meant in the unit that is said, where one is") {
  CHECK(parse_quantity("80", Dimension::kLength, kAny, "mm") == Approx(0.08));
  CHECK(parse_quantity("80 cm", Dimension::kLength, kAny, "mm") == Approx(0.8));
  CHECK(parse_quantity("+.5", Dimension::kTime, kAny, "min") == 30);
  CHECK(parse_quantity("0", Dimension::kLength, kAny, "m") == 0);
  CHECK_THAT(problem_of("1e300", kPositive, "m"), Catch::Contains("is too large"));
  CHECK_THAT(problem_of("nan", kPositive, "m"), Catch::Contains("not a finite number"));
}

TEST_CASE("quantity: a range is told with its unit and what was written") {
  CHECK(problem_of("20 m", {0.001, 10}) ==
        "is out of range (\"20 m\"); it must lie between 0.001 m and 10 m");
  CHECK(problem_of("0 m", kPositive) == "must be greater than 0 (\"0 m\"); write a larger value");
  CHECK(problem_of("-1 mm", kNotNegative) ==
        "must not be less than 0 (\"-1 mm\"); write a larger value");
  CHECK(problem_of("10 m", {0.001, 10}) == "");
}

TEST_CASE("quantity: of every kind what is beyond all reason is refused, and zero is not") {
  for (int i = 0; i <= static_cast<int>(Dimension::kMemory); ++i) {
    const auto dimension = static_cast<Dimension>(i);
    const std::string example(example_of(dimension));
    const std::string unit = example.substr(example.find(' '));
    CAPTURE(example);
    CHECK_THROWS_AS(parse_quantity("1e300" + unit, dimension), QuantityError);
    CHECK_THROWS_AS(parse_quantity("-1e300" + unit, dimension), QuantityError);
    CHECK(parse_quantity("0" + unit, dimension) == 0);
    CHECK_THAT(how_to_write(dimension), Catch::Contains("known units: "));
  }
}

TEST_CASE("quantity: a number without unit is a whole word, finite and in range") {
  CHECK(parse_number("0.5") == 0.5);
  CHECK(parse_number(" -2e3 ") == -2000);
  for (const std::string text :
       {"", "fast", "nan", "inf", "1e300", "1e999", "0,5", "0.5 m", "0.5.5", "\x1b"}) {
    CAPTURE(text);
    CHECK_THROWS_AS(parse_number(text), QuantityError);
  }
  CHECK_THROWS_WITH(parse_number("11", {0, 10}),
                    "is out of range (11); it must lie between 0 and 10");
}

TEST_CASE("quantity: the unit of a mesh is a word, a length, or any") {
  CHECK(parse_mesh_unit("mm") == 1e-3);
  CHECK(parse_mesh_unit("any") == 0);
  CHECK(parse_mesh_unit("25.4 mm") == Approx(0.0254));
  CHECK(parse_mesh_unit("0.001", "m") == 1e-3);
  CHECK_THROWS_WITH(parse_mesh_unit("0.001"), Catch::Contains("needs a unit"));
  for (const std::string text :
       {"", "nan", "inf", "1e300", "0", "-1", "8,5 mm", "furlong", "5 kg"}) {
    CAPTURE(text);
    CHECK_THROWS_AS(parse_mesh_unit(text, "m"), QuantityError);
  }
}

TEST_CASE("quantity: a number of a config that no scene can hold is refused at its place") {
  using test::error_of;
  using test::scene_with;
  CHECK_THAT(error_of(scene_with("[coupling]", "[map]\nmotion_scale = 1e300\n[coupling]")),
             Catch::StartsWith("x.toml:6:16: ") && Catch::Contains("is too large (1e+300)"));
  CHECK_THAT(error_of(scene_with("8 cm", "1e300 m")),
             Catch::StartsWith("x.toml:10:20: ") && Catch::Contains("is too large"));
}

TEST_CASE("quantity: a command line takes them with and without their unit") {
  CHECK(type({"--size", "80 mm"}).size == Approx(0.08));
  CHECK(type({"--size=8cm"}).size == Approx(0.08));
  CHECK(type({"--size", "0.08"}).size == 0.08);
  CHECK(type({"--friction", "3"}).friction == 3);
  const Typed none = type({});
  CHECK(none.size == 0.5);
  CHECK_FALSE(none.code);
}

TEST_CASE("quantity: what is typed wrongly is one line and changes nothing") {
  const auto [option, value] = GENERATE(table<std::string, std::string>({
      {"--size", "nan"},
      {"--size", "1e300"},
      {"--size", "2 m"},
      {"--size", "8,5 mm"},
      {"--size", "80 furlongs"},
      {"--size", "mm"},
      {"--size", ""},
      {"--size", "80 N"},
      {"--size", "80 \x1b[2Jmm"},
      {"--friction", "nan"},
      {"--friction", "11"},
      {"--friction", "0,5"},
      {"--friction", "0.5 m"},
      {"--friction", ""},
      {"--size", std::string(5000, '8')},
  }));
  CAPTURE(option, value);
  const Typed typed = type({option, value});
  CHECK(typed.code == 2);
  CHECK(typed.size == 0.5);
  CHECK(typed.friction == 0.25);
  CHECK_THAT(typed.said, Catch::StartsWith("test: " + option + ": "));
  CHECK(test::problem_of_message(typed.said) == "");
}

}  // namespace haptic
