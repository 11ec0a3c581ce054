// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdio>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "device-io/emulator/firmware.h"

namespace haptic {

/// One row of the emulator's log. Throws std::runtime_error that shows the row where it is none.
EmulatorRecord parse_emulator_row(std::string_view row);

/// Reads the emulator's log while it is being written: whole rows only, each once, in order.
class EmulatorLogReader {
 public:
  explicit EmulatorLogReader(std::string path) : path_(std::move(path)) {}

  /// Appends the rows that have come since the last call; none while there is no file. Throws
  /// std::runtime_error at a row that is none.
  void read(std::vector<EmulatorRecord>& out);

 private:
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };

  std::string path_;
  std::unique_ptr<std::FILE, Close> file_;
  std::string rest_;  // of a row that is not whole yet
  bool header_ = true;
};

}  // namespace haptic
