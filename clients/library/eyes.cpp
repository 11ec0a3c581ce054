// SPDX-License-Identifier: Apache-2.0
#include "clients/library/eyes.h"

#include <utility>

#include "proto/ipc/sealed_file.h"

namespace haptic {
namespace {

std::shared_ptr<const EyeMesh> map_eye(const Announcement& announcement, FileDescriptor fd) {
  SealedMapping mapping = map_sealed_file(std::move(fd), kMostEyeBytes);
  auto mesh = std::make_shared<EyeMesh>();
  static_cast<EyeFile&>(*mesh) = view_eye(mapping.bytes);
  const bool has_pieces = is_pieces(announcement.id);
  if ((has_pieces ? pieces_id(mesh->object) : eye_id(mesh->object)) != announcement.id) {
    throw EyeError("eye file: it was announced for another object than it names");
  }
  mesh->generation = announcement.generation;
  mesh->storage = std::move(mapping.storage);
  return mesh;
}

std::shared_ptr<const EyeMesh>& place_of(SegmentId id, Eyes& eyes) {
  const uint32_t object = eye_object(id);
  if (is_eye_of_tool(object)) {
    return (is_pieces(id) ? eyes.tool_pieces : eyes.tools).at(kEyeOfTool - object);
  }
  return (is_pieces(id) ? eyes.object_pieces : eyes.objects).at(object);
}

}  // namespace

void EyeBook::take(const Announcement& announcement, FileDescriptor fd) {
  std::shared_ptr<const EyeMesh> mesh;
  std::string problem;
  try {
    mesh = map_eye(announcement, std::move(fd));
  } catch (const MessageError& error) {
    problem = error.what();
  }
  const std::lock_guard lock(mutex_);
  if (!problem.empty()) {
    eyes_.problem = std::move(problem);
    return;
  }
  std::shared_ptr<const EyeMesh>& place = place_of(announcement.id, eyes_);
  if (place && place->generation >= mesh->generation) return;
  place = std::move(mesh);
  ++eyes_.changes;
}

AttachOptions EyeBook::options() {
  return {.on_eye = [this](const Announcement& announcement, FileDescriptor fd) {
    take(announcement, std::move(fd));
  }};
}

Eyes EyeBook::eyes() const {
  const std::lock_guard lock(mutex_);
  return eyes_;
}

}  // namespace haptic
