// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <cstdint>
#include <thread>

/// A disk as a busy or a full one is, for the calls of pwrite in the program that links it.
namespace haptic::test {

struct Disk {
  std::atomic<bool> stands{false};  // calls wait
  // [bytes] until a write falls short and the next one fails; after that there is room again
  std::atomic<int64_t> room{INT64_MAX};
};
extern Disk disk;

/// The disk stands still as long as this lives or move() is not called. A test in which somebody
/// waits for the disk ends all the same: it moves by itself after 20 s, which was_waited_for tells.
class StandingDisk {
 public:
  StandingDisk();
  ~StandingDisk() { move(); }
  void move();
  bool was_waited_for() const { return late_; }

 private:
  std::atomic<bool> late_{false}, done_{false};
  std::thread patience_;
};

}  // namespace haptic::test
