// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "proto/config/client_config.h"
#include "proto/ipc/segment.h"
#include "proto/ipc/unix_socket.h"

/// How a client comes to give. It connects to `<runtime folder>/<session>.give`, says the name that
/// the session file has for it, and is told its number, the generation that its segment is to have,
/// what it may and the objects that it may move. It makes the segment, offers it in an announcement
/// (handout_message.h), and is told "ok". As long as it is connected, it gives. One that may draw
/// offers a second segment then, once, in the same way.
namespace haptic {

inline constexpr const char* kGiveSuffix = ".give";
/// Begins the answer to a name that has had a segment within the last second.
inline constexpr std::string_view kTooSoon = "too soon: ";
inline constexpr size_t kLongestGiveLine = 4096;  // 16 objects with their names, and room [bytes]

/// What hapticd answers to a name.
struct GivePlace {
  struct Object {
    uint32_t index = 0;  // in the scene
    std::string name;
  };
  uint32_t client = 0;
  uint64_t generation = 0;  // of the segment to be made
  uint32_t may = 0;         // ClientRight
  std::vector<Object> moves;
};
std::string text_of(const GivePlace& place);
/// Throws HandoutError: the text is none, or says why there is no place.
GivePlace read_place(std::string_view text);

/// Checks that a segment that a client offers can be mapped by others without harm: on tmpfs and
/// not in huge pages, exactly as long as it must be, sealed so that nobody can shrink, grow, reopen
/// for writing or unseal it, with the right header, and every page of it there. Throws
/// SegmentError.
void check_given_segment(int fd, const SegmentSpec& spec, uint64_t generation);

/// A place that a client has in a session, which it keeps as long as `socket` is open.
struct GiveSeat {
  FileDescriptor socket;
  GivePlace place;
};
/// Connects and asks for a place; an empty session is the only one. Throws HandoutError with a
/// remedy: no such session, no such [[client]], another one gives under that name, not allowed.
/// Waits a second where the name has just been used.
GiveSeat ask_to_give(const std::string& session, const std::string& name);
/// Offers a segment, and waits until it is taken. Throws HandoutError.
void offer_to_give(const GiveSeat& seat, const SegmentSpec& spec, int fd);

}  // namespace haptic
