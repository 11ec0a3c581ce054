// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/support/disk/standing_disk.h"

#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>

namespace haptic::test {

Disk disk;

StandingDisk::StandingDisk() {
  disk.stands = true;
  patience_ = std::thread([this] {
    for (int i = 0; i < 2000 && !done_; ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    late_ = !done_;
    disk.stands = false;
    disk.stands.notify_all();
  });
}

void StandingDisk::move() {
  done_ = true;
  if (patience_.joinable()) patience_.join();
}

}  // namespace haptic::test

extern "C" ssize_t pwrite(int file, const void* bytes, size_t size, off_t offset) {
  using haptic::test::disk;
  disk.stands.wait(true);
  const int64_t room = disk.room.load();
  const auto part = std::min(static_cast<int64_t>(size), room);
  if (part <= 0) {
    disk.room = INT64_MAX;
    errno = ENOSPC;
    return -1;
  }
  if (room != INT64_MAX) disk.room -= part;
  return ::syscall(SYS_pwrite64, file, bytes, static_cast<size_t>(part), offset);
}
