// SPDX-License-Identifier: GPL-3.0-or-later
// A device behind its vendor's SDK: the example's program with the stand-in SDK, a real session
// before it, and those of two vendors with stubs of their SDKs, which play the stand-in's hand.
// The force that the hand gets is read from the SDK's own log.
#include <poll.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <fstream>

#include "proto/os/serial_port.h"
#include "tests/process/hapticd_process.h"
#include "tests/process/watcher.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/tolerance.h"

namespace haptic {
namespace {

using namespace test;

constexpr double kOwnStiffness = 500;  // [N/m]
constexpr double kForceStep = 5e-3, kPlaceStep = 1e-6;

/// A wrench that the SDK was given, and where its handle was.
struct Felt {
  int64_t t_ns;
  std::array<double, 6> wrench, at;
  bool is_zero() const { return wrench == std::array<double, 6>{}; }
};

/// The program, its log and its link.
struct OwnProgram {
  std::string folder, link, csv;
  ProgramProcess process;

  explicit OwnProgram(const std::string& folder_, const std::string& name = "03_own_device")
      : folder(folder_),
        link(folder + "/own"),
        csv(folder + "/felt.csv"),
        process(name, with_log(csv, link), folder) {
    unsetenv("STAND_IN_SDK_LOG");
    REQUIRE(eventually([&] { return std::filesystem::is_symlink(link); }));
  }
  static std::vector<std::string> with_log(const std::string& csv, const std::string& link) {
    setenv("STAND_IN_SDK_LOG", csv.c_str(), 1);
    return {link};
  }
  std::vector<Felt> felt() const {
    std::vector<Felt> all;
    std::ifstream file(csv);
    for (std::string line; std::getline(file, line) && !file.eof();) {
      Felt one{};
      std::istringstream in(line);
      char comma = 0;
      in >> one.t_ns;
      for (auto* part : {&one.wrench, &one.at}) {
        for (double& value : *part) in >> comma >> value;
      }
      if (in) all.push_back(one);
    }
    return all;
  }
};

std::string write_own_session(const std::string& folder) {
  std::string path = folder + "/own.toml";
  std::ofstream(path) << R"([session]
name = "own"
[device]
kind = "own-device"
max_force = "20 N"
[device.serial]
path = ")" << folder << R"(/own"
[coupling]
stiffness = "500 N/m"
[safety]
armed_at_start = true
soft_start = "0.1 s"
[[object]]
name = "block"
primitive = "box"
extent = ["200 mm", "200 mm", "40 mm"]
position = ["0 mm", "0 mm", "-20 mm"]
)";
  return path;
}

/// Whether this is the spring for where the handle was a tick or two before, and nothing else.
bool is_press(const std::vector<Felt>& all, size_t i) {
  if (i < 4 || all[i].at[2] > -2e-3 || all[i].is_zero()) return false;
  double least = 1e9, most = 0;
  for (size_t j = i - 4; j <= i; ++j) {
    least = std::min(least, kOwnStiffness * -all[j].at[2]);
    most = std::max(most, kOwnStiffness * -all[j].at[2]);
  }
  // the passivity controller's damper beside it, 2 N·s/m at 15 mm/s
  const double f = all[i].wrench[2], margin = kForceStep + kOwnStiffness * kPlaceStep + 0.03;
  return f > least - tol(margin) && f < most + tol(margin);
}

bool presses_since(const std::vector<Felt>& all, int64_t since_ns) {
  int n = 0;
  for (size_t i = 0; i < all.size(); ++i) n += all[i].t_ns > since_ns && is_press(all, i);
  return n > 50;
}

/// The answer of the program to these bytes, as far as `size`.
std::string answer_to(int node, const std::string& bytes, size_t lines) {
  REQUIRE(write(node, bytes.data(), bytes.size()) == static_cast<ssize_t>(bytes.size()));
  std::string said;
  eventually([&] {
    char text[256];
    const ssize_t n = read(node, text, sizeof text);
    if (n > 0) said.append(text, static_cast<size_t>(n));
    return static_cast<size_t>(std::count(said.begin(), said.end(), '\n')) >= lines;
  });
  return said;
}

/// The numbers of the answer to one line; none: it was not answered.
std::vector<double> answered(int node, const std::string& line) {
  REQUIRE(write(node, line.data(), line.size()) == static_cast<ssize_t>(line.size()));
  std::string said;
  pollfd answer{node, POLLIN, 0};
  while (!said.ends_with('\n') && poll(&answer, 1, 30) > 0) {
    char text[256];
    const ssize_t n = read(node, text, sizeof text);
    if (n > 0) said.append(text, static_cast<size_t>(n));
  }
  std::vector<double> numbers;
  std::istringstream in(said);
  char between = 0;
  for (double number = 0; in >> between >> number;) numbers.push_back(number);
  return numbers;
}

int error_in(const std::string& answer) {
  return std::stoi(answer.substr(answer.rfind(',') + 1));
}

}  // namespace

