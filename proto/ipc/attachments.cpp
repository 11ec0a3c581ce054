// SPDX-License-Identifier: Apache-2.0
#include "proto/ipc/attachments.h"

#include <poll.h>
#include <sys/eventfd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <limits>
#include <utility>

#include "proto/math/assert.h"
#include "proto/os/realtime.h"

namespace haptic {
namespace {

constexpr int kRetirePollMs = 100;  // [ms] between checks whether readers have left old generations
constexpr int kTouchPollMs = 1;     // [ms] between steps of touching pages
constexpr size_t kTouchedPages = 4;  // of each segment in a step: twice what its writer fills

// the thread sanitizer would touch memory of its own as well
[[gnu::no_sanitize_thread]] void touch(const void* memory, size_t begin, size_t end, size_t page) {
  const auto* bytes = static_cast<const volatile char*>(memory);
  for (size_t at = begin; at < end; at += page) static_cast<void>(bytes[at]);
}

/// Reads the next pages of each newest segment once; true: there are pages left. The first touch by
/// a process costs 6 to 15 µs under a hypervisor that keeps page tables of its own, even of a page
/// that the guest has locked; what is read here no tick has to pay. Reading all at once would keep
/// others from the processor while a process is replaced.
bool touch_some(const std::map<SegmentId, detail::Feed>& feeds) {
  const size_t page = boost::interprocess::mapped_region::get_page_size();
  bool some_left = false;
  for (const auto& [id, feed] : feeds) {
    if (feed.generations.empty()) continue;
    detail::Generation& newest = *feed.generations.back();
    const size_t size = feed.spec.total_bytes, begin = newest.touched;
    newest.touched = std::min(size, begin + kTouchedPages * page);
    touch(newest.mapping->memory(), begin, newest.touched, page);
    some_left = some_left || newest.touched < size;
  }
  return some_left;
}

bool is_of_another_version(SegmentFault fault) {
  return fault == SegmentFault::kWrongAbi || fault == SegmentFault::kWrongLayout;
}

}  // namespace

Attachments::Attachments(FileDescriptor socket, AttachOptions options)
    : socket_(std::move(socket)),
      stop_event_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)),
      options_(std::move(options)) {
  if (!stop_event_.is_open()) throw_errno("cannot make an event descriptor");
}

Attachments::~Attachments() {
  if (!thread_.joinable()) return;
  eventfd_write(stop_event_.get(), 1);
  thread_.join();
}

detail::Feed& Attachments::feed_of(const SegmentSpec& spec) {
  detail::Feed& feed = feeds_[spec.id];
  feed.spec = spec;
  return feed;
}

detail::ReaderMark* Attachments::add_reader(detail::Feed& feed) {
  if (thread_.joinable()) throw HandoutError("sources are to be made before the start");
  feed.readers.push_back(std::make_unique<detail::ReaderMark>());
  return feed.readers.back().get();
}

void Attachments::start() {
  HAPTIC_ASSERT(!thread_.joinable());
  thread_ = std::thread([this] { run(); });
}

void Attachments::run() {
  if (options_.fifo_priority > 0) {
    enter_realtime({.fifo_priority = options_.fifo_priority, .lock_memory = false});
  }
  bool retiring = false, touching = false;
  for (;;) {
    pollfd waiting[] = {{socket_.get(), POLLIN, 0}, {stop_event_.get(), POLLIN, 0}};
    // readers do not wake this thread: check again while old generations are left
    poll(waiting, 2, touching ? kTouchPollMs : retiring ? kRetirePollMs : -1);
    if (waiting[1].revents != 0) return;
    if (waiting[0].revents != 0 && !receive()) break;
    retiring = free_retired();
    touching = options_.lock_memory && touch_some(feeds_);
  }
  connected_.store(false, std::memory_order_release);
  if (options_.on_closed) options_.on_closed();
}

bool Attachments::receive() {
  ReceivedMessage message = receive_message(socket_.get());
  if (message.kind == Received::kMessage) {
    return attach(message.announcement, std::move(message.fd));
  }
  if (message.kind == Received::kRefusal) refusal_ = std::move(message.why);
  return message.kind == Received::kNothing;
}

void Attachments::take_eye(const Announcement& announcement, FileDescriptor fd) {
  if (!options_.on_eye) return;
  try {
    options_.on_eye(announcement, std::move(fd));
  } catch (const std::exception& error) {
    if (options_.on_error) options_.on_error(error.what());
  }
}

bool Attachments::attach(const Announcement& announcement, FileDescriptor fd) {
  if (is_eye(announcement.id)) {
    take_eye(announcement, std::move(fd));
    return true;
  }
  const auto found = feeds_.find(announcement.id);
  if (found == feeds_.end()) return true;
  detail::Feed& feed = found->second;
  detail::Generation* last =
      feed.generations.empty() ? feed.before_first.get() : feed.generations.back().get();
  // an announcement may come twice
  if (last->mapping != nullptr && last->mapping->generation() >= announcement.generation)
    return true;
  try {
    auto next = std::make_unique<detail::Generation>();
    next->mapping = std::make_unique<SegmentMapping>(
        std::move(fd), feed.spec, ViewOptions{.lock_memory = options_.lock_memory});
    if (next->mapping->generation() != announcement.generation) {
      throw HandoutError(std::string("segment '") + feed.spec.name +
                         "' was announced with another generation than it holds");
    }
    next->serial = last->serial + 1;
    feed.generations.push_back(std::move(next));
    last->next.store(feed.generations.back().get(), std::memory_order_release);
  } catch (const SegmentError& error) {
    // nothing that this session announces can be read: waiting for it would show nothing for ever
    if (!options_.on_error && is_of_another_version(error.fault)) {
      refusal_ = error.what();
      return false;
    }
    if (options_.on_error) options_.on_error(error.what());
  } catch (const std::exception& error) {
    if (options_.on_error) options_.on_error(error.what());
  }
  return true;
}

bool Attachments::free_retired() {
  bool some_left = false;
  for (auto& [id, feed] : feeds_) {
    uint64_t reached = std::numeric_limits<uint64_t>::max();
    for (const auto& reader : feed.readers) {
      reached = std::min(reached, reader->serial.load(std::memory_order_acquire));
    }
    // the last one stays: the next is linked to it
    while (feed.generations.size() > 1 && feed.generations.front()->serial < reached) {
      feed.generations.erase(feed.generations.begin());
    }
    some_left = some_left || feed.generations.size() > 1;
  }
  return some_left;
}

}  // namespace haptic
