// SPDX-License-Identifier: GPL-3.0-or-later
// Session files with typing errors and arbitrary damage: refused in one line, or all values finite.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

#include "proto/config/config.h"
#include "proto/config/config_warnings.h"
#include "tests/fuzz/fuzz_run.h"
#include "tests/fuzz/hostile_input.h"
#include "tests/support/config_text.h"
#include "tests/support/data.h"

namespace haptic {
namespace {

using test::FuzzRandom;

using Lines = std::vector<std::string>;

Lines lines_of(const std::string& text) {
  Lines lines;
  for (size_t begin = 0; begin < text.size();) {
    const size_t end = std::min(text.find('\n', begin), text.size());
    lines.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return lines;
}

std::string text_of(const Lines& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  return text;
}

/// The session files of the tree, without their comments: every key there is.
std::vector<Lines> valid_files() {
  std::vector<Lines> files{lines_of(test::kScene)};
  for (const auto& entry : std::filesystem::directory_iterator(test::from_source("configs"))) {
    if (entry.path().extension() != ".toml") continue;
    Lines lines = lines_of(read_config_text(entry.path().string()));
    std::erase_if(lines, [](const std::string& line) { return line.empty() || line[0] == '#'; });
    files.push_back(lines);
  }
  std::sort(files.begin(), files.end());
  return files;
}

const std::vector<std::string> kValues{"0",
                                       "-1",
                                       "1e308",
                                       "-1e308",
                                       "1e-320",
                                       "nan",
                                       "inf",
                                       "-inf",
                                       "9223372036854775807",
                                       "-9223372036854775808",
                                       "18446744073709551616",
                                       "0x7fffffff",
                                       "true",
                                       "[]",
                                       "{}",
                                       "''",
                                       "\"\"",
                                       "\"0 m\"",
                                       "\"-0 mm\"",
                                       "\"1e308 m\"",
                                       "\"1e400 N/m\"",
                                       "\"nan N\"",
                                       "\"inf Hz\"",
                                       "\"1e-320 s\"",
                                       "\"0x10 mm\"",
                                       "\"1 parsec\"",
                                       "\" 1 mm \"",
                                       "\"1mm\"",
                                       "\"1 N·m/rad\"",
                                       "\"1e5 N/m\"",
                                       "\"360 deg\"",
                                       "\"1e300 deg\"",
                                       "[\"1 mm\"]",
                                       "[\"1 mm\", 2, \"x\"]",
                                       "[\"1e200 m\", \"1e200 m\", \"1e200 m\"]",
                                       "[0, 0, 0]",
                                       "[1e300, 1e300, 1e300]",
                                       "[1e-300, 0, 0]",
                                       "[nan, 0, 0]",
                                       "[0, 0, 0, 0]",
                                       "1979-05-27T07:32:00Z",
                                       "\"\\u0000\"",
                                       "\"\\n\\u001b[2J\"",
                                       "\"primitive:box\"",
                                       "\"../../../../dev/zero\"",
                                       "\"/dev/zero\"",
                                       "\"/\"",
                                       "\"voxel\"",
                                       "\"god-object6\"",
                                       "\"virtual-proxy3\"",
                                       "\"woodenhaptics\"",
                                       "\"replay\"",
                                       "\"screw\"",
                                       "\"gear\"",
                                       "4294967296",
                                       "0.1",
                                       "1_000",
                                       "07",
                                       "+0.0",
                                       "\"9999999 kHz\""};

const std::vector<std::string> kWords{"[",
                                      "]",
                                      "[[object]]\n",
                                      "=",
                                      ".",
                                      "\"",
                                      "\\",
                                      "\"\"\"",
                                      "'''",
                                      "#",
                                      "{",
                                      "}",
                                      ",",
                                      "\xff\xfe",
                                      "\xc2\xb7",
                                      "\r\n",
                                      "nan",
                                      "\xef\xbb\xbf",
                                      "object.x = 1\n"};

/// A user's error: a wrong value, or a line missing, doubled or from another file.
void change_line(Lines& lines, const std::vector<Lines>& files, FuzzRandom& random) {
  const size_t at = random.below(lines.size());
  const std::string& line = lines[at];
  const size_t equals = line.find('=');
  switch (random.below(6)) {
    case 0:
      lines.erase(lines.begin() + static_cast<std::ptrdiff_t>(at));
      return;
    case 1:
      lines.insert(lines.begin() + static_cast<std::ptrdiff_t>(at),
                   random.pick(random.pick(files)));
      return;
    case 2:
      std::swap(lines[at], lines[random.below(lines.size())]);
      return;
    default:
      if (equals != std::string::npos) {
        lines[at] = line.substr(0, equals + 1) + " " + random.pick(kValues);
      }
  }
}

/// Tables, arrays or keys, nested in each other.
std::string nested(FuzzRandom& random) {
  const std::vector<std::string> opens{"[", "{a=", "a.", "[[a.", "(", "\"\"\"\\"};
  const std::string& open = random.pick(opens);
  std::string text = random.below(2) == 0 ? "x = " : "";
  const size_t depth = size_t{1} << random.below(16);
  for (size_t i = 0; i < depth && text.size() < kMostConfigText; ++i) text += open;
  return text + "b = 1\n";
}

std::string input(const std::vector<Lines>& files, const test::Damage& damage, FuzzRandom& random) {
  Lines lines = random.pick(files);
  const size_t kind = random.below(8);
  if (kind == 0) return text_of(lines) + nested(random);
  for (size_t left = 1 + random.below(3); left > 0 && lines.size() > 1; --left) {
    change_line(lines, files, random);
  }
  const std::string text = text_of(lines);
  return kind == 1 ? damage.apply(text, random, kMostConfigText) : text;
}

/// Every number of a generated mesh.
bool is_finite(const Primitive& made) {
  return std::visit(
      [](const auto& kind) {
        double words[sizeof(kind) / sizeof(double) + 1] = {};
        std::memcpy(words, &kind, sizeof kind);
        return std::all_of(std::begin(words), std::end(words),
                           [](double w) { return std::isfinite(w); });
      },
      made);
}

/// Every number of a session, text read as numbers too: valid UTF-8 is never NaN.
bool is_finite(SessionConfig config) {
  // any integers, also such whose bits are no finite real
  config.device.hand.seed = 0;
  config.map.clutch_button = config.map.grasp_button = 0;
  // of a generated mesh those of its kind; the bytes that it does not use hold no numbers
  bool all = is_finite(config.tool.primitive);
  std::memset(static_cast<void*>(&config.tool.primitive), 0, sizeof config.tool.primitive);
  for (ObjectConfig& object : config.objects) {
    all = all && is_finite(object.primitive);
    std::memset(static_cast<void*>(&object.primitive), 0, sizeof object.primitive);
  }
  // the images at its end have no numbers
  double words[(sizeof(SessionConfig) - sizeof(SessionConfig::images)) / sizeof(double)];
  std::memcpy(words, &config, sizeof words);
  return all &&
         std::all_of(std::begin(words), std::end(words), [](double w) { return std::isfinite(w); });
}

}  // namespace

TEST_CASE("fuzz: a session file is refused in one line or every number of it is finite") {
  const std::vector<Lines> files = valid_files();
  REQUIRE(files.size() > 5);
  const test::Damage damage(kWords);
  const std::string origin = test::from_source("configs/fuzzed.toml");
  test::FuzzRun fuzz("config", 1, 3000);
  fuzz.run([&](FuzzRandom& random) {
    const SessionConfig config = parse_config(input(files, damage, random), origin);
    if (!is_finite(config)) throw std::runtime_error("a number is not finite:\n");
    for (const std::string& line : config_warnings(config)) {
      if (!test::is_one_line(line)) throw std::runtime_error("warning:\n" + line);
    }
  });
  // the grammar must accept some inputs, and damage must be detected in some
  CHECK(fuzz.accepted() > fuzz.inputs() / 50);
  CHECK(fuzz.accepted() < fuzz.inputs() / 2);
}

}  // namespace haptic
