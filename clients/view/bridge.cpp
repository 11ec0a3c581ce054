// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/view/bridge.h"

#include <algorithm>

#include "clients/view/drawn/drawings.h"
#include "proto/ipc/control_socket.h"
#include "proto/os/message.h"
#include "proto/os/realtime.h"
#include "proto/os/regular_file.h"
#include "proto/os/text.h"

namespace haptic {
namespace {

constexpr int64_t kIdlePeriod = 50'000'000;         // [ns], while nobody watches
constexpr int64_t kStudyPeriod = kNsPerSecond / 2;  // [ns], between two looks at a log that grows
constexpr int64_t kStatusPeriod = kNsPerSecond;     // [ns]
constexpr int64_t kRecordPeriod = 2 * kTickPeriod;  // [ns]: 60 Hz for Foxglove
constexpr size_t kMostCommands = 32;                // that wait for hapticd
constexpr size_t kMostReads = 16;                   // overviews and tables that wait
constexpr size_t kLargestFile = size_t{64} << 20;   // of the page [bytes]
constexpr int kMostWrongTokens = 5;                 // of one connection
constexpr const char* kPageProtocol = "hapticd.view.v1";
constexpr const char* kJson = "application/json";
constexpr const char* kBytes = "application/octet-stream";

bool offers(const WebRequest& request, const std::string& protocol) {
  return std::find(request.protocols.begin(), request.protocols.end(), protocol) !=
         request.protocols.end();
}

/// True if the path can name a file of the page: letters, digits and a few signs, no hidden file.
bool is_page_path(const std::string& path) {
  const auto is_known = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '/' ||
           c == '.' || c == '-' || c == '_';
  };
  return std::all_of(path.begin(), path.end(), is_known) && path.find("/.") == path.npos;
}

/// "tool" of "/mesh/tool.bin" where the folder is "/mesh/"; empty: the path is another's.
std::string name_in(const std::string& folder, const std::string& path) {
  constexpr std::string_view kEnd = ".bin";
  if (!path.starts_with(folder) || !path.ends_with(kEnd)) return {};
  if (path.size() <= folder.size() + kEnd.size()) return {};
  return path.substr(folder.size(), path.size() - folder.size() - kEnd.size());
}

/// An eye file by name: that of the tool, or of an object by its number.
WebAnswer mesh_answer(const std::string& name, const SharedText& tool,
                      const std::vector<SharedText>& objects) {
  SharedText eye = name == "tool" ? tool : nullptr;
  for (size_t i = 0; i < objects.size(); ++i) {
    if (name == std::to_string(i)) eye = objects[i];
  }
  if (eye == nullptr) return text_answer(404, "there is no such mesh");
  return {200, kBytes, eye};
}

}  // namespace

Bridge::Bridge(FrameSource source, BridgeOptions options)
    : source_(std::move(source)),
      options_(std::move(options)),
      server_(options_.web, handlers()),
      commands_(kMostCommands),
      leads_(1),
      status_(1),
      reads_(kMostReads) {
  options_.rules.port = server_.port();
}

void Bridge::run(const std::function<bool()>& stop) {
  stop_ = stop;
  server_.every([this] { return tick(); });
  server_.run();
}

WebHandlers Bridge::handlers() {
  return {[this](const WebRequest& request) { return answer(request); },
          [this](const WebRequest& request) { return upgrade(request); },
          [this](SocketId id, const std::string& protocol) { open(id, protocol); },
          [this](SocketId id, std::string_view message, bool is_text) {
            if (is_text) return hear(id, message);
            server_.close(id, CloseCode::kUnsupported, "only text is understood here");
          },
          [this](SocketId id) {
            const auto viewer = viewers_.find(id);
            if (viewer == viewers_.end()) return;
            viewer->second.is_writing = false;
            say_next(id, viewer->second);
          },
          [this](SocketId id) { viewers_.erase(id); }};
}

