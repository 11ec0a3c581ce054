// SPDX-License-Identifier: GPL-3.0-or-later
// The only file that includes Boost.Beast, which takes half a minute to compile.
#include "clients/view/web/web.h"

#include <array>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <map>
#include <optional>
#include <utility>

#include "clients/view/web/places.h"

namespace haptic {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using boost::system::error_code;
using tcp = asio::ip::tcp;
// of one known executor, which costs less than any
using Executor = asio::io_context::executor_type;
using TcpSocket = asio::basic_stream_socket<tcp, Executor>;
using TcpStream = beast::basic_stream<tcp, Executor>;
using Socket = websocket::stream<TcpStream>;

constexpr size_t kRefusals = 64, kRefusalsOfOne = 32;          // peers at a time that are told so
constexpr auto kAcceptPause = std::chrono::milliseconds(100);  // when descriptors are exhausted
constexpr size_t kLongestReason = 120;  // of a close frame, which holds 123 bytes

/// Protocols that a WebSocket offers: "a, b".
std::vector<std::string> words_of(std::string_view list) {
  std::vector<std::string> words;
  for (const auto word : http::token_list(beast::string_view(list.data(), list.size()))) {
    words.emplace_back(word.data(), word.size());
  }
  return words;
}

std::string text_of(beast::string_view text) {
  return {text.data(), text.size()};
}

/// Why two readers could understand the request differently, as a proxy and this server; empty:
/// they cannot.
template <typename Request>
std::string ambiguity_of(const Request& request) {
  for (const http::field once : {http::field::host, http::field::origin}) {
    if (request.count(once) > 1) return "a request has one " + text_of(to_string(once));
  }
  if (request.count(http::field::transfer_encoding) > 0) return "a request here has no body";
  return "";
}

template <typename Request>
WebRequest plain(const Request& request) {
  return {text_of(request.method_string()), text_of(request.target()),
          text_of(request[http::field::host]), text_of(request[http::field::origin]),
          words_of(text_of(request[http::field::sec_websocket_protocol]))};
}

}  // namespace

struct WebServer::Impl {
  class Peer;
  class Channel;

  Impl(const WebOptions& given, WebHandlers told)
      : options(given),
        handlers(std::move(told)),
        served(options.most_peers, options.most_of_one),
        acceptor(io),
        pause(io),
        timer(io) {}

  void listen() {
    error_code error;
    const auto address = asio::ip::make_address(options.address, error);
    if (error) {
      throw WebError("--address " + shown(options.address) +
                     ": is no address; give one as 127.0.0.1");
    }
    const tcp::endpoint place(address, options.port);
    acceptor.open(place.protocol());
    acceptor.set_option(asio::socket_base::reuse_address(true));
    acceptor.bind(place, error);
    if (!error) acceptor.listen(asio::socket_base::max_listen_connections, error);
    if (error) {
      throw WebError("port " + std::to_string(options.port) + " of " + options.address + ": " +
                     error.message() + "; choose another with --port, 0 for any that is free");
    }
  }

  void accept();
  void wait_for_step();

  WebOptions options;
  WebHandlers handlers;
  std::function<int64_t()> step;
  SocketId next_id = 1;
  Places served, refused{kRefusals, kRefusalsOfOne};
  bool stopped = false;
  // what is above outlives the peers, which end with the operations that wait in here
  asio::io_context io{1};
  asio::basic_socket_acceptor<tcp, Executor> acceptor;
  asio::steady_timer pause, timer;
  std::map<SocketId, std::shared_ptr<Channel>> channels;
};

/// A WebSocket. It lives as long as an operation of it is under way.
class WebServer::Impl::Channel : public std::enable_shared_from_this<Channel> {
 public:
  Channel(Impl& server, TcpStream stream, SocketId id, std::shared_ptr<void> place)
      : server_(server), place_(std::move(place)), socket_(std::move(stream)), id_(id) {}
  Channel(const Channel&) = delete;

  template <typename Request>
  void open(const Request& request, const std::string& protocol) {
    beast::get_lowest_layer(socket_).expires_never();
    error_code ignored;
    beast::get_lowest_layer(socket_).socket().set_option(tcp::no_delay(true), ignored);
    const std::chrono::seconds request_patience(server_.options.request_patience);
    const std::chrono::seconds patience(server_.options.write_patience);
    socket_.set_option(websocket::stream_base::timeout{request_patience, patience, true});
    socket_.read_message_max(server_.options.longest_message);
    socket_.auto_fragment(false);
    socket_.control_callback([this](websocket::frame_type, beast::string_view) { is_flooding(); });
    socket_.set_option(
        websocket::stream_base::decorator([protocol](websocket::response_type& response) {
          response.set(http::field::sec_websocket_protocol, protocol);
          response.set(http::field::server, "haptic-view");
        }));
    socket_.async_accept(request, [self = shared_from_this(), protocol](error_code error) {
      if (error || self->server_.stopped) return;
      self->server_.channels.emplace(self->id_, self);
      self->server_.handlers.opened(self->id_, protocol);
      self->read();
    });
  }

