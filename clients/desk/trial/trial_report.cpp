// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/desk/trial/trial_report.h"

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "proto/os/file_descriptor.h"
#include "proto/os/message.h"
#include "proto/os/text.h"
#include "proto/os/version.h"

namespace haptic {
namespace {

constexpr std::array kVerdictWords{"passed", "unclear", "FAILED"};  // by Verdict

std::runtime_error unwritable(const std::string& path) {
  return std::runtime_error(shown(path) + ": cannot be written (" + std::strerror(errno) + ")");
}

}  // namespace

std::string words_of(const TrialRow& row) {
  const char* word = kVerdictWords[static_cast<size_t>(row.verdict)];
  return "  " + padded(word, 9) + row.what + ": " + row.measured;
}

std::vector<std::string> remarks_of(const TrialReport& report) {
  std::vector<std::string> lines{
      "report of `hapt devices try`, to be sent in by hand: nothing is sent by itself",
      "it holds facts about the device, its node and this machine, the steps with outcomes, and",
      "each byte of both sides; no name of a person or of the machine, no serial number, no path",
      "but that of a node below /dev",
      std::string("hapticd ") + version(),
      "kind: " + report.kind,
      "driver: " + report.description};
  lines.insert(lines.end(), report.facts.begin(), report.facts.end());
  for (const TriedStep& step : report.steps) {
    lines.push_back("step " + step.name + (step.ended.empty() ? "" : ": " + step.ended));
    for (const TrialRow& row : step.rows) lines.push_back(words_of(row));
  }
  lines.push_back("bytes: " + report.bytes);
  return lines;
}

void save_whole(const std::string& path, const std::function<void(std::ostream&)>& write) {
  std::error_code error;
  const bool is_other =
      std::filesystem::exists(path, error) && !std::filesystem::is_regular_file(path, error);
  std::string written = path;
  if (!is_other) {
    written += ".XXXXXX";
    if (!FileDescriptor(mkostemp(written.data(), O_CLOEXEC)).is_open()) throw unwritable(path);
  }
  std::ofstream out(written);
  write(out);
  out.close();
  if (out && (is_other || std::rename(written.c_str(), path.c_str()) == 0)) return;
  const std::runtime_error why = unwritable(path);
  if (!is_other) unlink(written.c_str());
  throw why;
}

}  // namespace haptic
