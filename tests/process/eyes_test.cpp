// SPDX-License-Identifier: GPL-3.0-or-later
// What programs of other people draw: the eye files of real sessions against the mesh files and the
// sizes in the session files, which this test reads by itself.
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <tuple>

#include "clients/library/client.h"
#include "proto/ipc/control_socket.h"
#include "proto/ipc/handout_message.h"
#include "tests/process/hapt_command.h"
#include "tests/process/hapticd_process.h"
#include "tests/process/watcher.h"
#include "tests/support/data.h"
#include "tests/support/temporary_folder.h"

namespace haptic {
namespace {

using test::eventually;
using test::HapticdProcess;
using test::TemporaryRuntimeFolder;
using test::Watcher;

/// A session file of configs/ that asks for no real-time rights, with lines added to its
/// [session] and to its end.
std::string write_config(const std::string& folder, const std::string& name,
                         const std::string& session = "", const std::string& end = "") {
  std::ostringstream text;
  text << std::ifstream(test::from_source("configs/" + name)).rdbuf();
  std::string config = text.str();
  const auto replace = [&](const std::string& old, const std::string& by) {
    const size_t at = config.find(old);
    if (at != std::string::npos) config.replace(at, old.size(), by);
  };
  replace("\nrealtime = true", "\n");
  replace("[session]\n", "[session]\nrealtime = false\n" + session);
  std::ofstream(folder + "/" + name) << config << end;
  return folder + "/" + name;
}

/// The values of an attribute in a drawing, in order.
std::vector<std::string> values_of(const std::string& svg, const std::string& attribute) {
  const std::string begin = " " + attribute + "=\"";
  std::vector<std::string> values;
  for (size_t at = svg.find(begin); at != std::string::npos; at = svg.find(begin, at)) {
    at += begin.size();
    values.push_back(svg.substr(at, svg.find('"', at) - at));
  }
  return values;
}

/// A session, and a client that has all of its meshes.
struct Drawn {
  TemporaryRuntimeFolder folder;
  HapticdProcess hapticd;
  Watcher watcher{"drawn"};
  Client client{"drawn"};

  explicit Drawn(const std::string& config, const std::string& session = "",
                 const std::string& end = "")
      : hapticd({write_config(folder.path(), config, session, end), "--session", "drawn"},
                folder.path()) {
    client.start();
    INFO(hapticd.log());
    REQUIRE(eventually([&] { return client.eyes().changes >= 2; }));
  }
};

struct Box {
  double lower[3] = {1e9, 1e9, 1e9}, upper[3] = {-1e9, -1e9, -1e9};

