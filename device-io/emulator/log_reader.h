// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdio>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "device-io/emulator/firmware.h"

namespace haptic {

/// Parses one row of the emulator's log. Throws std::runtime_error with the row if it is invalid.
EmulatorRecord parse_emulator_row(std::string_view row);

/// Reads the emulator's log while it is written: whole rows only, each once, in order.
class EmulatorLogReader {
 public:
  explicit EmulatorLogReader(std::string path) : path_(std::move(path)) {}

  /// Appends the rows written since the last call; none while there is no file. Throws
  /// std::runtime_error at an invalid row.
  void read(std::vector<EmulatorRecord>& out);

 private:
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };

  std::string path_;
  std::unique_ptr<std::FILE, Close> file_;
  std::string rest_;  // of an incomplete row
  bool header_ = true;
};

}  // namespace haptic
