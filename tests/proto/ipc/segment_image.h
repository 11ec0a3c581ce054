// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "proto/ipc/segment.h"

/// Segments as bytes in files, as input for a reader.
namespace haptic::test {

using Bytes = std::vector<std::byte>;

/// Memory of a writer of generation 3 with one frame.
inline Bytes valid_image() {
  SegmentWriter<SimChannels> writer(3);
  SceneFrame frame{};
  frame.seq = 77;
  writer.channels().frames.publish(frame);
  Bytes image(kSegmentSpec<SimChannels>.total_bytes);
  REQUIRE(pread(writer.fd(), image.data(), image.size(), 0) == ssize_t(image.size()));
  return image;
}

inline FileDescriptor file_with(const Bytes& image, int seals = F_SEAL_SHRINK) {
  FileDescriptor fd(memfd_create("image", MFD_CLOEXEC | MFD_ALLOW_SEALING));
  REQUIRE(write(fd.get(), image.data(), image.size()) == ssize_t(image.size()));
  if (seals != 0) REQUIRE(fcntl(fd.get(), F_ADD_SEALS, seals) == 0);
  return fd;
}

/// The error of an attempt to read a file; none if it was accepted. The message is one line with
/// the name of the segment.
template <typename Channels = SimChannels>
std::optional<SegmentFault> fault_of(FileDescriptor fd, const ViewOptions& options = {}) {
  try {
    const SegmentView<Channels> view(std::move(fd), options);
    return std::nullopt;
  } catch (const SegmentError& error) {
    const std::string what = error.what();
    const bool is_named = what.find(Channels::kName) != std::string::npos;
    if (!is_named || what.find('\n') != std::string::npos) FAIL_CHECK(what);
    return error.fault;
  }
}

}  // namespace haptic::test
