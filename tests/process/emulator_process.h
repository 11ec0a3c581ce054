// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <sstream>
#include <string>
#include <vector>

#include "device-io/emulator_firmware.h"
#include "tests/process/hapticd_process.h"

namespace haptic::test {

/// A WoodenHaptics behind a pseudo-terminal, and its own account of what it received.
class EmulatorProcess : public ProgramProcess {
 public:
  EmulatorProcess(std::vector<std::string> arguments, const std::string& folder)
      : ProgramProcess("haptic-emulator", with_files(std::move(arguments), folder), folder),
        link_(folder + "/device"),
        csv_(folder + "/received.csv") {
    eventually([&] { return std::filesystem::is_symlink(link_) || !is_alive(uint64_t(pid())); });
  }

  /// Name of its node.
  const std::string& link() const { return link_; }

  /// All records in the log by now, in order.
  std::vector<EmulatorRecord> records() const {
    std::ostringstream text;
    text << std::ifstream(csv_).rdbuf();
    std::string all = text.str();
    all.resize(all.rfind('\n') == std::string::npos ? 0 : all.rfind('\n') + 1);
    std::istringstream lines(all);
    std::string line;
    std::getline(lines, line);
    std::vector<EmulatorRecord> out;
    while (std::getline(lines, line)) out.push_back(parse(line));
    return out;
  }

 private:
  static std::vector<std::string> with_files(std::vector<std::string> arguments,
                                             const std::string& folder) {
    for (const char* word : {"--link", "/device", "--log", "/received.csv"}) {
      arguments.push_back(word[0] == '/' ? folder + word : word);
    }
    return arguments;
  }
  static EmulatorRecord parse(std::string line) {
    for (char& c : line) c = c == ',' ? ' ' : c;
    std::istringstream cells(line);
    EmulatorRecord r{};
    uint32_t event = 0;
    cells >> r.t_ns >> event >> r.motors_on >> r.commands >> r.rejected >> r.watchdog;
    for (int32_t& current : r.currents) cells >> current;
    for (int i = 0; i < 3; ++i) cells >> r.force_B[i];
    for (int i = 0; i < 3; ++i) cells >> r.p_B[i];
    for (int32_t& count : r.counts) cells >> count;
    for (int32_t& count : r.answered) cells >> count;
    r.event = static_cast<EmulatorEvent>(event);
    if (!cells) throw std::runtime_error("not a row of the emulator's log: " + line);
    return r;
  }

  std::string link_, csv_;
};

}  // namespace haptic::test