  void send(WebMessage message) {
    if (closing_ || message_.bytes != nullptr) return;
    message_ = std::move(message);
    const std::array<asio::const_buffer, 2> parts{
        asio::buffer(message_.own), asio::buffer(*message_.bytes) + message_.own.size()};
    socket_.text(message_.is_text);
    socket_.async_write(parts, [self = shared_from_this()](error_code error, size_t) {
      self->message_ = {};
      if (error) return self->end();
      if (!self->closing_) self->server_.handlers.sent(self->id_);
    });
  }

  void close(CloseCode code, const std::string& reason) {
    if (std::exchange(closing_, true)) return;
    const websocket::close_reason why(static_cast<websocket::close_code>(code),
                                      reason.substr(0, kLongestReason));
    socket_.async_close(why, [self = shared_from_this()](error_code) { self->end(); });
  }

 private:
  void read() {
    socket_.async_read(input_, [self = shared_from_this()](error_code error, size_t) {
      if (error) return self->end();
      if (self->closing_ || self->is_flooding()) return;
      const auto bytes = self->input_.cdata();
      self->server_.handlers.heard(self->id_,
                                   {static_cast<const char*>(bytes.data()), bytes.size()},
                                   self->socket_.got_text());
      self->input_.consume(self->input_.size());
      if (!self->closing_) self->read();
    });
  }

  /// Counts what the peer says; one that says more than a page ever does is closed.
  bool is_flooding() {
    const auto now = std::chrono::steady_clock::now();
    if (now - second_ >= std::chrono::seconds(1)) {
      second_ = now;
      heard_ = 0;
    }
    if (++heard_ <= server_.options.most_heard) return false;
    close(CloseCode::kPolicy, "too many messages a second");
    return true;
  }

  void end() {
    closing_ = true;
    if (server_.channels.erase(id_) > 0) server_.handlers.closed(id_);
  }

  Impl& server_;
  std::shared_ptr<void> place_;
  Socket socket_;
  SocketId id_;
  beast::flat_buffer input_;
  WebMessage message_;  // being written
  bool closing_ = false;
  std::chrono::steady_clock::time_point second_;  // since which
  size_t heard_ = 0;                              // so many messages and pings have come
};

/// A connection that speaks HTTP.
class WebServer::Impl::Peer : public std::enable_shared_from_this<Peer> {
 public:
  Peer(Impl& server, TcpSocket socket, std::shared_ptr<void> place, bool is_served)
      : server_(server),
        place_(std::move(place)),
        is_served_(is_served),
        stream_(std::move(socket)) {}
  Peer(const Peer&) = delete;

  void read() {
    parser_.emplace();
    parser_->header_limit(static_cast<uint32_t>(server_.options.longest_header));
    parser_->body_limit(0);
    stream_.expires_after(std::chrono::seconds(server_.options.request_patience));
    http::async_read(stream_, input_, *parser_,
                     [self = shared_from_this()](error_code error, size_t) {
                       if (error) return self->refuse(error);
                       self->handle();
                     });
  }

 private:
  void refuse(error_code error) {
    if (error == http::error::end_of_stream || error == beast::error::timeout ||
        error.category() != http::make_error_code(http::error::bad_method).category()) {
      return;
    }
    const bool is_long = error == http::error::header_limit || error == http::error::body_limit;
    const unsigned status = error == http::error::header_limit ? 431 : is_long ? 413 : 400;
    write({status, "text/plain; charset=utf-8",
           shared_text("this is no request that is understood here: " + error.message() + "\n")},
          false);
  }

  WebAnswer refusal() const {
    return {503, "text/plain; charset=utf-8",
            shared_text("all connections are in use: of one user or address " +
                        std::to_string(server_.options.most_of_one) + ", of all together " +
                        std::to_string(server_.options.most_peers) +
                        "; close another page, or try again\n")};
  }

  void handle() {
    const auto& request = parser_->get();
    const std::string problem = ambiguity_of(request);
    if (!problem.empty()) {
      return write({400, "text/plain; charset=utf-8", shared_text(problem + "\n")}, false);
    }
    if (!is_served_) return write(refusal(), false);
    if (!websocket::is_upgrade(request)) {
      WebAnswer answer = server_.handlers.answer(plain(request));
      if (answer.later) return wait_for(answer, request.keep_alive());
      return write(answer, request.keep_alive());
    }
    const UpgradeAnswer upgrade = server_.handlers.upgrade(plain(request));
    if (upgrade.protocol.empty()) return write(upgrade.refusal, false);
    std::make_shared<Channel>(server_, std::move(stream_), server_.next_id++, std::move(place_))
        ->open(request, upgrade.protocol);
  }

