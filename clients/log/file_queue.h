// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <mutex>
#include <thread>
#include <vector>

namespace haptic {

/// Appends pieces to a file on a thread of its own: a disk that stands still for seconds, as one
/// does behind a large build, keeps nobody from draining the rings. Room for each piece is reserved
/// first, where the file system can. After an error nothing more is written, and the file may end
/// with a part of the piece that failed.
class FileQueue {
 public:
  /// The file is empty, and stays open until the queue is gone.
  explicit FileQueue(int file);
  /// Waits until all is written, or an error has ended it.
  ~FileQueue();
  FileQueue(const FileQueue&) = delete;
  FileQueue& operator=(const FileQueue&) = delete;

  /// Queues a piece; `reserve` bytes behind it are reserved with it. Waits while more than
  /// kMostWaiting bytes are queued already.
  void append(std::vector<char> bytes, uint64_t reserve);
  /// Waits until all that was queued is written, or an error has ended it.
  void wait();

  struct Written {
    int error = 0;       // errno; 0: none
    uint64_t bytes = 0;  // of whole pieces in the file
  };
  Written written() const;

  /// Gives the thread the scheduling policy and priority of the caller.
  void share_priority();

  static constexpr uint64_t kMostWaiting = 64 << 20;  // [bytes]; a minute at 1 MB/s, as heap has

 private:
  struct Piece {
    std::vector<char> bytes;
    uint64_t reserve;
  };
  void run();
  int write(const Piece& piece, uint64_t offset) const;  // errno

  int file_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Piece> pieces_;
  uint64_t waiting_ = 0;  // bytes that the pieces take, with the one being written
  Written written_;
  bool ends_ = false;
  std::thread thread_;
};

}  // namespace haptic
