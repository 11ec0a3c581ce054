// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/bake/mapped_file.h"

#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cerrno>
#include <csignal>
#include <stdexcept>

namespace haptic {
namespace {

constexpr size_t kSize = 100'001;  // no whole number of pages

std::vector<std::byte> made_by(pid_t who) {
  std::vector<std::byte> bytes(kSize, std::byte{7});
  std::copy_n(reinterpret_cast<const std::byte*>(&who), sizeof who, bytes.begin());
  return bytes;
}

pid_t maker_of(const MappedFile& file) {
  pid_t who = 0;
  REQUIRE(file.bytes.size() == kSize);
  CHECK(std::ranges::all_of(file.bytes.subspan(sizeof who),
                            [](std::byte b) { return b == std::byte{7}; }));
  std::copy_n(file.bytes.begin(), sizeof who, reinterpret_cast<std::byte*>(&who));
  return who;
}

bool has_children() {
  return waitpid(-1, nullptr, WNOHANG) >= 0 || errno != ECHILD;
}

}  // namespace

TEST_CASE("made apart: another process makes the bytes, and nothing else of it is left") {
  bool told = false;
  const MappedFile file = make_apart([&] {
    told = true;
    return made_by(getpid());
  });
  CHECK(maker_of(file) != getpid());
  CHECK_FALSE(told);
  CHECK_FALSE(has_children());
  CHECK(maker_of(make_here([] { return made_by(getpid()); })) == getpid());
}

TEST_CASE("made apart: what throws there throws here, and who dies there is replaced") {
  CHECK_THROWS_WITH(
      make_apart([]() -> std::vector<std::byte> { throw std::runtime_error("no mesh"); }),
      "no mesh");
  const pid_t here = getpid();
  const MappedFile file = make_apart([&] {
    if (getpid() != here) raise(SIGKILL);
    return made_by(getpid());
  });
  CHECK(maker_of(file) == here);
  CHECK(make_apart([] { return std::vector<std::byte>{}; }).bytes.empty());
  CHECK_FALSE(has_children());
}

}  // namespace haptic
