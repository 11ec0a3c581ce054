// SPDX-License-Identifier: GPL-3.0-or-later
// The eye file against bytes put together by hand, and every field of it damaged.
#include "proto/ipc/eye_file.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cstring>
#include <limits>
#include <string>

#include "proto/ipc/sealed_file.h"
#include "tests/support/hostile_text.h"

namespace haptic {
namespace {

using Bytes = std::vector<std::byte>;

template <typename T>
void append(Bytes& bytes, std::initializer_list<T> values) {
  for (const T value : values) {
    const auto* first = reinterpret_cast<const std::byte*>(&value);
    bytes.insert(bytes.end(), first, first + sizeof value);
  }
}

/// A triangle with two points, by the table in the header.
Bytes by_hand() {
  Bytes bytes;
  for (const char c : std::string("HAPTEYE1")) bytes.push_back(static_cast<std::byte>(c));
  append<uint32_t>(bytes, {3, 1, 2, 5});
  append<float>(bytes, {0.25f, 0.5f, 1.0f, 0.75f});
  const std::string name = "Schädel";
  for (size_t i = 0; i < 40; ++i) bytes.push_back(std::byte(i < name.size() ? name[i] : 0));
  append<float>(bytes, {0, 0, 0, 1, 0, 0, 0, 2, 0});
  append<float>(bytes, {0, 0, 1, 0, 0, 1, 0, 0, 1});
  append<uint32_t>(bytes, {0, 1, 2});
  append<float>(bytes, {0.5f, 0, 0, 0, 0.5f, 0});
  return bytes;
}

std::string problem_of(const Bytes& bytes) {
  return test::refusal<EyeError>([&] { view_eye(bytes); });
}

template <typename T>
Bytes with(size_t offset, T value) {
  Bytes bytes = by_hand();
  std::memcpy(bytes.data() + offset, &value, sizeof value);
  return bytes;
}

}  // namespace

TEST_CASE("eye file: bytes put together by hand are read") {
  const Bytes bytes = by_hand();
  const EyeFile file = view_eye(bytes);
  CHECK(file.object == 5);
  CHECK(file.name == "Schädel");
  CHECK(file.colour == EyeColour{0.25f, 0.5f, 1.0f, 0.75f});
  REQUIRE(file.vertices.size() == 3);
  CHECK(file.vertices[2] == EyePoint{0, 2, 0});
  REQUIRE(file.normals.size() == 3);
  CHECK(file.normals[1] == EyePoint{0, 0, 1});
  REQUIRE(file.triangles.size() == 1);
  CHECK(file.triangles[0] == EyeTriangle{0, 1, 2});
  REQUIRE(file.points.size() == 2);
  CHECK(file.points[1] == EyePoint{0, 0.5f, 0});
  CHECK(write_eye(file) == bytes);
}

TEST_CASE("eye file: a long name is cut between characters, an evil one is escaped") {
  EyeFile file;
  file.name = std::string(39, 'a') + "ä";
  CHECK(view_eye(write_eye(file)).name == std::string(39, 'a'));
  file.name = std::string(38, 'a') + "ä";
  CHECK(view_eye(write_eye(file)).name == file.name);
  file.name = "\x1b[2J\n";
  CHECK(view_eye(write_eye(file)).name == "\\x1b[2J\\n");
}

TEST_CASE("eye file: each damaged field is refused in one line") {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  constexpr float kInf = std::numeric_limits<float>::infinity();
  constexpr size_t kVertices = 80, kNormals = 116, kTriangles = 152, kPoints = 164;
  REQUIRE(problem_of(by_hand()).empty());
  const auto says = [](const Bytes& bytes, const std::string& part) {
    const std::string problem = problem_of(bytes);
    CAPTURE(problem, part);
    CHECK(problem.find(part) != std::string::npos);
    CHECK(problem.find('\n') == std::string::npos);
  };
  says({}, "0 bytes, shorter than its header");
  says(Bytes(79), "79 bytes, shorter");
  says(with(7, '2'), "does not begin with HAPTEYE1");
  // counts that are wrong, also where a product of 32 bits would wrap back to the size
  for (const size_t offset : {8, 12, 16}) {
    for (const uint32_t add : {1u, 0x1000'0000u, 0x4000'0000u, 0x8000'0000u, 0xffff'ffffu}) {
      uint32_t count = 0;
      std::memcpy(&count, by_hand().data() + offset, sizeof count);
      says(with(offset, count + add), "its counts need");
    }
  }
  Bytes longer = by_hand(), shorter = by_hand();
  longer.push_back({});
  shorter.pop_back();
  says(longer, "its counts need 188");
  says(shorter, "its counts need 188");
  for (const size_t channel : {24, 28, 32, 36}) {
    for (const float bad : {-0.1f, 1.1f, kNan, kInf}) says(with(channel, bad), "colour");
  }
  for (const float bad : {kNan, kInf, -kInf}) {
    says(with(kVertices + 4, bad), "vertex 0 is not finite");
    says(with(kNormals + 35 - 3, bad), "normal 2 is not finite");
    says(with(kPoints + 12, bad), "point 1 is not finite");
  }
  says(with(kTriangles + 4, 3u), "triangle 0 names vertex 3 of 3");
  says(with(kTriangles, 0xffff'ffffu), "triangle 0 names vertex 4294967295 of 3");
}

TEST_CASE("eye file: what would not be read is not written") {
  const std::vector<EyePoint> one(1);
  EyeFile file;
  file.vertices = one;
  CHECK_THROWS_AS(write_eye(file), EyeError);
  file.normals = one;
  CHECK_NOTHROW(write_eye(file));
  file.colour.a = 2;
  CHECK_THROWS_AS(write_eye(file), EyeError);
}

TEST_CASE("sealed file: only one that nobody can change is mapped") {
  const Bytes bytes = by_hand();
  const SealedMapping mapping = map_sealed_file(make_sealed_file("eye", bytes), bytes.size());
  CHECK(Bytes(mapping.bytes.begin(), mapping.bytes.end()) == bytes);
  const auto fault_of = [&](FileDescriptor fd, size_t most) {
    try {
      map_sealed_file(std::move(fd), most);
    } catch (const SegmentError& error) {
      return error.fault;
    }
    return SegmentFault::kNotReady;
  };
  CHECK(fault_of(make_sealed_file("eye", bytes), bytes.size() - 1) == SegmentFault::kTooLong);
  CHECK(fault_of(make_sealed_file("eye", {}), 1) == SegmentFault::kTooShort);
  constexpr int kAll = F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_WRITE | F_SEAL_SEAL;
  for (const int missing : {F_SEAL_SHRINK, F_SEAL_GROW, F_SEAL_WRITE, F_SEAL_SEAL, kAll}) {
    FileDescriptor fd(memfd_create("eye", MFD_CLOEXEC | MFD_ALLOW_SEALING));
    REQUIRE(write(fd.get(), bytes.data(), bytes.size()) == std::ssize(bytes));
    fcntl(fd.get(), F_ADD_SEALS, kAll & ~missing);
    CHECK(fault_of(std::move(fd), bytes.size()) == SegmentFault::kNotSealed);
  }
  CHECK(fault_of(FileDescriptor(open("/dev/zero", O_RDONLY | O_CLOEXEC)), 1) ==
        SegmentFault::kNotSealed);
}

}  // namespace haptic
