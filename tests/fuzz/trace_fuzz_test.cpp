// SPDX-License-Identifier: GPL-3.0-or-later
// Recordings of a hand, as CSV and as exports: refused in one line, or finite with increasing time.
#include <catch2/catch.hpp>
#include <cmath>
#include <fstream>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "clients/log/trace_writer.h"
#include "proto/log/csv.h"
#include "proto/log/hand_trace.h"
#include "tests/fuzz/fuzz_run.h"
#include "tests/fuzz/hostile_input.h"
#include "tests/support/temporary_folder.h"

namespace haptic {
namespace {

using test::FuzzRandom;

constexpr int kRows = 20;

const std::vector<std::string> kCells{"0",
                                      "-0",
                                      "1e308",
                                      "-1e308",
                                      "1e-320",
                                      "nan",
                                      "inf",
                                      "-inf",
                                      "1e400",
                                      "9223372036854775807",
                                      "-9223372036854775808",
                                      "9.3e9",
                                      "-9.3e9",
                                      "1e18",
                                      "18446744073709551615",
                                      "0x10",
                                      "",
                                      " ",
                                      "+1",
                                      "1,5",
                                      "1.5.2",
                                      "left",
                                      "\"1\"",
                                      "1e",
                                      "\x00x",
                                      "\xff"};

/// A moving hand, in the form that users write.
std::string positions(bool turns) {
  std::string text = turns ? "t_s,x_m,y_m,z_m,qx,qy,qz,qw\n" : "t_s,x_m,y_m,z_m\n";
  for (int i = 0; i < kRows; ++i) {
    const double t = 1e-3 * i;
    text += std::to_string(t) + ",0.01," + std::to_string(0.1 * std::sin(t)) + ",-0.02";
    text += turns ? ",0,0,0.6,0.8\n" : "\n";
  }
  return text;
}

std::string lever() {
  std::string text = "t_s,lever_rad\n";
  for (int i = 0; i < kRows; ++i) text += std::to_string(5e-4 * i) + "," + std::to_string(i) + "\n";
  return text;
}

/// A recording in the form of the program's own export.
std::string exported(const std::string& folder) {
  const std::string path = folder + "/seed.mcap";
  {
    TraceWriter trace(path, {});
    for (int i = 0; i < kRows; ++i) {
      ServoFrame frame{};
      frame.tick = static_cast<uint64_t>(i);
      frame.t_ns = frame.device.t_ns = 1'000'000 * i;
      frame.device.flags = kDeviceFresh;
      frame.device.X_BH.p = {0.1 * i, 0, 1};
      trace.write(servo_topic(kFirstHand), frame, {frame.t_ns, frame.t_ns, frame.tick});
    }
  }
  std::ostringstream text;
  export_csv(TraceReader(path), *find_topic(servo_topic(kFirstHand).name), text);
  return text.str();
}

/// Replaces one cell of a table by an invalid or extreme number.
void change_cell(std::string& text, FuzzRandom& random) {
  const size_t row = text.find('\n', random.below(text.size()));
  if (row == std::string::npos) return;
  const size_t comma = text.find(',', row);
  const size_t begin = random.below(2) == 0 || comma == std::string::npos ? row + 1 : comma + 1;
  const size_t end = text.find_first_of(",\n", begin);
  if (end != std::string::npos) text.replace(begin, end - begin, random.pick(kCells));
}

void check(const HandTrace& trace) {
  for (size_t i = 0; i < trace.samples.size(); ++i) {
    const DeviceState& s = trace.samples[i];
    const bool finite = is_finite(s.X_BH) && is_finite(s.V_BH) && std::isfinite(s.grip);
    if (!finite) throw std::runtime_error("a number is not finite:\n");
    if (i > 0 && s.t_ns <= trace.samples[i - 1].t_ns) throw std::runtime_error("no order:\n");
  }
  if (!(trace.duration() > 0) || !std::isfinite(trace.duration())) {
    throw std::runtime_error("no duration:\n");
  }
}

}  // namespace

TEST_CASE("fuzz: a hand's recording is refused in one line or finite and forward in time") {
  const test::TemporaryFolder folder;
  const std::vector<std::string> seeds{positions(false), positions(true), lever(),
                                       exported(folder.path())};
  const test::Damage damage({"t_s", "x_m", "device.t_ns", ",", "\n", "\r\n", "nan", "1e308", "\"",
                             ";", "\t", "\xef\xbb\xbf", "-", "e"});
  const std::string path = folder.path() + "/hand.csv";
  test::FuzzRun fuzz("trace", 2, 4000);
  fuzz.run([&](FuzzRandom& random) {
    const size_t which = random.below(seeds.size());
    std::string text = seeds[which];
    for (size_t left = 1 + random.below(3); left > 0; --left) change_cell(text, random);
    if (random.below(2) == 0) text = damage.apply(text, random);
    std::ofstream(path, std::ios::binary) << text;
    ReplayConfig config;
    assign(config.path, path);
    if (which == 2) assign(config.column, "lever_rad");
    if (random.below(2) == 0) config.lever_arm = 0.075;
    check(load_hand_trace(config));
  });
  CHECK(fuzz.accepted() > fuzz.inputs() / 50);
  CHECK(fuzz.accepted() < fuzz.inputs() * 9 / 10);
}

}  // namespace haptic
