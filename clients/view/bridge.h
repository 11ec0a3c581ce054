// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "clients/view/frame_source.h"
#include "clients/view/log_study.h"
#include "clients/view/messages.h"
#include "clients/view/metrics.h"
#include "clients/view/page_message.h"
#include "clients/view/viewer.h"
#include "clients/view/web/http_rules.h"
#include "clients/view/web/web.h"
#include "clients/view/web/worker.h"

namespace haptic {

struct BridgeOptions {
  WebOptions web;
  WebRules rules;           // their port is set by the bridge
  std::string token;        // who has it may control
  std::string page_folder;  // of index.html; empty: the page is not built
  /// Says a line to the session and returns the answer; may wait, may throw. Runs on a thread of
  /// its own.
  std::function<std::string(const std::string& line)> say;
};

/// Shows a source of frames to pages and Foxglove clients. All of it runs on one thread, but for
/// `say`. A viewer that is slow or stopped costs nothing: each has one message under way, and the
/// next frame is made when it is ready.
class Bridge {
 public:
  /// Listens. Throws WebError.
  Bridge(FrameSource source, BridgeOptions options);
  Bridge(const Bridge&) = delete;

  uint16_t port() const { return server_.port(); }
  /// Serves until `stop` is true, which is asked at each tick.
  void run(const std::function<bool()>& stop);

 private:
  WebHandlers handlers();
  WebAnswer answer(const WebRequest& request);
  WebAnswer file(const std::string& path);
  WebAnswer drawing(const std::string& name) const;
  UpgradeAnswer upgrade(const WebRequest& request) const;
  void open(SocketId id, const std::string& protocol);
  void hear(SocketId id, std::string_view text);
  void hear_page(SocketId id, Viewer& viewer, std::string_view text);
  void check_token(SocketId id, Viewer& viewer, const std::string& token);
  void command(SocketId id, const Viewer& viewer, const CommandMessage& command);
  void lead(const std::string& line);
  void next_lead();
  void say_next(SocketId id, Viewer& viewer);
  void tell(SocketId id, Viewer& viewer, WebMessage message);
  void tell_pages(const SharedText& text);
  std::string scene(bool with_config) const;

  int64_t tick();
  void hear_source(SourceNews news);
  void tell_scene();
  void ask_status(int64_t now);
  void tell_status();
  void tell_drawings();
  void send_frames(int64_t now);
  void send_records(int64_t now);

  // of a log
  std::string hello(double missed) const;
  std::string gone() const;
  void open_log(Viewer& viewer);
  void send_log_frames(int64_t now);
  WebAnswer study(std::string_view path, std::string query);
  void study_on(int64_t now);
  void take_piece(const std::shared_ptr<LogStudy>& study, const LogStudy::Piece& piece);

  FrameSource source_;
  BridgeOptions options_;
  std::function<bool()> stop_;
  std::map<SocketId, Viewer> viewers_;
  BridgeCounts counts_;
  SessionWords words_;
  // files that are being sent: their readers share them
  std::map<std::string, std::weak_ptr<const std::string>> files_;
  bool is_connected_ = false, is_asking_ = false, is_leading_ = false;
  int64_t asked_ns_ = 0, records_ns_ = 0;
  std::optional<std::string> next_lead_;
  WebServer server_;
  // they end before the server, which gets their results
  Worker commands_, leads_, status_;
  // of a log: what reads long parts of it, on a thread of its own; null before the first task
  std::shared_ptr<LogStudy> study_;
  bool is_studying_ = false, has_studied_all_ = false;
  int64_t studied_ns_ = 0;
  Worker reads_;
};

}  // namespace haptic
