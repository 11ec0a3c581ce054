// SPDX-License-Identifier: GPL-3.0-or-later
#include "servo/hapticd/patient_sink.h"

#include <fcntl.h>
#include <poll.h>
#include <spdlog/logger.h>
#include <unistd.h>

#include <array>
#include <catch2/catch.hpp>
#include <sstream>
#include <string>

#include "proto/os/file_descriptor.h"

namespace haptic {
namespace {

/// A pipe of the smallest size, and a log into it.
struct Bench {
  FileDescriptor read_end, write_end;
  std::shared_ptr<PatientSink> sink;
  std::unique_ptr<spdlog::logger> log;

  Bench() {
    std::array<int, 2> ends{};
    REQUIRE(pipe2(ends.data(), O_CLOEXEC) == 0);
    read_end = FileDescriptor(ends[0]);
    write_end = FileDescriptor(ends[1]);
    fcntl(write_end.get(), F_SETPIPE_SZ, 4096);
    sink = std::make_shared<PatientSink>(write_end.get());
    log = std::make_unique<spdlog::logger>("log", sink);
    log->set_pattern("%v");
    log->flush_on(spdlog::level::info);
  }
  std::string read_all() const {
    std::string text;
    std::array<char, 4096> bytes;
    for (pollfd waiting{read_end.get(), POLLIN, 0}; poll(&waiting, 1, 0) > 0;) {
      sink->drain();
      const ssize_t n = read(read_end.get(), bytes.data(), bytes.size());
      text.append(bytes.data(), static_cast<size_t>(n));
      sink->drain();
    }
    return text;
  }
};

}  // namespace

TEST_CASE("log: what is read arrives whole and in order") {
  Bench b;
  std::string wanted;
  for (int i = 0; i < 1000; ++i) {
    b.log->info("line {}", i);
    wanted += "line " + std::to_string(i) + "\n";
  }
  CHECK(b.read_all() == wanted);
  CHECK(b.sink->dropped() == 0);
}

TEST_CASE("log: one that nobody reads blocks nobody, and what was dropped is counted and said") {
  Bench b;
  constexpr size_t kLines = 10'000;
  // a thousand bytes each: the pipe is full after four
  for (size_t i = 0; i < kLines; ++i) b.log->info("line {} {}", i, std::string(1000, 'x'));
  const uint64_t dropped = b.sink->dropped();
  CHECK(dropped >= kLines - PatientSink::kMostLines - 10);
  std::istringstream text(b.read_all());
  size_t lines = 0, told = 0;
  for (std::string line; std::getline(text, line);) {
    const bool whole = line.starts_with("line ") && line.size() > 1000;
    const bool notice = line == "hapticd: " + std::to_string(dropped) +
                                    " lines of the log were dropped: nobody read them";
    CAPTURE(line.substr(0, 60));
    CHECK((whole || notice));
    lines += whole;
    told += notice;
  }
  CHECK(lines + dropped == kLines);
  CHECK(told == 1);
}

TEST_CASE("log: a line longer than the pipe comes in pieces") {
  Bench b;
  b.log->info(std::string(100'000, 'y'));
  CHECK(b.read_all() == std::string(100'000, 'y') + "\n");
}

}  // namespace haptic
