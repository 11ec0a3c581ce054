// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>

#include "proto/ipc/attachments.h"
#include "proto/ipc/eye_file.h"
#include "proto/wire/wire.h"

namespace haptic {

/// How one object, or the tool, is drawn: in O or T, with the pose of the frames. Its arrays are
/// mapped read-only and never change.
struct EyeMesh : EyeFile {
  uint64_t generation = 0;              // of the contact process that made it
  std::shared_ptr<const void> storage;  // keeps the arrays
};

/// The meshes that a session has handed out so far; a null pointer means not yet.
struct Eyes {
  uint64_t changes = 0;  // grows with each mesh that comes, also when contact has been restarted
  std::array<std::shared_ptr<const EyeMesh>, kMostHands> tools;     // by hand
  std::array<std::shared_ptr<const EyeMesh>, kMaxObjects> objects;  // by index in the session file
  // their convex pieces, in sessions whose contact keeps such: no two pieces share a vertex
  std::array<std::shared_ptr<const EyeMesh>, kMostHands> tool_pieces;
  std::array<std::shared_ptr<const EyeMesh>, kMaxObjects> object_pieces;
  std::string problem;  // why the last one that was refused was, one line; empty: none was
};

/// The newest eye file of each object and of the tool. Any thread may ask.
class EyeBook {
 public:
  /// Maps and checks an eye file; one of an older generation is ignored.
  void take(const Announcement& announcement, FileDescriptor fd);

  Eyes eyes() const;

  /// For the Attachments that fill this book, which must end before it.
  AttachOptions options();

 private:
  mutable std::mutex mutex_;
  Eyes eyes_;
};

}  // namespace haptic
