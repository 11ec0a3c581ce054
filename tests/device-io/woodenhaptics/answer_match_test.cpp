// SPDX-License-Identifier: GPL-3.0-or-later
// Matching of answers to questions, with a board written here from the description of the firmware,
// honest and with each way of being late or frozen.
#include "device-io/woodenhaptics/answer_match.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <deque>
#include <string>

#include "tests/support/torture_scale.h"

using haptic::AnswerMatch;

namespace {

/// The firmware's answer to a text: an error for each ']' in it.
std::deque<int> answers_to(std::string_view text) {
  std::deque<int> out;
  std::string line;
  for (const char c : text) {
    line += c;
    if (c != ']') continue;
    const bool begun = line.find('[') != std::string::npos;
    out.push_back(!begun ? 256 : std::count(line.begin(), line.end(), ',') != 2 ? 512 : 0);
    line.clear();
  }
  return out;
}

/// Like the driver: a question in each tick if none is pending, else again after five ticks.
struct Line {
  AnswerMatch match;
  int waited = 0, questions = 0, challenges = 0, accepted = 0;
  bool awaiting = false, newest_matches = false;

  std::deque<int> ask() {
    waited = awaiting ? waited + 1 : 0;
    if (awaiting && waited % 5 != 0) return {};
    const haptic::Challenge before = match.ask(true);
    awaiting = true;
    ++questions;
    challenges += before != haptic::Challenge::kNone;
    return answers_to(haptic::encode_currents({1, -2, 3}, before).view());
  }
  void hear(const std::deque<int>& errors, bool excused = false) {
    bool any = false;
    for (const int error : errors) any = !match.hear(error, excused) && error == 0;
    if (any && !match.awaits_echo()) awaiting = false;
    newest_matches = any && match.is_settled();
    accepted += newest_matches;
  }
};

constexpr int kMostTicks = AnswerMatch::kMostApart + 1;  // until a lie is noticed

}  // namespace

TEST_CASE("answers: an honest device is believed, and every tick has its sample", "[device-io]") {
  Line line;
  const auto n = static_cast<int>(haptic::test::trials(1'000'000));
  for (int i = 0; i < n; ++i) {
    line.hear(line.ask());
    REQUIRE(line.newest_matches);
    REQUIRE_FALSE(line.match.is_distrusted());
  }
  CHECK(line.questions == n);
  CHECK(line.challenges * AnswerMatch::kFewestApart <= n);
  CHECK((line.challenges + 1) * AnswerMatch::kMostApart >= n);
}

TEST_CASE("answers: the same answer for ever is noticed and never believed again", "[device-io]") {
  Line line;
  // per line, or per write
  const bool to_lines = GENERATE(false, true);
  const int before = GENERATE(0, 7, 20, 39);
  for (int i = 0; i < before; ++i) line.hear(line.ask());
  int noticed = 0;
  for (int i = 0; i < 1000; ++i) {
    std::deque<int> said = line.ask();
    if (!to_lines && said.size() > 1) said.resize(1);
    std::fill(said.begin(), said.end(), 0);
    line.hear(said);
    if (noticed == 0 && !line.match.is_settled()) noticed = i + 1;
    if (noticed > 0) REQUIRE_FALSE(line.newest_matches);
  }
  CHECK(noticed > 0);
  CHECK(noticed <= kMostTicks);
}

TEST_CASE("answers: from a queue they are noticed, however long it is", "[device-io]") {
  const size_t length = GENERATE(1, 2, 3, 5, 10, 16, 24, 31, 100, 1000, 5000);
  Line line;
  std::deque<int> queue(length, 0);
  int noticed = 0, distrusted = 0, starved = 0, most_starved = 0;
  for (int i = 0; i < 400; ++i) {
    std::deque<int> said;
    for (const int answer : line.ask()) {
      queue.push_back(answer);
      said.push_back(queue.front());
      queue.pop_front();
    }
    line.hear(said);
    starved = line.newest_matches ? 0 : starved + 1;
    most_starved = std::max(starved, most_starved);
    if (noticed == 0 && !line.newest_matches) noticed = i + 1;
    if (distrusted == 0 && (line.match.is_distrusted() || starved > 20)) distrusted = i + 1;
  }
  CAPTURE(length, noticed, distrusted, most_starved);
  CHECK(noticed > 0);
  CHECK(noticed <= kMostTicks);
  CHECK(distrusted > 0);
  CHECK(distrusted <= 100);
}

TEST_CASE("answers: old ones before the new ones are noticed, wherever the reads fall",
          "[device-io]") {
  const size_t old = GENERATE(1, 2, 5);
  // the old answers at once and the new ones a tick later; or all at once
  const bool split = GENERATE(false, true);
  Line line;
  std::deque<int> late;
  int distrusted = 0, starved = 0;
  for (int i = 0; i < 400 && distrusted == 0; ++i) {
    const std::deque<int> asked = line.ask();
    std::deque<int> said = late;
    late.clear();
    if (!asked.empty()) said.insert(said.end(), old, 0);
    auto& then = split ? late : said;
    then.insert(then.end(), asked.begin(), asked.end());
    line.hear(said);
    starved = line.newest_matches ? 0 : starved + 1;
    if (line.match.is_distrusted() || starved > 20) distrusted = i + 1;
  }
  CAPTURE(old, split);
  CHECK(distrusted > 0);
  CHECK(distrusted <= 100);
}

TEST_CASE("answers: one that was lost, or came late, is made up for by the next challenge",
          "[device-io]") {
  Line line;
  for (int i = 0; i < 100; ++i) line.hear(line.ask());
  const bool late = GENERATE(false, true);
  const std::deque<int> held = line.ask();
  for (int i = 0; i < 6; ++i) line.hear(line.awaiting && i < 5 ? std::deque<int>{} : line.ask());
  if (late) line.hear(held);
  int missing = 0;
  for (int i = 0; i < 100; ++i) {
    line.hear(line.ask());
    missing += !line.newest_matches;
  }
  CHECK(missing <= 6);
  CHECK(line.match.is_settled());
  CHECK_FALSE(line.match.is_distrusted());
}

TEST_CASE("answers: to lines that hapticd has sent they cost a sample and no trust",
          "[device-io]") {
  Line line;
  for (int round = 0; round < 200; ++round) {
    std::deque<int> said = line.ask();
    said.insert(said.end(), 4, 0);
    line.hear(said, true);
    CHECK_FALSE(line.newest_matches);
    int missing = 0;
    for (int i = 0; i < 3; ++i) {
      line.hear(line.ask());
      missing += !line.newest_matches;
    }
    REQUIRE(missing == 0);
    REQUIRE_FALSE(line.match.is_distrusted());
  }
}
