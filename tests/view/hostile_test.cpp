// SPDX-License-Identifier: GPL-3.0-or-later
// Who means ill to the bridge of a running session, or only behaves so: others are served all the
// while, nobody gets more than is theirs.
#include <sys/resource.h>
#include <sys/wait.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "clients/view/web/places.h"
#include "clients/view/web/token.h"
#include "proto/os/message.h"
#include "tests/support/temporary_folder.h"
#include "tests/view/viewed_session.h"

namespace haptic {
namespace {

using namespace test;
using Json = nlohmann::json;

/// Seconds of processor time that a process has taken.
[[maybe_unused]] double cpu_of(pid_t pid) {
  clockid_t clock;
  timespec t{};
  REQUIRE(clock_getcpuclockid(pid, &clock) == 0);
  REQUIRE(clock_gettime(clock, &t) == 0);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

size_t resident_mib(pid_t pid) {
  std::ifstream status("/proc/" + std::to_string(pid) + "/statm");
  size_t pages = 0, resident = 0;
  status >> pages >> resident;
  return resident * static_cast<size_t>(sysconf(_SC_PAGESIZE)) >> 20;
}

std::string upgrade_request(const BridgeProcess& bridge, const std::string& more) {
  return "GET /view HTTP/1.1\r\nHost: " + bridge.host +
         "\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
         "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Protocol: "
         "hapticd.view.v1\r\n" +
         more + "\r\n";
}

void check_requests(const BridgeProcess& bridge) {
  const std::string host = "Host: " + bridge.host + "\r\n";
  const auto status = [&](const std::string& request) {
    CAPTURE(request);
    return ask(bridge.port, request).status;
  };
  // two readers that could understand a request differently
  CHECK(status("GET /layout.json HTTP/1.1\r\n" + host + "Host: evil.example\r\n\r\n") == 400);
  CHECK(status("GET /layout.json HTTP/1.1\r\nHost: evil.example\r\n" + host + "\r\n") == 400);
  CHECK(status("GET /layout.json HTTP/1.1\r\n" + host +
               "Transfer-Encoding: chunked\r\n\r\n0\r\n\r\n") == 400);
  CHECK(status("GET /layout.json HTTP/1.1\r\n" + host +
               "Content-Length: 0\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n\r\n") == 400);
  CHECK(status("GET /layout.json HTTP/1.1\r\n" + host +
               "Content-Length: 0\r\nContent-Length: 5\r\n\r\nhello") == 400);
  CHECK(status("GET /layout.json HTTP/1.1\r\n" + host + "Content-Length: -1\r\n\r\n") == 400);
  CHECK(status("GET /layout.json HTTP/1.1\r\nHost : " + bridge.host + "\r\n\r\n") == 400);
  CHECK(status("GET http://" + bridge.host + "/layout.json HTTP/1.1\r\n" + host + "\r\n") == 400);
  CHECK(status(std::string("GET /\0 HTTP/1.1\r\n", 17) + host + "\r\n") == 400);
  for (const char* method : {"POST", "PUT", "DELETE", "TRACE", "OPTIONS", "CONNECT", "PATCH"}) {
    CHECK(status(std::string(method) + " / HTTP/1.1\r\n" + host + "\r\n") == 405);
  }
  CHECK(status("POST / HTTP/1.1\r\n" + host + "Content-Length: 5\r\n\r\nhello") == 413);
  CHECK(status("GET /layout.json HTTP/1.1\r\n\r\n") == 403);
  CHECK(status("GET /layout.json HTTP/1.0\r\n\r\n") == 403);
  for (const char* evil : {"127.0.0.1", "127.0.0.1:80", "evil.example", "127.0.0.1.evil.example"}) {
    CHECK(get(bridge.port, "/scene.json", evil).status == 403);
  }
  CHECK(get(bridge.port, "/scene.json", "evil.example:" + std::to_string(bridge.port)).status ==
        403);
  // one after the other in one go
  SocketClient two(bridge.port);
  const std::string one = "GET /layout.json HTTP/1.1\r\n" + host + "\r\n";
  two.say(one + one);
  CHECK(two.reply().status == 200);
  CHECK(two.reply().status == 200);
  // the token is in nothing that anybody may ask for
  for (const char* path : {"/", "/scene.json", "/metrics", "/layout.json"}) {
    const Reply reply = get(bridge.port, path);
    CHECK((reply.head + reply.body).find(bridge.token) == std::string::npos);
    CHECK(reply.head.find("Referrer-Policy: no-referrer") != std::string::npos);
  }
}

void check_sockets(const BridgeProcess& bridge) {
  const std::string own = "Origin: http://" + bridge.host + "\r\n";
  const auto status = [&](const std::string& more) {
    return ask(bridge.port, upgrade_request(bridge, more)).status;
  };
  CHECK(status(own + "Origin: http://evil.example\r\n") == 400);
  CHECK(status("Origin: http://evil.example\r\n" + own) == 400);
  CHECK(status("Origin: null\r\n") == 403);
  CHECK(status("Origin: https://" + bridge.host + "\r\n") == 403);
  CHECK(status("Origin: http://" + bridge.host + ".evil.example\r\n") == 403);
  // compression is not agreed to, and so a compressed frame is an error
  SocketClient compressed(bridge.port);
  compressed.say(upgrade_request(bridge, own + "Sec-WebSocket-Extensions: permessage-deflate\r\n"));
  const Reply agreed = compressed.reply();
  CHECK(agreed.status == 101);
  CHECK(agreed.head.find("permessage") == std::string::npos);
  std::string frame = SocketClient::frame(kText, "abc");
  frame[0] = static_cast<char>(frame[0] | 0x40);
  compressed.say(frame);
  CHECK(compressed.close_code() == 1002);
  const auto code_of = [&](const std::string& bytes) {
    Page page(bridge);
    page.say(bytes);
    return page.close_code();
  };
  // fragments are one message, and together no longer than one
  std::string fragments = SocketClient::frame(kText, std::string(3000, ' '), false);
  for (int i = 0; i < 3; ++i) fragments += SocketClient::frame(0, std::string(3000, ' '), i == 2);
  CHECK(code_of(fragments) == 1009);
  CHECK(code_of(SocketClient::frame(0, "x")) == 1002);
  CHECK(code_of(SocketClient::frame(kPing, "x", false)) == 1002);
  CHECK(code_of(SocketClient::frame(kPing, std::string(126, 'x'))) == 1002);
  CHECK(code_of(SocketClient::frame(kText, "\xff\xfe")) == 1007);
}

/// Says so much at once that it is closed, with the reason or, where it was not read, without.
bool is_closed_for(const BridgeProcess& bridge, const std::string& one) {
  Page page(bridge);
  std::string many;
  for (int i = 0; i < 3000; ++i) many += one;
  page.say(many);
  const int code = page.close_code();
  return code == 1008 || code == 0;
}

}  // namespace

TEST_CASE("hapt view: requests and frames that mean ill get an error each") {
  const Viewed session;
  const BridgeProcess bridge(session.folder.path());
  Page honest(bridge);
  check_requests(bridge);
  check_sockets(bridge);
  CHECK(is_closed_for(bridge, SocketClient::frame(kPing, "")));
  CHECK(is_closed_for(bridge, SocketClient::frame(kText, R"({"type":"rate","hz":60})")));
  CHECK(!honest.frame().empty());

  // guesses, and what a watcher may not
  Page guess(bridge);
  for (int i = 0; i < 5; ++i) guess.tell(R"({"type":"token","token":""})");
  CHECK(guess.close_code() == 1008);
  Page watcher(bridge);
  int id = 0;
  for (const char* line : {"arm", "disarm", "set stiffness 1", "pause", "clear-fault", "lead 0 0 0",
                           "release", "stop", "config"}) {
    CHECK(watcher.answer_to(++id, line)["ok"] == false);
  }
  watcher.tell(R"({"type":"lead","position":[0,0,0]})");
  const LayoutReader layout(get(bridge.port, "/layout.json").body);
  for (int i = 0; i < 20; ++i) CHECK(layout.one(watcher.frame(), "leading") == 0);

  // with the token: what is listed, and what hapticd refuses stays refused
  Page owner(bridge);
  owner.tell(Json{{"type", "token"}, {"token", bridge.token}}.dump());
  CHECK(Json::parse(owner.text_of("control"))["allowed"] == true);
  for (const char* line :
       {"stop", "config", "status", "lead 0 0 0", "release", "pause\nstop", "pause now", "set",
        "set nothing 1", "set stiffness -1", "set stiffness nan", " pause", "PAUSE", ""}) {
    CAPTURE(line);
    CHECK(owner.answer_to(++id, line)["ok"] == false);
  }
  CHECK(owner.answer_to(++id, "pause")["ok"] == true);
}

// the sanitizer checks an address through a pipe: without a descriptor every object looks broken
#ifndef __SANITIZE_ADDRESS__
TEST_CASE("hapt view: without descriptors it waits, and does not spin") {
  const Viewed session;
  BridgeProcess bridge(session.folder.path());
  Page honest(bridge);
  REQUIRE(!honest.frame().empty());
  const size_t open = std::distance(
      std::filesystem::directory_iterator("/proc/" + std::to_string(bridge.pid()) + "/fd"),
      std::filesystem::directory_iterator());
  const rlimit few{open + 8, open + 8};
  REQUIRE(prlimit(bridge.pid(), RLIMIT_NOFILE, &few, nullptr) == 0);
  std::vector<std::unique_ptr<SocketClient>> many;
  for (int i = 0; i < 100; ++i) many.push_back(std::make_unique<SocketClient>(bridge.port));
  const double before = cpu_of(bridge.pid());
  const int64_t begin_ns = now_ns();
  while (now_ns() - begin_ns < kNsPerSecond) {
    INFO(bridge.log());
    REQUIRE(!honest.frame().empty());
  }
  // one page takes less than a hundredth, a loop without a pause all of it
  CHECK(cpu_of(bridge.pid()) - before < 0.5);
  many.clear();
  CHECK(eventually([&] { return get(bridge.port, "/layout.json").status == 200; }));
}
#endif

TEST_CASE("hapt view: who reads nothing shares what is sent to all") {
  const Viewed session;
  // a page of 32 MiB, more than all kernel buffers hold
  const std::string page = session.folder.path() + "/page";
  std::filesystem::create_directory(page);
  std::ofstream(page + "/index.html") << std::string(size_t{32} << 20, ' ');
  BridgeProcess bridge(session.folder.path(), {"--page", page});
  const size_t before = resident_mib(bridge.pid());
  std::vector<std::unique_ptr<SocketClient>> readers;
  for (int i = 0; i < 30; ++i) {
    readers.push_back(std::make_unique<SocketClient>(bridge.port));
    readers.back()->say("GET / HTTP/1.1\r\nHost: " + bridge.host + "\r\n\r\n");
    char first = 0;
    REQUIRE(recv(readers.back()->fd(), &first, 1, 0) == 1);
  }
  CHECK(resident_mib(bridge.pid()) - before < 200);
  Page honest(bridge);
  CHECK(!honest.frame().empty());
}

TEST_CASE("view: nobody holds all places") {
  Places places(5, 3);
  std::vector<std::shared_ptr<void>> greedy;
  for (int i = 0; i < 3; ++i) {
    greedy.push_back(places.take("greedy"));
    CHECK(greedy.back() != nullptr);
  }
  CHECK(places.take("greedy") == nullptr);
  const auto second = places.take("second"), third = places.take("third");
  CHECK(second != nullptr);
  CHECK(third != nullptr);
  CHECK(places.taken() == 5);
  CHECK(places.take("fourth") == nullptr);
  const auto copy = greedy.back();
  greedy.pop_back();
  CHECK(places.taken() == 5);
  greedy.clear();
  CHECK(places.taken() == 3);
  CHECK(places.take("fourth") != nullptr);
  CHECK(places.taken() == 3);
}

TEST_CASE("view: who is behind a connection of this machine is its user, at any of its addresses") {
  for (const char* from : {"127.0.0.1", "127.0.0.9"}) {
    const FileDescriptor listener(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
    const FileDescriptor client(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
    sockaddr_in there{}, here{};
    there.sin_family = here.sin_family = AF_INET;
    there.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    REQUIRE(inet_pton(AF_INET, from, &here.sin_addr) == 1);
    socklen_t size = sizeof there;
    REQUIRE(bind(listener.get(), reinterpret_cast<sockaddr*>(&there), size) == 0);
    REQUIRE(listen(listener.get(), 1) == 0);
    REQUIRE(getsockname(listener.get(), reinterpret_cast<sockaddr*>(&there), &size) == 0);
    REQUIRE(bind(client.get(), reinterpret_cast<sockaddr*>(&here), sizeof here) == 0);
    REQUIRE(connect(client.get(), reinterpret_cast<sockaddr*>(&there), size) == 0);
    const FileDescriptor accepted(accept(listener.get(), nullptr, nullptr));
    CHECK(person_behind(accepted.get()) == "user " + std::to_string(geteuid()));
  }
}

TEST_CASE("view: a token is written into a file of its own alone") {
  const TemporaryFolder folder;
  const std::string path = folder.path() + "/token", other = folder.path() + "/other";
  const auto text_of = [](const std::string& file) {
    std::ostringstream text;
    text << std::ifstream(file).rdbuf();
    return text.str();
  };
  std::ofstream(other) << "precious";
  std::filesystem::create_symlink(other, path);
  {
    const PrivateFile file(path, "secret");
    CHECK(!std::filesystem::is_symlink(path));
    CHECK(text_of(path) == "secret");
    CHECK(std::filesystem::status(path).permissions() ==
          (std::filesystem::perms::owner_read | std::filesystem::perms::owner_write));
  }
  CHECK(text_of(other) == "precious");
  CHECK(!std::filesystem::exists(path));
  // what has been put in its place meanwhile is somebody else's
  {
    const PrivateFile file(path, "secret");
    std::filesystem::remove(path);
    std::ofstream(path) << "theirs";
  }
  CHECK(text_of(path) == "theirs");
  std::filesystem::create_directory(folder.path() + "/folder");
  CHECK_THROWS_AS(PrivateFile(folder.path() + "/folder", "secret"), MessageError);
  CHECK(make_token().size() == 32);
  CHECK(make_token() != make_token());
}

}  // namespace haptic