WebAnswer Bridge::answer(const WebRequest& request) {
  if (!is_host_allowed(options_.rules, request.host)) {
    return text_answer(403,
                       "this bridge is not '" + shown(request.host) +
                           "'; open the address that it printed, or start it with --allow-host");
  }
  const Target target = parse_target(request.target);
  if (!target.problem.empty()) return text_answer(400, target.problem);
  if (request.method != "GET" && request.method != "HEAD") {
    return text_answer(405, "only GET and HEAD are understood here");
  }
  if (target.path == "/layout.json") return {200, kJson, shared_text(layout_json())};
  if (target.path == "/scene.json") return {200, kJson, shared_text(scene(false))};
  if (target.path == "/metrics") {
    counts_.viewers = viewers_.size();
    counts_.connections = server_.peers();
    return {200, "text/plain; version=0.0.4; charset=utf-8",
            shared_text(metrics_text(source_.view(), counts_, is_connected_))};
  }
  if (target.path == "/overview.json" || target.path == "/export.csv") {
    return study(target.path, target.query);
  }
  const EyeFiles& eyes = source_.scene().eyes;
  if (const std::string name = name_in("/mesh/", target.path); !name.empty()) {
    return mesh_answer(name, eyes.tool, eyes.objects);
  }
  if (const std::string name = name_in("/pieces/", target.path); !name.empty()) {
    return mesh_answer(name, eyes.tool_pieces, eyes.object_pieces);
  }
  if (const std::string name = name_in("/drawn/", target.path); !name.empty()) {
    return drawing(name);
  }
  return file(target.path);
}

WebAnswer Bridge::drawing(const std::string& name) const {
  Drawings* drawings = source_.drawings();
  const auto client = number_from<uint32_t>(name);
  const SharedText bytes = drawings && client ? drawings->bytes(*client) : nullptr;
  if (bytes == nullptr) return text_answer(404, "no such client shows anything");
  return {200, kBytes, bytes};
}

WebAnswer Bridge::file(const std::string& path) {
  const std::string name = path == "/" ? "/index.html" : path;
  if (!is_page_path(name)) return text_answer(404, "there is nothing of that name");
  const auto sent = files_.find(name);
  if (sent != files_.end()) {
    if (SharedText same = sent->second.lock()) return {200, media_type(name), same};
  }
  std::string text;
  const bool is_there = !options_.page_folder.empty() &&
                        read_regular_file(options_.page_folder + name, kLargestFile, text).empty();
  if (is_there) {
    const SharedText shared = shared_text(std::move(text));
    files_[name] = shared;
    return {200, media_type(name), shared};
  }
  if (path != "/") return text_answer(404, "there is nothing of that name");
  return text_answer(
      404,
      "the page is not built: `cmake --build build/dev --target view_page` does it (it "
      "needs nodejs and npm); frames, metrics and Foxglove work without it");
}

UpgradeAnswer Bridge::upgrade(const WebRequest& request) const {
  const auto refused = [](unsigned status, const std::string& why) {
    return UpgradeAnswer{"", text_answer(status, why)};
  };
  if (!is_host_allowed(options_.rules, request.host)) {
    return refused(403, "this bridge is not '" + shown(request.host) + "'");
  }
  const Target target = parse_target(request.target);
  if (!target.problem.empty()) return refused(400, target.problem);
  const bool is_own = is_own_origin(request.origin, request.host);
  if (source_.log != nullptr && !offers(request, kPageProtocol)) {
    return refused(400, "a recording is shown to pages only; open its file in Foxglove itself");
  }
  if (offers(request, kPageProtocol)) {
    if (target.path != "/view") return refused(404, "the WebSocket of pages is at /view");
    if (!is_own) return refused(403, "a page of another origin may not watch");
    return {kPageProtocol, {}};
  }
  for (const char* protocol : kFoxgloveProtocols) {
    if (!offers(request, protocol)) continue;
    if (!request.origin.empty() && !is_own && !is_origin_allowed(options_.rules, request.origin)) {
      return refused(403, "the origin '" + shown(request.origin) +
                              "' may not watch; allow it with --allow-origin");
    }
    return {protocol, {}};
  }
  return refused(400,
                 "the sub-protocols here are hapticd.view.v1, foxglove.sdk.v1 and "
                 "foxglove.websocket.v1");
}

std::string Bridge::scene(bool with_config) const {
  return scene_json(source_.scene(), source_.view(), with_config);
}

