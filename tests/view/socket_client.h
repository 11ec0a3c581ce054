// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstdint>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>

#include "proto/os/file_descriptor.h"
#include "proto/os/realtime.h"

/// A browser's end of HTTP and WebSocket, written from RFC 9112 and RFC 6455 on plain sockets: it
/// shares no code with the server.
namespace haptic::test {

struct Reply {
  int status = 0;  // 0: none came
  std::string head, body;
};

/// A WebSocket message or, with opcode 8, its end; opcode −1: nothing came in time.
struct Message {
  int opcode = -1;
  std::string bytes;
};

inline constexpr int kText = 1, kBinary = 2, kClose = 8, kPing = 9, kPong = 10;

class SocketClient {
 public:
  explicit SocketClient(uint16_t port) : socket_(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    is_open_ = connect(socket_.get(), reinterpret_cast<sockaddr*>(&address), sizeof address) == 0;
  }

  bool is_open() const { return is_open_; }
  int fd() const { return socket_.get(); }
  void hang_up() { socket_.reset(); }

  bool say(std::string_view bytes) {
    while (!bytes.empty()) {
      const ssize_t n = send(socket_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL);
      if (n <= 0) return false;
      bytes.remove_prefix(static_cast<size_t>(n));
    }
    return true;
  }

  /// The answer to a request, which the server ends by closing or by its length.
  Reply reply(double patience = 10) {
    Reply out;
    const size_t end = wait_for("\r\n\r\n", patience);
    if (end == std::string::npos) return out;
    out.head = take(end + 4);
    out.status = std::atoi(out.head.c_str() + out.head.find(' '));
    const size_t at = out.head.find("Content-Length: ");
    if (at == std::string::npos) return out;
    const size_t length = std::strtoul(out.head.c_str() + at + 16, nullptr, 10);
    while (received_.size() < length && receive(patience)) {
    }
    out.body = take(std::min(length, received_.size()));
    return out;
  }

  /// Opens a WebSocket; the status of the answer, 101 if it is open.
  int upgrade(const std::string& path, const std::string& host, const std::string& origin,
              const std::string& protocol) {
    say("GET " + path + " HTTP/1.1\r\nHost: " + host +
        "\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
        "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n" +
        (origin.empty() ? "" : "Origin: " + origin + "\r\n") +
        "Sec-WebSocket-Protocol: " + protocol + "\r\n\r\n");
    const size_t end = wait_for("\r\n\r\n", 10);
    if (end == std::string::npos) return 0;
    handshake_ = take(end + 4);
    return std::atoi(handshake_.c_str() + 9);
  }
  const std::string& handshake() const { return handshake_; }

  /// A frame as a client sends it: masked. RFC 6455, section 5.2.
  static std::string frame(int opcode, std::string_view payload, bool is_final = true,
                           bool is_masked = true) {
    std::string out(1, static_cast<char>((is_final ? 0x80 : 0) | opcode));
    const uint64_t n = payload.size();
    const int bit = is_masked ? 0x80 : 0;
    if (n < 126) {
      out += static_cast<char>(bit | static_cast<int>(n));
    } else if (n < 65536) {
      out += static_cast<char>(bit | 126);
      for (int shift = 8; shift >= 0; shift -= 8) out += static_cast<char>((n >> shift) & 0xff);
    } else {
      out += static_cast<char>(bit | 127);
      for (int shift = 56; shift >= 0; shift -= 8) out += static_cast<char>((n >> shift) & 0xff);
    }
    constexpr char kMask[4] = {0x37, 0x21, 0x5a, 0x11};
    if (is_masked) out.append(kMask, 4);
    for (size_t i = 0; i < payload.size(); ++i) {
      out += is_masked ? static_cast<char>(payload[i] ^ kMask[i % 4]) : payload[i];
    }
    return out;
  }
  bool tell(std::string_view text) { return say(frame(kText, text)); }

  /// The next message; pings are answered.
  Message message(double patience = 10) {
    for (;;) {
      Message out = one_frame(patience);
      if (out.opcode == kPing) say(frame(kPong, out.bytes));
      if (out.opcode != kPing && out.opcode != kPong) return out;
    }
  }

  /// The next text of that type; texts of another and frames are passed over.
  std::string text_of(const std::string& type, double patience = 10) {
    const int64_t end = now_ns() + static_cast<int64_t>(patience * 1e9);
    while (now_ns() < end) {
      const Message m = message(patience);
      if (m.opcode == -1 || m.opcode == kClose) return "";
      if (m.opcode == kText && m.bytes.find("\"type\":\"" + type + "\"") != std::string::npos) {
        return m.bytes;
      }
    }
    return "";
  }

  /// Code of the close frame that ends the messages; 0: the connection ended without one.
  int close_code(double patience = 10) {
    for (;;) {
      const Message m = message(patience);
      if (m.opcode == -1) return 0;
      if (m.opcode != kClose) continue;
      if (m.bytes.size() < 2) return 1005;
      return (static_cast<unsigned char>(m.bytes[0]) << 8) | static_cast<unsigned char>(m.bytes[1]);
    }
  }

  /// True if the other end hangs up within that time.
  bool is_hung_up(double patience) {
    while (receive(patience)) received_.clear();
    return ended_;
  }

 private:
  std::string take(size_t n) {
    std::string out = received_.substr(0, n);
    received_.erase(0, n);
    return out;
  }

  size_t wait_for(const std::string& end, double patience) {
    size_t at;
    while ((at = received_.find(end)) == std::string::npos && receive(patience)) {
    }
    return at;
  }

  bool receive(double patience) {
    pollfd waiting{socket_.get(), POLLIN, 0};
    if (poll(&waiting, 1, static_cast<int>(patience * 1000)) <= 0) return false;
    char bytes[65536];
    const ssize_t n = recv(socket_.get(), bytes, sizeof bytes, 0);
    ended_ = n <= 0;
    if (n > 0) received_.append(bytes, static_cast<size_t>(n));
    return n > 0;
  }

  /// The payload length and where it begins, once the head is there.
  std::optional<std::pair<size_t, size_t>> extent() const {
    if (received_.size() < 2) return std::nullopt;
    const auto byte = [&](size_t i) { return static_cast<unsigned char>(received_[i]); };
    size_t n = byte(1) & 0x7f, at = 2;
    const size_t more = n == 126 ? 2 : n == 127 ? 8 : 0;
    if (received_.size() < at + more) return std::nullopt;
    if (more > 0) n = 0;
    for (size_t i = 0; i < more; ++i) n = (n << 8) | byte(at + i);
    return std::pair(at + more, n);
  }

  Message one_frame(double patience) {
    for (;;) {
      if (const auto there = extent(); there && received_.size() >= there->first + there->second) {
        Message out{received_[0] & 0x0f, received_.substr(there->first, there->second)};
        received_.erase(0, there->first + there->second);
        return out;
      }
      if (!receive(patience)) return {};
    }
  }

  FileDescriptor socket_;
  bool is_open_ = false, ended_ = false;
  std::string received_, handshake_;
};

/// One request and its answer.
inline Reply ask(uint16_t port, const std::string& request) {
  SocketClient client(port);
  client.say(request);
  return client.reply();
}
inline Reply get(uint16_t port, const std::string& path, const std::string& host = "") {
  return ask(port, "GET " + path + " HTTP/1.1\r\nHost: " +
                       (host.empty() ? "127.0.0.1:" + std::to_string(port) : host) +
                       "\r\nConnection: close\r\n\r\n");
}

}  // namespace haptic::test
