// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "proto/os/message.h"

/// An HTTP and WebSocket server on one thread, with limits on everything that a peer can send, and
/// without any queue: what is in front of it decides what is said next.
namespace haptic {

struct WebError : MessageError {
  using MessageError::MessageError;
};

struct WebRequest {
  std::string method, target, host;
  std::string origin;                  // empty: none
  std::vector<std::string> protocols;  // of a WebSocket, in the order in which they are offered
};

/// Bytes that several peers may share.
using SharedText = std::shared_ptr<const std::string>;
inline SharedText shared_text(std::string text) {
  return std::make_shared<const std::string>(std::move(text));
}

/// A message to a peer.
struct WebMessage {
  SharedText bytes;
  bool is_text = true;
  std::string own = {};  // of this peer alone, in place of the first bytes
};

struct WebAnswer {
  unsigned status = 200;
  std::string type = "text/plain; charset=utf-8";
  SharedText body;
  /// If set, the answer comes later: it is given what sends it, which any thread may call, once.
  std::function<void(std::function<void(WebAnswer)> send)> later = {};
};

/// One line of text.
inline WebAnswer text_answer(unsigned status, const std::string& text) {
  return {status, "text/plain; charset=utf-8", shared_text(text + "\n")};
}

/// The answer to the wish for a WebSocket: its sub-protocol, or why there is none.
struct UpgradeAnswer {
  std::string protocol;  // empty: refused
  WebAnswer refusal;
};

/// Number of a WebSocket, never reused.
using SocketId = uint64_t;

/// The functions that are told of the peers; all run on the thread of run().
struct WebHandlers {
  std::function<WebAnswer(const WebRequest&)> answer;
  std::function<UpgradeAnswer(const WebRequest&)> upgrade;
  std::function<void(SocketId, const std::string& protocol)> opened;
  std::function<void(SocketId, std::string_view message, bool is_text)> heard;
  std::function<void(SocketId)> sent;  // the last message is out: the next may be sent
  std::function<void(SocketId)> closed;
};

/// Codes of RFC 6455 with which a WebSocket is closed.
enum class CloseCode : uint16_t { kUnsupported = 1003, kPolicy = 1008 };

struct WebOptions {
  std::string address = "127.0.0.1";
  uint16_t port = 0;              // 0: any that is free
  size_t most_peers = 128;        // connections at a time; others are told so
  size_t most_of_one = 96;        // of them of one user or address
  size_t longest_message = 8192;  // from a WebSocket [bytes]
  size_t most_heard = 1000;       // messages and pings of a WebSocket a second
  size_t longest_header = 8192;   // of a request [bytes]
  int request_patience = 5;       // [s], for a whole request
  int write_patience = 20;        // [s], for an answer, a message and a silent WebSocket
};

class WebServer {
 public:
  /// Listens. Throws WebError: a wrong address, or a port in use.
  WebServer(const WebOptions& options, WebHandlers handlers);
  ~WebServer();
  WebServer(const WebServer&) = delete;

  uint16_t port() const;
  size_t peers() const;

  /// Sends a message; the one before must be out.
  void send(SocketId id, WebMessage message);
  void close(SocketId id, CloseCode code, const std::string& reason);

  /// Calls `step` on the thread of run(), again after as many nanoseconds as it returns.
  void every(std::function<int64_t()> step);
  /// Runs this on the thread of run(); from any thread.
  void post(std::function<void()> task);

  /// Serves until stop(), which may be called from a handler.
  void run();
  void stop();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace haptic