  /// Only the thread of run() may end a peer, so its owner is handed over to there.
  void wait_for(const WebAnswer& answer, bool keep_alive) {
    stream_.expires_never();
    const auto owner = std::make_shared<std::shared_ptr<Peer>>(shared_from_this());
    answer.later([owner, keep_alive, &server = server_](WebAnswer made) {
      asio::post(server.io, [peer = std::exchange(*owner, nullptr), keep_alive,
                             made = std::move(made)] { peer->write(made, keep_alive); });
    });
  }

  void write(const WebAnswer& answer, bool keep_alive) {
    response_ = {};
    response_.result(answer.status);
    response_.version(11);
    response_.set(http::field::server, "haptic-view");
    response_.set(http::field::content_type, answer.type);
    response_.set(http::field::cache_control, "no-store");
    response_.set("Content-Security-Policy", "default-src 'self'");
    response_.set("X-Content-Type-Options", "nosniff");
    response_.set("Referrer-Policy", "no-referrer");
    if (answer.status == 405) response_.set(http::field::allow, "GET, HEAD");
    const bool is_head = parser_->is_header_done() && parser_->get().method() == http::verb::head;
    response_.content_length(answer.body->size());
    body_ = answer.body;  // not a copy: many slow readers of one mesh share it
    if (!is_head) response_.body() = {body_->data(), body_->size()};
    response_.keep_alive(keep_alive);
    stream_.expires_after(std::chrono::seconds(server_.options.write_patience));
    http::async_write(stream_, response_,
                      [self = shared_from_this(), keep_alive](error_code error, size_t) {
                        if (error) return;
                        if (keep_alive && !self->server_.stopped) return self->read();
                        self->linger();
                      });
  }

  /// Reads what the peer still sends, so that it gets the answer before the connection ends.
  void linger() {
    error_code ignored;
    stream_.socket().shutdown(tcp::socket::shutdown_send, ignored);
    stream_.expires_after(std::chrono::seconds(1));
    drain(kMostLingering);
  }
  void drain(size_t turns) {
    if (turns == 0) return;
    stream_.async_read_some(asio::buffer(rest_),
                            [self = shared_from_this(), turns](error_code error, size_t) {
                              if (!error) self->drain(turns - 1);
                            });
  }

  static constexpr size_t kMostLingering = 64;  // reads

  Impl& server_;
  std::shared_ptr<void> place_;
  const bool is_served_;
  TcpStream stream_;
  beast::flat_buffer input_;
  std::optional<http::request_parser<http::empty_body>> parser_;
  SharedText body_;  // outlives the answer that is being written
  http::response<http::span_body<const char>> response_;
  std::array<char, 4096> rest_{};
};

void WebServer::Impl::accept() {
  acceptor.async_accept([this](error_code error, TcpSocket socket) {
    if (stopped) return;
    if (error) {
      pause.expires_after(kAcceptPause);
      pause.async_wait([this](error_code cancelled) {
        if (!cancelled) accept();
      });
      return;
    }
    const std::string person = person_behind(socket.native_handle());
    std::shared_ptr<void> place = served.take(person);
    const bool is_served = place != nullptr;
    if (!is_served) place = refused.take(person);
    if (place != nullptr) {
      std::make_shared<Peer>(*this, std::move(socket), std::move(place), is_served)->read();
    }
    accept();
  });
}

void WebServer::Impl::wait_for_step() {
  timer.async_wait([this](error_code error) {
    if (error || stopped) return;
    const auto begin = std::chrono::steady_clock::now();
    const int64_t wait_ns = step();
    if (stopped) return;
    // from the planned instant, unless the work took longer
    const auto planned = timer.expiry() + std::chrono::nanoseconds(wait_ns);
    timer.expires_at(std::max(planned, begin));
    wait_for_step();
  });
}

WebServer::WebServer(const WebOptions& options, WebHandlers handlers)
    : impl_(std::make_unique<Impl>(options, std::move(handlers))) {
  impl_->listen();
}

WebServer::~WebServer() = default;

uint16_t WebServer::port() const {
  return impl_->acceptor.local_endpoint().port();
}

size_t WebServer::peers() const {
  return impl_->served.taken();
}

void WebServer::send(SocketId id, WebMessage message) {
  const auto channel = impl_->channels.find(id);
  if (channel != impl_->channels.end()) channel->second->send(std::move(message));
}

void WebServer::close(SocketId id, CloseCode code, const std::string& reason) {
  const auto channel = impl_->channels.find(id);
  if (channel != impl_->channels.end()) channel->second->close(code, reason);
}

void WebServer::every(std::function<int64_t()> step) {
  impl_->step = std::move(step);
  impl_->timer.expires_after(std::chrono::nanoseconds(0));
  impl_->wait_for_step();
}

void WebServer::post(std::function<void()> task) {
  asio::post(impl_->io, std::move(task));
}

void WebServer::run() {
  impl_->accept();
  impl_->io.run();
}

void WebServer::stop() {
  if (std::exchange(impl_->stopped, true)) return;
  impl_->acceptor.close();
  impl_->timer.cancel();
  impl_->pause.cancel();
  impl_->io.stop();
}

}  // namespace haptic