void Bridge::open(SocketId id, const std::string& protocol) {
  Viewer& viewer = viewers_[id];
  viewer.is_foxglove = protocol != kPageProtocol;
  viewer.seen = source_.view().samples.end();
  viewer.seen_ticks = source_.view().ticks;
  const std::string& session = source_.scene().session;
  if (viewer.is_foxglove) {
    tell(id, viewer, {shared_text(foxglove_server_info(session))});
    return tell(id, viewer, {shared_text(foxglove_advertise())});
  }
  if (is_connected_) open_log(viewer);
  tell(id, viewer, {shared_text(hello(-1))});
  tell(id, viewer, {shared_text(is_connected_ ? scene(false) : gone())});
}

void Bridge::tell(SocketId id, Viewer& viewer, WebMessage message) {
  if (viewer.waiting.size() >= kMostWaiting) {
    return server_.close(id, CloseCode::kPolicy, "too much waits for this viewer to be read");
  }
  viewer.waiting.push_back(std::move(message));
  say_next(id, viewer);
}

void Bridge::tell_pages(const SharedText& text) {
  for (auto& [id, viewer] : viewers_) {
    if (!viewer.is_foxglove) tell(id, viewer, {text});
  }
}

void Bridge::say_next(SocketId id, Viewer& viewer) {
  if (viewer.is_writing || viewer.waiting.empty()) return;
  WebMessage next = std::move(viewer.waiting.front());
  viewer.waiting.pop_front();
  viewer.is_writing = true;
  server_.send(id, std::move(next));
}

void Bridge::hear(SocketId id, std::string_view text) {
  const auto found = viewers_.find(id);
  if (found == viewers_.end()) return;
  if (!found->second.is_foxglove) return hear_page(id, found->second, text);
  const std::string problem = hear_foxglove(found->second.foxglove, text);
  if (!problem.empty()) tell(id, found->second, {shared_text(foxglove_warning(problem))});
}

void Bridge::hear_page(SocketId id, Viewer& viewer, std::string_view text) {
  const PageMessage message = parse_page_message(text);
  if (const auto* bad = std::get_if<BadMessage>(&message)) {
    return server_.close(id, CloseCode::kPolicy, bad->problem);
  }
  if (const auto* shown_one = std::get_if<ShownMessage>(&message)) {
    if (shown_one->sequence + 1 == viewer.sequence) viewer.has_shown = true;
  } else if (const auto* rate = std::get_if<RateMessage>(&message)) {
    viewer.hz = rate->hz;
  } else if (const auto* token = std::get_if<TokenMessage>(&message)) {
    check_token(id, viewer, token->token);
  } else if (const auto* said = std::get_if<CommandMessage>(&message)) {
    command(id, viewer, *said);
  } else if (const auto* moved = std::get_if<LogMessage>(&message)) {
    if (viewer.log) source_.log->take(*viewer.log, *moved, now_ns());
  } else if (!viewer.may_control) {
    return;  // who only watches leads nobody
  } else if (const auto* led = std::get_if<LeadMessage>(&message)) {
    lead(lead_line(*led));
  } else if (std::holds_alternative<ReleaseMessage>(message)) {
    lead(release_line());
  }
}

void Bridge::check_token(SocketId id, Viewer& viewer, const std::string& token) {
  viewer.may_control = is_same_secret(token, options_.token);
  if (viewer.may_control) {
    tell(id, viewer, {shared_text(control_message(true, ""))});
    if (is_connected_) tell(id, viewer, {shared_text(scene(true))});
    return;
  }
  if (++viewer.wrong_tokens >= kMostWrongTokens) {
    return server_.close(id, CloseCode::kPolicy, "too many wrong tokens");
  }
  tell(id, viewer,
       {shared_text(control_message(false,
                                    "the token is not that of this bridge; open the address "
                                    "that it printed"))});
}

