// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace haptic {

/// How far a long piece of work is and how long the rest will take, on standard error: one line
/// that overwrites itself on a terminal, from the first second on; nothing elsewhere.
class Progress {
 public:
  /// `total` pieces of work.
  Progress(std::string what, double total);
  /// Wipes the line.
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// So many pieces are done.
  void at(double done);
  /// One more piece is done.
  void step() { at(done_ + 1); }

 private:
  std::string what_;
  double total_, done_ = 0;
  bool is_terminal_, is_shown_ = false;
  int64_t start_ns_, last_ns_;
};

/// Work in stages that are named as they begin: a line for each, wiped when it is done.
class StageProgress {
 public:
  /// A share in [0, 1] of this stage is done.
  void at(std::string_view stage, double share);

 private:
  std::string stage_;
  std::optional<Progress> progress_;
};

/// "about 12 s left" after a share in (0, 1] of the work took so many seconds.
std::string time_left(double share, double seconds);

}  // namespace haptic
