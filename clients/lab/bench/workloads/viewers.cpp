// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/bench/workloads/viewers.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <stdexcept>
#include <vector>

#include "proto/os/file_descriptor.h"
#include "proto/os/realtime.h"

namespace haptic {
namespace {

constexpr int kBinary = 2, kClose = 8;             // opcodes of RFC 6455
constexpr int64_t kByteEvery = kNsPerSecond / 10;  // of a slow viewer
constexpr int kSmallBuffer = 2048;                 // of a slow viewer, in the kernel [bytes]

/// One end of a WebSocket that reads no more of a frame than its length.
class ViewerSocket {
 public:
  ViewerSocket(uint16_t port, bool is_slow)
      : socket_(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    if (is_slow) {
      setsockopt(socket_.get(), SOL_SOCKET, SO_RCVBUF, &kSmallBuffer, sizeof kSmallBuffer);
    }
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (connect(socket_.get(), reinterpret_cast<sockaddr*>(&address), sizeof address) != 0) {
      throw std::runtime_error("the bridge cannot be reached");
    }
    const std::string host = "127.0.0.1:" + std::to_string(port);
    say("GET /view HTTP/1.1\r\nHost: " + host + "\r\nOrigin: http://" + host +
        "\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
        "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
        "Sec-WebSocket-Protocol: hapticd.view.v1\r\n\r\n");
    while (bytes_.find("\r\n\r\n") == std::string::npos) receive(1);
    if (bytes_.find(" 101 ") == std::string::npos) {
      throw std::runtime_error("the bridge refuses a viewer");
    }
    bytes_.erase(0, bytes_.find("\r\n\r\n") + 4);
    tell(R"({"type":"rate","hz":120})");
  }

  int fd() const { return socket_.get(); }

  /// Reads at most so much and says of each frame that it is shown; returns how many there were.
  uint64_t read(size_t most) {
    receive(most);
    uint64_t frames = 0;
    while (take_frame()) ++frames;
    return frames;
  }

 private:
  void say(const std::string& bytes) const {
    if (send(socket_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL) < 0) {
      throw std::runtime_error("the bridge has hung up");
    }
  }

  /// A short text, masked with zeros.
  void tell(const std::string& text) const {
    std::string frame{static_cast<char>(0x81), static_cast<char>(0x80 | text.size()), 0, 0, 0, 0};
    say(frame + text);
  }

  void receive(size_t most) {
    std::array<char, 65536> part;
    const ssize_t n = recv(socket_.get(), part.data(), std::min(most, part.size()), 0);
    if (n <= 0) throw std::runtime_error("the bridge has hung up");
    bytes_.append(part.data(), static_cast<size_t>(n));
  }

  /// Takes complete messages up to the next binary one; false: there is none.
  bool take_frame() {
    while (bytes_.size() >= 2) {
      const auto byte = [this](size_t i) { return static_cast<unsigned char>(bytes_[i]); };
      const size_t more = byte(1) == 126 ? 2 : byte(1) == 127 ? 8 : 0;
      if (bytes_.size() < 2 + more) return false;
      size_t length = more == 0 ? byte(1) : 0;
      for (size_t i = 0; i < more; ++i) length = length << 8 | byte(2 + i);
      if (bytes_.size() < 2 + more + length) return false;
      const int opcode = byte(0) & 15;
      bytes_.erase(0, 2 + more + length);
      if (opcode == kClose) throw std::runtime_error("the bridge closes a viewer");
      if (opcode != kBinary) continue;
      tell("{\"type\":\"shown\",\"sequence\":" + std::to_string(sequence_++) + "}");
      return true;
    }
    return false;
  }

  FileDescriptor socket_;
  std::string bytes_;
  uint64_t sequence_ = 0;
};

}  // namespace

void be_viewers(uint16_t port, int n, ViewerKind kind, ViewerCounts& counts) {
  const bool is_slow = kind == ViewerKind::kSlow;
  std::vector<ViewerSocket> viewers;
  std::vector<pollfd> waiting;
  for (int i = 0; i < n; ++i) {
    viewers.emplace_back(port, is_slow);
    waiting.push_back({viewers.back().fd(), POLLIN, 0});
    ++counts.connected;
  }
  for (;;) {
    if (is_slow) sleep_until(now_ns() + kByteEvery);
    poll(waiting.data(), waiting.size(), -1);
    for (size_t i = 0; i < viewers.size(); ++i) {
      if (waiting[i].revents != 0) counts.frames += viewers[i].read(is_slow ? 1 : 65536);
    }
  }
}

}  // namespace haptic
