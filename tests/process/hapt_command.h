// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdio>
#include <string>

#include "proto/os/programs.h"
#include "tests/process/hapticd_process.h"

namespace haptic::test {

struct Ran {
  int code = -1;
  std::string output;  // standard output and standard error
};

/// Runs a shell command line in the folder, with `hapt` and the other programs on the path.
inline Ran shell(const std::string& line, const std::string& folder) {
  const std::string all = "cd '" + folder + "' && PATH='" + program_folder().string() +
                          "':$PATH && { " + line + "\n} 2>&1";
  Ran ran;
  FILE* pipe = popen(all.c_str(), "r");
  REQUIRE(pipe != nullptr);
  char text[4096];
  while (const size_t n = std::fread(text, 1, sizeof text, pipe)) ran.output.append(text, n);
  const int status = pclose(pipe);
  ran.code = WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  return ran;
}

/// A quoted shell word with arbitrary bytes except zero.
inline std::string word(const std::string& text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

/// Runs `hapt` with these arguments.
inline Ran hapt(const std::string& words, const std::string& folder) {
  return shell("hapt " + words, folder);
}

inline bool has(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

inline size_t lines(const std::string& text) {
  return static_cast<size_t>(std::count(text.begin(), text.end(), '\n'));
}

/// The value of a figure in the output of `--json`; NaN if it is absent.
inline double figure(const std::string& json, const std::string& metric) {
  const std::string key = "\"metric\": \"" + metric + "\", \"value\": ";
  const size_t at = json.find(key);
  if (at == std::string::npos) return std::numeric_limits<double>::quiet_NaN();
  return std::strtod(json.c_str() + at + key.size(), nullptr);
}

}  // namespace haptic::test
