// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "device-io/emulator/log_reader.h"
#include "tests/process/hapticd_process.h"

namespace haptic::test {

/// A WoodenHaptics behind a pseudo-terminal, with its own log of what it received.
class EmulatorProcess : public ProgramProcess {
 public:
  EmulatorProcess(std::vector<std::string> arguments, const std::string& folder)
      : ProgramProcess("haptic-emulator", with_files(std::move(arguments), folder), folder),
        link_(folder + "/device"),
        csv_(folder + "/received.csv") {
    eventually([&] { return std::filesystem::is_symlink(link_) || !is_alive(uint64_t(pid())); });
  }

  /// Path of its device node.
  const std::string& link() const { return link_; }

  /// All records in the log so far, in order.
  std::vector<EmulatorRecord> records() const {
    std::vector<EmulatorRecord> out;
    EmulatorLogReader(csv_).read(out);
    return out;
  }

 private:
  static std::vector<std::string> with_files(std::vector<std::string> arguments,
                                             const std::string& folder) {
    for (const char* word : {"--link", "/device", "--log", "/received.csv"}) {
      arguments.push_back(word[0] == '/' ? folder + word : word);
    }
    // real-time if granted, so that a busy machine does not delay the device
    arguments.push_back("--realtime");
    return arguments;
  }

  std::string link_, csv_;
};

}  // namespace haptic::test