  template <typename Point>
  void add(const Point& p) {
    for (size_t k = 0; k < 3; ++k) {
      lower[k] = std::min(lower[k], static_cast<double>(p[k]));
      upper[k] = std::max(upper[k], static_cast<double>(p[k]));
    }
  }
};

Box box_of(std::span<const EyePoint> points) {
  Box box;
  for (const EyePoint& p : points) box.add(p);
  return box;
}

void check_box(const Box& box, const Box& wanted, double margin) {
  for (size_t k = 0; k < 3; ++k) {
    CAPTURE(k);
    CHECK(box.lower[k] == Approx(wanted.lower[k]).margin(margin));
    CHECK(box.upper[k] == Approx(wanted.upper[k]).margin(margin));
  }
}

Box centred(double x, double y, double z) {
  return {{-x / 2, -y / 2, -z / 2}, {x / 2, y / 2, z / 2}};
}

/// Corners minus edges plus faces, of a closed mesh: 2 for a ball, 0 for a ring.
long euler(const EyeMesh& mesh) {
  return std::ssize(mesh.vertices) - std::ssize(mesh.triangles) / 2;
}

/// The corners of an OFF file, scaled so that the longest side of their box is `size`.
std::vector<std::array<double, 3>> read_off(const std::string& path, double size) {
  std::ifstream file(path);
  std::string magic;
  size_t n = 0, faces = 0, edges = 0;
  file >> magic >> n >> faces >> edges;
  std::vector<std::array<double, 3>> corners(n);
  Box box;
  for (auto& p : corners) {
    file >> p[0] >> p[1] >> p[2];
    box.add(p);
  }
  double longest = 0;
  for (size_t k = 0; k < 3; ++k) longest = std::max(longest, box.upper[k] - box.lower[k]);
  for (auto& p : corners) {
    for (double& x : p) x *= size / longest;
  }
  return corners;
}

}  // namespace

TEST_CASE("eyes: the bunny to be drawn is the bunny of the file, lighter") {
  const auto mesh = test::find_mesh("bunny00.off");
  if (!mesh) return;
  Drawn drawn("bunny.toml");
  const Eyes eyes = drawn.client.eyes();
  CHECK(eyes.problem.empty());
  const EyeMesh& bunny = *eyes.objects[0];
  CHECK(bunny.name == "bunny");
  CHECK(bunny.colour.r == Approx(0x7f / 255.0));
  const auto corners = read_off(*mesh, 0.1);
  REQUIRE(corners.size() > 30'000);
  // decimated: a closed surface of at most 20,000 triangles between corners of the file
  CHECK(bunny.triangles.size() <= 20'000);
  CHECK(bunny.triangles.size() > 19'900);
  CHECK(euler(bunny) == 2);
  std::set<EyePoint> known;
  Box box;
  for (const auto& p : corners) {
    known.insert({static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])});
    box.add(p);
  }
  const auto near_one = [&](const EyePoint& p) {
    const auto from = known.lower_bound({p[0] - 1e-7f, -1, -1});
    const auto to = known.upper_bound({p[0] + 1e-7f, 1, 1});
    return std::any_of(from, to, [&](const EyePoint& q) {
      return std::fabs(p[1] - q[1]) < 1e-7f && std::fabs(p[2] - q[2]) < 1e-7f;
    });
  };
  CHECK(std::count_if(bunny.vertices.begin(), bunny.vertices.end(), near_one) ==
        std::ssize(bunny.vertices));
  check_box(box_of(bunny.vertices), box, 1e-3);
  CHECK(bunny.normals.size() == bunny.vertices.size());
  CHECK(bunny.points.empty());
  // a point is drawn as a sphere of a millimetre
  check_box(box_of(eyes.tools[kFirstHand]->vertices), centred(2e-3, 2e-3, 2e-3), 1e-5);
}

TEST_CASE("eyes: peg and hole to be drawn have the sizes of the session file, and its points") {
  Drawn drawn("peg-in-hole.toml");
  const Eyes eyes = drawn.client.eyes();
  const EyeMesh& peg = *eyes.tools[kFirstHand];
  const EyeMesh& hole = *eyes.objects[0];
  CHECK(peg.object == kEyeOfTool);
  CHECK(hole.object == 0);
  CHECK(eyes.objects[1] == nullptr);
  CHECK(peg.name == "tool");
  CHECK(hole.name == "hole");
  // by default 96 steps around and 16 along; the peg has two middles, the hole two walls
  CHECK(peg.vertices.size() == 96 * 17 + 2);
  CHECK(hole.vertices.size() == 96 * 17 * 2);
  CHECK(euler(peg) == 2);
  CHECK(euler(hole) == 0);
  check_box(box_of(peg.vertices), centred(0.02, 0.02, 0.04), 1e-5);
  check_box(box_of(hole.vertices), centred(0.06, 0.06, 0.06), 1e-6);
  // the points lie on the peg: 2 π r (r + l) over the area of one, 0.5 mm square
  const double area = 2 * M_PI * 0.01 * (0.01 + 0.04);
  CHECK(static_cast<double>(peg.points.size()) > area / 0.5e-3 / 0.5e-3);
  CHECK(static_cast<double>(peg.points.size()) < 2 * area / 0.5e-3 / 0.5e-3);
  const auto is_on_peg = [](const EyePoint& p) {
    const double r = std::hypot(double{p[0]}, double{p[1]}), z = std::fabs(double{p[2]});
    // the side is 96 flat strips, 5 µm inside of the cylinder in their middles
    const bool on_side = r > 0.01 - 6e-6 && r < 0.01 + 1e-7 && z < 0.02 + 1e-7;
    return on_side || (std::fabs(z - 0.02) < 1e-7 && r < 0.01 + 1e-7);
  };
  CHECK(std::all_of(peg.points.begin(), peg.points.end(), is_on_peg));
}

TEST_CASE("eyes: the sphere of virtual-proxy3 and the colours are those of the session file") {
  Drawn drawn(
      "plane.toml", "renderer = \"virtual-proxy3\"\n",
      "colour = \"#ff8000\"\n[[object]]\nname = \"b\"\nprimitive = \"sphere\"\nsize = \"1 cm\"\n"
      "subdivisions = 1\nposition = [\"1 m\", \"0 m\", \"0 m\"]\n[contact]\n"
      "proxy_radius = \"3 mm\"\n");
  REQUIRE(eventually([&] { return drawn.client.eyes().changes == 3; }));
  const Eyes eyes = drawn.client.eyes();
  CHECK(eyes.objects[0]->colour == EyeColour{1, 128 / 255.0f, 0, 1});
  CHECK(eyes.objects[0]->vertices.size() == 8);
  CHECK(eyes.objects[0]->triangles.size() == 12);
  check_box(box_of(eyes.objects[0]->vertices), centred(0.08, 0.08, 0.08), 1e-7);
  CHECK(eyes.objects[1]->triangles.size() == 80);
  CHECK_FALSE(eyes.objects[1]->colour == eyes.objects[0]->colour);
  check_box(box_of(eyes.tools[kFirstHand]->vertices), centred(6e-3, 6e-3, 6e-3), 1e-5);
}

TEST_CASE("eyes: after kill -9 of contact they are there again, and not before from the spare") {
  Drawn drawn("plane.toml");
  REQUIRE(drawn.watcher.wait_for_all());
  REQUIRE(
      eventually([] { return test::has(say_to_session("drawn", "status"), "\"ready\": true"); }));
  const Eyes before = drawn.client.eyes();
  CHECK(before.changes == 2);
  CHECK(before.tools[kFirstHand]->generation == 1);
  kill(test::writer_of(drawn.watcher.contact), SIGKILL);
  REQUIRE(eventually([&] { return drawn.client.eyes().changes == 4; }));
  const Eyes after = drawn.client.eyes();
  CHECK(after.tools[kFirstHand]->generation == 2);
  CHECK(after.objects[0]->generation == 2);
  CHECK(std::equal(before.objects[0]->vertices.begin(), before.objects[0]->vertices.end(),
                   after.objects[0]->vertices.begin(), after.objects[0]->vertices.end()));
  // who comes later gets the new ones alone
  Client late("drawn");
  late.start();
  REQUIRE(eventually([&] { return late.eyes().changes == 2; }));
  CHECK(late.eyes().objects[0]->generation == 2);
}

namespace {

/// The descriptor of the block's eye file, as any client may take it from the socket.
FileDescriptor take_eye(const std::string& session) {
  const FileDescriptor socket = Watcher::connect(session);
  ReceivedMessage message;
  eventually([&] {
    message = receive_message(socket.get());
    return message.kind == Received::kMessage && message.announcement.id == eye_id(0);
  });
  return std::move(message.fd);
}

/// What another user finds: 0 if all rings and meshes are there, nothing can be written and nothing
/// controlled.
int look_as(uid_t user) {
  if (setgid(user) != 0 || setuid(user) != 0) return 3;
  Watcher watching("drawn");
  if (!watching.wait_for_all()) return 5;
  const bool may_ask = say_to_session("drawn", "status text").starts_with("session    drawn") &&
                       say_to_session("drawn", "status").starts_with("{\"session\": \"drawn\"");
  const bool may_control =
      !say_to_session("drawn", "pause").starts_with("error: only user 0 and root");
  if (!may_ask || may_control) return 6;
  Client client("drawn");
  client.start();
  if (!eventually([&] { return client.eyes().changes == 2; })) return 2;
  const Eyes eyes = client.eyes();
  const auto* header = reinterpret_cast<const std::byte*>(eyes.objects[0]->vertices.data()) - 80;
  const bool kept = mprotect(const_cast<std::byte*>(header), 4096, PROT_READ | PROT_WRITE) != 0;
  const FileDescriptor eye = take_eye("drawn");
  const std::string path = "/proc/self/fd/" + std::to_string(eye.get());
  const FileDescriptor again(open(path.c_str(), O_RDWR | O_CLOEXEC));
  const bool refused = pwrite(eye.get(), "x", 1, 0) < 0 && ftruncate(eye.get(), 0) != 0 &&
                       (!again.is_open() || pwrite(again.get(), "x", 1, 0) < 0);
  return kept && refused && eyes.objects[0]->vertices.size() == 8 ? 0 : 1;
}

}  // namespace

TEST_CASE("session: who is neither the server's user nor root may watch but not control or write") {
  if (geteuid() != 0) {
    WARN("SKIPPED: needs root, to become somebody else");
    return;
  }
  const TemporaryRuntimeFolder folder;
  std::filesystem::permissions(folder.path(), std::filesystem::perms(0755));
  const HapticdProcess hapticd({write_config(folder.path(), "plane.toml"), "--session", "drawn"},
                               folder.path());
  const FileDescriptor ready = Watcher::connect("drawn");
  // before this process has threads
  const pid_t other = fork();
  if (other == 0) {
    constexpr uid_t kNobody = 65534;
    try {
      _exit(look_as(kNobody));
    } catch (const std::exception&) {
      _exit(4);
    }
  }
  int status = 0;
  waitpid(other, &status, 0);
  INFO(hapticd.log());
  CHECK(WIFEXITED(status));
  CHECK(WEXITSTATUS(status) == 0);
  Watcher watcher("drawn");
  REQUIRE(watcher.wait_for_all());
  CHECK((watcher.servo_frame.flags & kServoPaused) == 0);
}

TEST_CASE("example 02: the drawing shows the tool and the force of its tick") {
  Drawn drawn("plane.toml");
  REQUIRE(drawn.watcher.wait_for_all());
  // all frames are kept: the drawing is of one of them
  std::map<uint64_t, ServoFrame> frames;
  const auto take = [&] {
    for (ServoFrame frame; drawn.watcher.servo.next(frame);) frames[frame.tick] = frame;
  };
  // once the hand presses, so that there is a force to draw
  REQUIRE(eventually([&] {
    take();
    return !frames.empty() && norm(frames.rbegin()->second.F_coupling_W.f) > 0.5;
  }));
  const test::Ran ran = test::shell("02_draw now.svg drawn", drawn.folder.path());
  take();
  INFO(ran.output);
  REQUIRE(ran.code == 0);
  std::ostringstream text;
  text << std::ifstream(drawn.folder.path() + "/now.svg").rdbuf();
  const std::string svg = text.str();
  // one line with a tick: from the tool along the force
  const auto number = [&](const std::string& attribute) {
    return std::stod(values_of(svg.substr(svg.find(" data-tick=")), attribute).at(0));
  };
  const ServoFrame& frame = frames.at(std::stoull(values_of(svg, "data-tick").at(0)));
  const double x = number("x1"), y = number("y1");
  CHECK(x / 1000 == Approx(frame.X_WT.p.x).margin(1e-7));
  CHECK(-y / 1000 == Approx(frame.X_WT.p.y).margin(1e-7));
  CHECK((number("x2") - x) / 10 == Approx(frame.F_coupling_W.f.x).margin(2e-5));
  CHECK(-(number("y2") - y) / 10 == Approx(frame.F_coupling_W.f.y).margin(2e-5));
  // the front of the block, two triangles; about half of the sphere
  const std::vector<std::string> paths = values_of(svg, "d");
  REQUIRE(paths.size() == 2);
  CHECK(std::count(paths[0].begin(), paths[0].end(), 'Z') == 2);
  CHECK(test::has(paths[0], "40.00 -40.00"));
  CHECK(std::count(paths[1].begin(), paths[1].end(), 'Z') == Approx(640).margin(40));

  CHECK(test::has(test::shell("02_draw", drawn.folder.path()).output, "say where to draw"));
  const test::Ran none = test::shell("02_draw no/where.svg drawn", drawn.folder.path());
  CHECK(none.code == 1);
  CHECK(test::has(none.output, "cannot write no/where.svg"));
}

}  // namespace haptic
