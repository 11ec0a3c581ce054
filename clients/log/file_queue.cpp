// SPDX-License-Identifier: Apache-2.0
#include "clients/log/file_queue.h"

#include <fcntl.h>
#include <pthread.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <span>
#include <utility>

#include "proto/os/regular_file.h"

namespace haptic {
namespace {

/// Reserves space from `offset` on, where the file system can. Returns false, with errno, if the
/// file may not grow by that much.
bool has_room(int file, uint64_t offset, uint64_t bytes) {
  rlimit limit{};
  if (::getrlimit(RLIMIT_FSIZE, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY &&
      offset + bytes > limit.rlim_cur) {
    errno = EFBIG;
    return false;
  }
  // reserves beyond the end without changing the size, on which a scan depends
  const int result =
      ::fallocate(file, FALLOC_FL_KEEP_SIZE, static_cast<off_t>(offset), static_cast<off_t>(bytes));
  return result == 0 || (errno != ENOSPC && errno != EDQUOT && errno != EFBIG);
}

/// Blocks all signals of this thread while it lives; threads that are started then keep them
/// blocked.
struct BlockedSignals {
  sigset_t before{};
  BlockedSignals() {
    sigset_t all;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
  }
  ~BlockedSignals() { pthread_sigmask(SIG_SETMASK, &before, nullptr); }
};

/// Starts a thread that gets no signals, so that they reach the thread that waits for them.
template <typename Run>
std::thread start_thread(Run run) {
  const BlockedSignals blocked;
  return std::thread(std::move(run));
}

}  // namespace

FileQueue::FileQueue(int file) : file_(file), thread_(start_thread([this] { run(); })) {}

FileQueue::~FileQueue() {
  {
    const std::lock_guard lock(mutex_);
    ends_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void FileQueue::append(std::vector<char> bytes, uint64_t reserve) {
  const uint64_t taken = bytes.capacity();
  {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return waiting_ <= kMostWaiting || written_.error != 0; });
    pieces_.push_back({std::move(bytes), reserve});
    waiting_ += taken;
  }
  changed_.notify_all();
}

void FileQueue::share_priority() {
  sched_param priority{};
  int policy = SCHED_OTHER;
  if (pthread_getschedparam(pthread_self(), &policy, &priority) != 0) return;
  pthread_setschedparam(thread_.native_handle(), policy, &priority);
}

void FileQueue::wait() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return waiting_ == 0 || written_.error != 0; });
}

FileQueue::Written FileQueue::written() const {
  const std::lock_guard lock(mutex_);
  return written_;
}

int FileQueue::write(const Piece& piece, uint64_t offset) const {
  const bool is_whole = has_room(file_, offset, piece.bytes.size() + piece.reserve) &&
                        write_all(file_, std::as_bytes(std::span(piece.bytes)), offset);
  return is_whole ? 0 : errno;
}

void FileQueue::run() {
  for (uint64_t offset = 0;;) {
    Piece piece;
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [&] { return ends_ || !pieces_.empty(); });
      if (pieces_.empty()) return;
      piece = std::move(pieces_.front());
      pieces_.pop_front();
    }
    const int error = write(piece, offset);
    if (error == 0) offset += piece.bytes.size();
    {
      const std::lock_guard lock(mutex_);
      written_ = {error, offset};
      waiting_ -= piece.bytes.capacity();
    }
    changed_.notify_all();
    if (error != 0) return;
  }
}

}  // namespace haptic