void Bridge::command(SocketId id, const Viewer& viewer, const CommandMessage& said) {
  const auto reply = [this, id, number = said.id](bool ok, const std::string& text) {
    const auto found = viewers_.find(id);
    if (found != viewers_.end())
      tell(id, found->second, {shared_text(answer_message(number, ok, text))});
  };
  if (!viewer.may_control) {
    return reply(false, "this page may only watch; open the address that the bridge printed");
  }
  if (source_.log != nullptr) return reply(false, "a recording takes no commands");
  const std::string problem = command_problem(said.line);
  if (!problem.empty()) return reply(false, problem);
  const bool is_taken = commands_.add([this, reply, line = said.line] {
    std::string text;
    bool ok = false;
    try {
      text = options_.say(line);
      const std::optional<std::string> refusal = refusal_in(text);
      ok = !refusal;
      if (refusal) text = *refusal;
    } catch (const std::exception& error) {
      text = error.what();
    }
    server_.post([reply, ok, text] { reply(ok, text); });
  });
  if (!is_taken) reply(false, "too many commands wait already; try again");
}

// one line under way, the newest next
void Bridge::lead(const std::string& line) {
  next_lead_ = line;
  if (!is_leading_) next_lead();
}

void Bridge::next_lead() {
  is_leading_ = next_lead_.has_value();
  if (!is_leading_) return;
  leads_.add([this, line = *next_lead_] {
    try {
      options_.say(line);
    } catch (const std::exception&) {
      // the page sees in its frames that nobody is led
    }
    server_.post([this] { next_lead(); });
  });
  next_lead_.reset();
}

int64_t Bridge::tick() {
  if (stop_()) {
    server_.stop();
    return 0;
  }
  const int64_t now = now_ns();
  hear_source(source_.advance(now));
  if (source_.log != nullptr) study_on(now);
  if (viewers_.empty()) return kIdlePeriod;
  if (source_.log != nullptr) {
    if (is_connected_) send_log_frames(now);
    return kTickPeriod;
  }
  if (now - asked_ns_ >= kStatusPeriod) ask_status(now);
  tell_drawings();
  if (is_connected_) {
    send_frames(now);
    if (now - records_ns_ >= kRecordPeriod - kTickPeriod / 2) send_records(now);
  }
  return kTickPeriod;
}

void Bridge::hear_source(SourceNews news) {
  if (news == SourceNews::kNothing) return;
  if (news == SourceNews::kChanged) return tell_scene();
  is_connected_ = news == SourceNews::kArrived;
  if (!is_connected_) {
    return tell_pages(
        shared_text(gone_message("hapticd has ended; the bridge connects again when "
                                 "it is back")));
  }
  if (source_.missed() >= 0) ++counts_.reconnects;
  for (auto& [id, viewer] : viewers_) open_log(viewer);
  tell_pages(shared_text(hello(source_.missed())));
  tell_scene();
}

void Bridge::tell_scene() {
  const SharedText watching = shared_text(scene(false)), controlling = shared_text(scene(true));
  for (auto& [id, viewer] : viewers_) {
    if (!viewer.is_foxglove) tell(id, viewer, {viewer.may_control ? controlling : watching});
  }
}

void Bridge::ask_status(int64_t now) {
  asked_ns_ = now;
  if (is_asking_ || !is_connected_) return tell_status();
  is_asking_ = true;
  status_.add([this] {
    SessionWords words;
    try {
      words = parse_status(options_.say("status"));
    } catch (const std::exception&) {
      // hapticd does not answer; the processes are seen in their segments
    }
    server_.post([this, words] {
      words_ = words;
      is_asking_ = false;
      tell_status();
    });
  });
}

void Bridge::tell_status() {
  const SharedText status =
      shared_text(status_message(source_.view(), words_, viewers_.size(), source_.view().lost));
  for (auto& [id, viewer] : viewers_) {
    // the next one is as good
    if (!viewer.is_foxglove && viewer.waiting.empty()) tell(id, viewer, {status});
  }
}

/// Told to a page that has read what it was told before: it asks for the newest bytes itself.
void Bridge::tell_drawings() {
  const uint64_t drawn = source_.view().drawn;
  SharedText message;
  for (auto& [id, viewer] : viewers_) {
    if (viewer.is_foxglove || viewer.seen_drawn == drawn || !viewer.waiting.empty()) continue;
    if (message == nullptr) {
      const Drawings* drawings = source_.drawings();
      message = shared_text(drawings != nullptr ? drawings->message() : no_drawings());
    }
    viewer.seen_drawn = drawn;
    tell(id, viewer, {message});
  }
}