TEST_CASE("own device: each line has the answer that the page says") {
  const TemporaryFolder folder;
  OwnProgram own(folder.path());
  const FileDescriptor node = open_serial_port(own.link);
  const auto [line, error] =
      GENERATE(table<std::string, int>({{"[0,0,0,0,0,0]\n", 0},
                                        {"[200,-400,6000,1,-1,0]\n", 0},
                                        {"]\n", 256},
                                        {"[]\n", 512},
                                        {"[1,2,3]\n", 512},
                                        {"[1,2,3,4,5,x]\n", 1024},
                                        {"[1,2,3,4,5,]\n", 1024},
                                        {"[1,2,3,4,5,99999999999]\n", 1024},
                                        {"[9,9,[0,0,0,0,0,0]\n", 0},
                                        {"[" + std::string(127, '1'), 128}}));
  CAPTURE(line);
  const std::string answer = answer_to(node.get(), line, 1);
  CHECK(answer.substr(0, 3) == "[7,");
  CHECK(std::count(answer.begin(), answer.end(), ',') == 7);
  CHECK(error_in(answer) == error);
  // a challenge, and the line after it
  const std::string both = answer_to(node.get(), "]\n[0,0,-100,0,0,50]\n", 2);
  CHECK(error_in(both.substr(0, both.find('\n'))) == 256);
  CHECK(error_in(both) == 0);
  const std::vector<Felt> felt = own.felt();
  REQUIRE_FALSE(felt.empty());
  CHECK(felt.back().wrench == std::array<double, 6>{0, 0, -0.5, 0, 0, 0.005});
  // a number that no firmware takes is zero
  answer_to(node.get(), "[0,0,6001,0,0,0]\n", 1);
  CHECK(own.felt().back().is_zero());
  // the program's own watchdog
  answer_to(node.get(), "[0,0,100,0,0,0]\n", 1);
  const size_t n = own.felt().size();
  CHECK(eventually([&] { return own.felt().size() > n; }));
  CHECK(own.felt().back().is_zero());
  CHECK(own.felt().back().t_ns - own.felt()[n - 1].t_ns > 100'000'000);
}

TEST_CASE("own device: the programs of two vendors' SDKs take forces, give poses, end with them") {
  const auto [name, torque] =
      GENERATE(table<std::string, double>({{"openhaptics_device", 0},  // has no motors for it
                                           {"force_dimension_device", 0.05}}));
  CAPTURE(name);
  const TemporaryFolder folder;
  OwnProgram own(folder.path(), name);
  const FileDescriptor node = open_serial_port(own.link);
  // a hand of 300 N/m gives way, and turns its handle meanwhile
  std::vector<double> answer;
  REQUIRE(eventually([&] {
    answer = answered(node.get(), "[200,-100,300,0,0,500]\n");
    return answer.size() == 8 && answer[1] > 2000 && answer[4] > 2000;
  }));
  const Felt felt = own.felt().back();
  CHECK(felt.wrench == std::array<double, 6>{1, -0.5, 1.5, 0, 0, torque});
  CHECK(answer[0] == 7);
  for (size_t i = 0; i < 6; ++i) {
    // it goes on moving between the two, with up to 50 mm/s and 0.2 rad/s
    const double step = i < 3 ? kPlaceStep : 1e-5, margin = i < 3 ? 1e-3 : 4e-3;
    CHECK(std::abs(step * answer[1 + i] - felt.at[i]) < tol(margin));
  }
  CHECK(eventually([&] {
    answer = answered(node.get(), "]\n");
    return answer.size() == 8 && answer[7] == 256;
  }));
  // nobody asks any more
  CHECK(eventually([&] { return own.felt().back().is_zero(); }));
  // a force that tears the plug of these devices out: the SDK reports an error from then on
  REQUIRE(eventually([&] { return answered(node.get(), "[6000,0,0,0,0,0]\n").empty(); }));
  for (int i = 0; i < 3; ++i) CHECK(answered(node.get(), "[0,0,0,0,0,0]\n").empty());
  CHECK(own.process.said("the plug is out"));
  own.process.send(SIGTERM);
  CHECK(own.process.exit_code() == 0);
  CHECK_FALSE(std::filesystem::is_symlink(own.link));
}

TEST_CASE("own device: the hand presses, and hapticd's zero reaches it when the servo is killed") {
  const TemporaryFolder folder;
  setenv("HAPTICD_RUNTIME_DIR", folder.path().c_str(), 1);
  OwnProgram own(folder.path());
  HapticdProcess hapticd({write_own_session(folder.path())}, folder.path());
  Watcher watcher("own");
  INFO(hapticd.log());
  REQUIRE(eventually([&] { return presses_since(own.felt(), 0); }));
  // the stand-in presses its button below the surface
  REQUIRE(eventually([&] {
    return watcher.servo.latest(watcher.servo_frame) && watcher.servo_frame.device.buttons == 1;
  }));
  REQUIRE(eventually([&] { return is_press(own.felt(), own.felt().size() - 1); }));
  const int64_t killed_ns = now_ns();
  kill(writer_of(watcher.servo), SIGKILL);
  REQUIRE(eventually([&] { return presses_since(own.felt(), killed_ns); }));
  const std::vector<Felt> all = own.felt();
  const auto zero = std::find_if(all.begin(), all.end(),
                                 [&](const Felt& f) { return f.t_ns > killed_ns && f.is_zero(); });
  REQUIRE(zero != all.end());
  // sooner than the program's own watchdog
  CHECK(zero->t_ns - killed_ns < 100'000'000);
  // nothing but what the servo had sent before came until then
  const int64_t quiet_ns = killed_ns + 5'000'000;
  CHECK(std::none_of(all.begin(), zero, [&](const Felt& f) { return f.t_ns > quiet_ns; }));

  // without its program there is no device; with a new one it is whole again
  own.process.send(SIGTERM);
  CHECK(own.process.exit_code() == 0);
  CHECK_FALSE(std::filesystem::is_symlink(own.link));
  CHECK(own.felt().back().is_zero());
  CHECK(eventually([&] {
    watcher.servo.latest(watcher.servo_frame);
    return (watcher.servo_frame.flags & kServoNoDevice) != 0;
  }));
  OwnProgram again(folder.path());
  CHECK(eventually([&] { return presses_since(again.felt(), 0); }));
}

}  // namespace haptic
