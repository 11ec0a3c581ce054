// SPDX-License-Identifier: GPL-3.0-or-later
#include "proto/os/help_text.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <sstream>

#include "proto/os/json.h"
#include "proto/os/message.h"

namespace haptic {

TEST_CASE("help text: wrapped by characters, not bytes, and examples as they are") {
  std::string words;
  for (int i = 0; i < 40; ++i) words += "grün ";
  HelpPage page{words, "prog [OPTION...]", {{"Options", {}}, {"Empty", {}}}, ""};
  page.groups[0].rows = {{"-a", words}, {"--an-option-with-a-long-name WORD", "short"}};
  const std::string example = "  " + std::string(100, 'x');
  page.footer = "Example:\n" + example;
  const std::string text = help_text(page);
  CAPTURE(text);
  CHECK(text.find("\n\nUsage: prog [OPTION...]\n\nOptions:\n  -a                      grün ") !=
        std::string::npos);
  CHECK(text.find("\n  --an-option-with-a-long-name WORD\n                          short\n") !=
        std::string::npos);
  CHECK(text.find("Empty") == std::string::npos);
  CHECK(text.ends_with("\nExample:\n" + example + "\n"));
  size_t longest = 0;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (line != example) longest = std::max(longest, count_characters(line));
  }
  CHECK(longest == 80);  // 11 words of 4 with 10 spaces, behind 26 columns
}

TEST_CASE("nearest word: few letters differ, or the word only goes on") {
  const std::vector<std::string_view> known{"output", "overwrite", "for", "plot"};
  CHECK(nearest_word("outptu", known) == "output");
  CHECK(nearest_word("out", known) == "output");
  CHECK(nearest_word("fro", known) == "for");
  CHECK(nearest_word("session", known) == "");
  CHECK(suggestion("plt", known) == "did you mean 'plot'?");
  CHECK(suggestion("session", known) == "known here: output, overwrite, for, plot");
}

TEST_CASE("JSON string: quotes, backslashes and control characters are escaped") {
  CHECK(json_line("a \"b\" \\ \n\x1f ü") == "\"a \\\"b\\\" \\\\ \\n\\u001f ü\"");
  CHECK(json_line("a\xff") == "\"a\ufffd\"");
}

TEST_CASE("JSON: one line with its keys in their order, and no number that is not finite") {
  const Json json{{"z", 500.0}, {"a", {1, 0.1, std::nan("")}}, {"e", Json::array()}, {"b", true}};
  CHECK(json_line(json) == R"({"z": 500, "a": [1, 0.1, null], "e": [], "b": true})");
  CHECK(json_lines({1, 2}) == "[\n  1,\n  2\n]\n");
}

}  // namespace haptic