void Bridge::send_frames(int64_t now) {
  const View& view = source_.view();
  if (!view.has_servo) return;
  InstantFrames frames(view);
  for (auto& [id, viewer] : viewers_) {
    if (viewer.is_foxglove || !is_due(viewer, now)) continue;
    if (!is_ready(viewer)) {
      ++counts_.frames_skipped;
      continue;
    }
    ++counts_.frames_sent;
    tell(id, viewer, frames.next(viewer));
  }
}

void Bridge::send_records(int64_t now) {
  records_ns_ = now;
  for (auto& [id, viewer] : viewers_) {
    if (!viewer.is_foxglove || !is_ready(viewer)) continue;
    for (std::string& message : foxglove_messages(viewer.foxglove, source_.view())) {
      viewer.waiting.push_back({shared_text(std::move(message)), false});
    }
    say_next(id, viewer);
  }
}

// A recording: each page has its own slider, and long reads run on a thread.

std::string Bridge::hello(double missed) const {
  const auto columns = source_.log ? source_.log->columns() : std::vector<std::string>{};
  return hello_message(source_.kind, source_.scene().session, missed, columns);
}

std::string Bridge::gone() const {
  return gone_message(source_.log ? "The recording has no servo frame yet; waiting for the first."
                                  : "hapticd cannot be reached");
}

void Bridge::open_log(Viewer& viewer) {
  if (source_.log && !viewer.is_foxglove) viewer.log = source_.log->open_page();
}

void Bridge::send_log_frames(int64_t now) {
  for (auto& [id, viewer] : viewers_) {
    if (!viewer.log || !is_due(viewer, now)) continue;
    if (!is_ready(viewer)) {
      ++counts_.frames_skipped;
      continue;
    }
    if (!source_.log->show(*viewer.log, now)) continue;
    for (std::string& frame : next_log_frames(viewer, now)) {
      ++counts_.frames_sent;
      viewer.waiting.push_back({shared_text(std::move(frame)), false});
    }
    say_next(id, viewer);
  }
}

/// Reads on in the whole of the log, a piece at a time, so that a question waits for one piece at
/// most.
void Bridge::study_on(int64_t now) {
  if (!is_connected_ || is_studying_ || now - studied_ns_ < kStudyPeriod) return;
  const SceneInfo& info = source_.scene();
  if (study_ != nullptr && !info.log->growing && has_studied_all_) return;
  is_studying_ = true;
  const Quat q_WB = info.config ? info.config->map.X_WB.q : Quat{};
  reads_.add([this, path = source_.log->path(), q_WB, known = study_] {
    std::shared_ptr<LogStudy> study = known;
    LogStudy::Piece piece;
    try {
      if (study == nullptr) study = std::make_shared<LogStudy>(path, q_WB);
      piece = study->advance();
    } catch (const std::exception& error) {
      piece.problem = error.what();
    }
    server_.post([this, study, piece] { take_piece(study, piece); });
  });
}

void Bridge::take_piece(const std::shared_ptr<LogStudy>& study, const LogStudy::Piece& piece) {
  study_ = study;
  is_studying_ = false;
  has_studied_all_ = !piece.has_more;
  // what is there is read at once; then for what is written since
  studied_ns_ = piece.has_more ? 0 : now_ns();
  if (!piece.problem.empty()) source_.log->tell_trouble(piece.problem);
  source_.log->add_marks(piece.marks, piece.is_news);
}

WebAnswer Bridge::study(std::string_view path, std::string query) {
  if (source_.log == nullptr) return text_answer(404, "only a recording has this");
  if (study_ == nullptr) return text_answer(503, "the recording is being opened; try again");
  const bool is_table = path == "/export.csv";
  WebAnswer answer;
  answer.later = [this, is_table, query = std::move(query),
                  study = study_](const std::function<void(WebAnswer)>& send) {
    const bool is_taken = reads_.add([=] {
      try {
        send(is_table ? study->table(query) : study->overview(query));
      } catch (const std::exception& error) {
        send(text_answer(500, one_line(error.what())));
      }
    });
    if (!is_taken) send(text_answer(503, "too many questions wait already; try again"));
  };
  return answer;
}

}  // namespace haptic
