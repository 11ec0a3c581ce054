// SPDX-License-Identifier: Apache-2.0
#include "proto/ipc/give_message.h"

#include <fcntl.h>
#include <linux/magic.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/vfs.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <utility>

#include "proto/ipc/handout_message.h"
#include "proto/ipc/sessions.h"
#include "proto/math/assert.h"
#include "proto/os/message.h"
#include "proto/os/realtime.h"
#include "proto/os/text.h"

// in <linux/fcntl.h>, which cannot be included next to <fcntl.h>
#ifndef F_SEAL_FUTURE_WRITE
#define F_SEAL_FUTURE_WRITE 0x0010
#endif

namespace haptic {
namespace {

constexpr int kPatienceMs = 5000;          // of a client for an answer [ms]
constexpr int64_t kRetryNs = 250'000'000;  // where its name was used just now [ns]
constexpr int kMostAttempts = 5;           // together more than the second that hapticd asks for
// of a client, of which readers map all pages [bytes]
constexpr size_t kLargestGiven = size_t{32} << 20;
constexpr std::string_view kPlace = "place ", kTaken = "ok";

/// The text up to the next of these, which is removed with it.
std::string_view take_until(std::string_view& text, char end) {
  const std::string_view part = text.substr(0, text.find(end));
  text.remove_prefix(std::min(text.size(), part.size() + 1));
  return part;
}

/// What hapticd says next; throws HandoutError if it says nothing.
std::string heard(int socket) {
  pollfd waiting{socket, POLLIN, 0};
  std::string text(kLongestGiveLine, '\0');
  if (poll(&waiting, 1, kPatienceMs) > 0) {
    const ssize_t size = recv(socket, text.data(), text.size(), 0);
    if (size > 0) return text.substr(0, static_cast<size_t>(size));
  }
  throw HandoutError("the session does not answer a client that wants to give; see its log");
}

/// A connection that has said the name.
FileDescriptor connected_to(const std::string& path, const std::string& name) {
  FileDescriptor socket = unix_socket();
  if (!connect_to(socket, path, kPatienceMs * int64_t{1'000'000})) {
    if (errno == ENOENT) {
      throw HandoutError("this session takes nothing of clients; add [[client]] with name = \"" +
                         shown(name) + "\" and may = [\"move OBJECT\"] to its file");
    }
    if (errno == EACCES) {
      throw HandoutError(
          "you may not give to this session; name yourself as user in its [[client]]");
    }
    throw_errno("cannot give to the session at " + path);
  }
  if (send(socket.get(), name.data(), name.size(), MSG_NOSIGNAL) < 0) {
    throw_errno("cannot give to the session at " + path);
  }
  return socket;
}

[[noreturn]] void refuse(SegmentFault fault, const std::string& what) {
  throw SegmentError(fault, "the segment of a client " + what);
}

}  // namespace

std::string text_of(const GivePlace& place) {
  std::string text = std::string(kPlace) + std::to_string(place.client) + " " +
                     std::to_string(place.generation) + " " + std::to_string(place.may) + "\n";
  for (const GivePlace::Object& object : place.moves) {
    text += std::to_string(object.index) + " " + object.name + "\n";
  }
  return text;
}

GivePlace read_place(std::string_view text) {
  if (!text.starts_with(kPlace)) throw HandoutError(shown(text));
  std::string_view rest = text.substr(kPlace.size());
  std::string_view line = take_until(rest, '\n');
  const auto client = number_from<uint32_t>(take_until(line, ' '));
  const auto generation = number_from<uint64_t>(take_until(line, ' '));
  const auto may = number_from<uint32_t>(line);
  GivePlace place;
  bool is_good = client && *client < kMostClients && generation && may;
  while (is_good && !rest.empty()) {
    line = take_until(rest, '\n');
    const auto index = number_from<uint32_t>(take_until(line, ' '));
    is_good = index && *index < kMaxObjects && !line.empty();
    if (is_good) place.moves.push_back({*index, std::string(line)});
  }
  if (!is_good) {
    throw HandoutError("the session answers a client that wants to give with '" + shown(text) +
                       "'; build both from the same source");
  }
  place.client = *client;
  place.generation = *generation;
  place.may = *may;
  return place;
}

void check_given_segment(int fd, const SegmentSpec& spec, uint64_t generation) {
  HAPTIC_ASSERT(spec.total_bytes <= kLargestGiven);
  constexpr int kSeals = F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_FUTURE_WRITE | F_SEAL_SEAL;
  const int seals = fcntl(fd, F_GET_SEALS);
  if (seals < 0 || (seals & kSeals) != kSeals) {
    refuse(SegmentFault::kNotSealed,
           "is not sealed against shrinking, growing, other writers and unsealing");
  }
  struct statfs system {};
  if (fstatfs(fd, &system) != 0 || system.f_type != TMPFS_MAGIC) {
    refuse(SegmentFault::kSystem, "lies in huge pages, or not in memory; use memfd_create");
  }
  struct stat status {};
  if (fstat(fd, &status) != 0 || !std::cmp_equal(status.st_size, spec.total_bytes)) {
    refuse(SegmentFault::kTooShort, "has not the " + std::to_string(spec.total_bytes) +
                                        " bytes of this version; build it from the same source");
  }
  // makes the pages that were never written; sealed, none can be taken away again
  const SegmentMapping mapping(reopen_read_only(fd), spec);
  if (mapping.generation() != generation) {
    refuse(SegmentFault::kWrongKind, "has another generation than it was told");
  }
}

GiveSeat ask_to_give(const std::string& session, const std::string& name) {
  namespace fs = std::filesystem;
  const std::string path = fs::path(find_session(session)).replace_extension(kGiveSuffix).string();
  for (int attempt = 0;; ++attempt) {
    GiveSeat seat{connected_to(path, name), {}};
    const std::string answer = heard(seat.socket.get());
    if (answer.starts_with(kTooSoon) && attempt < kMostAttempts) {
      sleep_until(now_ns() + kRetryNs);
      continue;
    }
    seat.place = read_place(answer);
    return seat;
  }
}

void offer_to_give(const GiveSeat& seat, const SegmentSpec& spec, int fd) {
  offer_segment(seat.socket.get(), spec.id, seat.place.generation, spec.name, fd);
  const std::string answer = heard(seat.socket.get());
  if (answer != kTaken) throw HandoutError(shown(answer));
}

}  // namespace haptic
