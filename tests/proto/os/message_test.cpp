// SPDX-License-Identifier: GPL-3.0-or-later
#include "proto/os/message.h"

#include <catch2/catch.hpp>
#include <random>
#include <string>

#include "proto/config/config.h"
#include "tests/support/hostile_text.h"

namespace haptic {
namespace {

using test::problem_of_message;

}  // namespace

TEST_CASE("message: what a person can read stays as it is") {
  const std::string text =
      GENERATE(as<std::string>(), "", "a plain word", "Schädel.stl", "µm, 20 °, N·m", "頭蓋骨.ply",
               "a\\b and \"c\"", "\U0001f9b7.obj");
  CHECK(shown(text) == text);
  CHECK(one_line(text) == text);
}

TEST_CASE("message: control characters, marks of direction and broken bytes are written out") {
  const auto [text, escaped] = GENERATE(table<std::string, std::string>({
      {"a\nb\tc\rd", "a\\nb\\tc\\rd"},
      {"\x1b[31mred\x1b[0m", "\\x1b[31mred\\x1b[0m"},
      {std::string("nul\0!", 5), "nul\\x00!"},
      {"\x7f\b\a", "\\x7f\\x08\\x07"},
      {"\u009b31m", "\\u009b31m"},  // the one-character form of ESC [
      {"\x9b"
       "31m",
       "\\x9b31m"},                         // the same in Latin-1: no UTF-8
      {"gnp.\u202eexe", "gnp.\\u202eexe"},  // from right to left
      {"a\u2028b", "a\\u2028b"},            // ends a line
      {"Sch\xe4"
       "del",
       "Sch\\xe4del"},                               // Latin-1
      {"\xc0\xaf", "\\xc0\\xaf"},                    // overlong
      {"\xed\xa0\x80", "\\xed\\xa0\\x80"},           // half of a surrogate pair
      {"\xf4\x90\x80\x80", "\\xf4\\x90\\x80\\x80"},  // above U+10FFFF
      {"\xe2\x82", "\\xe2\\x82"},                    // cut within a character
  }));
  CHECK(shown(text) == escaped);
  CHECK(shown(escaped) == escaped);
}

TEST_CASE("message: what is long keeps both ends and says how long it was") {
  const std::string text = "begin" + std::string(5000, 'x') + "end";
  const std::string cut = shown(text);
  CHECK_THAT(cut, Catch::StartsWith("beginxxx") && Catch::Contains("…(5008 bytes)…") &&
                      Catch::EndsWith("xxxend"));
  CHECK(test::length(cut) == kLongestShown);
  CHECK(shown(cut) == cut);
  // the longest allowed, and one more
  CHECK(shown(std::string(kLongestShown, 'x')) == std::string(kLongestShown, 'x'));
  CHECK(test::length(shown(std::string(kLongestShown + 1, 'x'))) == kLongestShown);
  // characters are not cut in two, and a whole message keeps its remedy
  std::string umlauts;
  for (int i = 0; i < 3000; ++i) umlauts += "ä";
  const std::string line = one_line("x.stl:3: '" + umlauts + "' is no number; export it again");
  CHECK(problem_of_message(line + "\n") == "");
  CHECK_THAT(line, Catch::StartsWith("x.stl:3: 'ää") && Catch::EndsWith("; export it again"));
  CHECK(test::length(line) == kLongestMessage);
}

TEST_CASE("message: whatever the bytes are, one printable line comes out, twice the same") {
  std::mt19937 random(1);
  for (int i = 0; i < 3000; ++i) {
    std::string bytes(random() % 3000, '\0');
    // bytes of all kinds, or continuation bytes and controls only
    const unsigned base = i % 2 == 0 ? 0 : 0x80, span = i % 2 == 0 ? 256 : 0x70;
    for (char& c : bytes) c = static_cast<char>(base + random() % span);
    const std::string line = one_line(bytes);
    REQUIRE(problem_of_message(line + "\n") == "");
    REQUIRE(one_line(line) == line);
    REQUIRE(test::length(shown(bytes)) <= kLongestShown);
  }
}

TEST_CASE("message: the errors of the library are one line by themselves") {
  const std::string hostile = "x\n\x1b[2J" + std::string(5000, 'a');
  for (const std::string& what :
       {std::string(MessageError(hostile).what()), std::string(ConfigError(hostile).what())}) {
    CHECK(problem_of_message(what + "\n") == "");
  }
}

}  // namespace haptic
