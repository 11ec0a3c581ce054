// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/view/session_source.h"

#include <time.h>
#include <unistd.h>

#include <atomic>
#include <filesystem>
#include <iostream>
#include <mutex>
#include <optional>
#include <span>
#include <thread>
#include <utility>

#include "clients/library/client.h"
#include "clients/view/drawn/drawings.h"
#include "proto/config/renderer_needs.h"
#include "proto/ipc/control_socket.h"
#include "proto/ipc/sessions.h"
#include "proto/os/message.h"

namespace haptic {
namespace {

constexpr int64_t kRetryPeriod = 200'000'000;          // [ns], between two attempts to connect
constexpr int64_t kConfigPatience = 2 * kNsPerSecond;  // [ns], for the text of the session file
constexpr int64_t kAttachPatience = 5 * kNsPerSecond;  // [ns], for the first ring
constexpr int64_t kWaitPeriod = 2'000'000;             // [ns], while waiting for it
constexpr int64_t kDeadAfter = 250'000'000;            // [ns]; age of a heartbeat, as in hapt top

/// A connection to one hapticd, made anew for the next one: so memory of a session that has ended
/// is never taken for that of the present one.
struct Connection {
  Client client;
  RingSource<& ServoChannels::frames> servo = client.ring<&ServoChannels::frames>(Start::kNewest);
  RingSource<& ContactChannels::sets> contact = client.ring<&ContactChannels::sets>(Start::kOldest);
  RingSource<& SimChannels::frames> sim = client.ring<&SimChannels::frames>(Start::kOldest);
  RingSource<& ControlChannels::frames> control =
      client.ring<&ControlChannels::frames>(Start::kOldest);
  // shows that hapticd has taken this client; its segment is the first that is handed out
  RingSource<& ControlChannels::events> first =
      client.ring<&ControlChannels::events>(Start::kNewest);
  Drawings drawings{client};
  SceneInfo info;
  uint64_t eye_changes = 0;  // that `info` has

  explicit Connection(const std::string& session) : client(session) { client.start(); }
};

/// The bytes of an eye file, for a browser.
SharedText mesh_text(const EyeMesh* mesh) {
  if (mesh == nullptr) return nullptr;
  const std::vector<std::byte> bytes = write_eye(*mesh);
  return std::make_shared<const std::string>(reinterpret_cast<const char*>(bytes.data()),
                                             bytes.size());
}

/// The eye files of all objects, up to the last that has one.
std::vector<SharedText> texts_of(std::span<const std::shared_ptr<const EyeMesh>> meshes) {
  std::vector<SharedText> texts;
  for (const auto& mesh : meshes) texts.push_back(mesh_text(mesh.get()));
  while (!texts.empty() && texts.back() == nullptr) texts.pop_back();
  return texts;
}

/// Takes over the eye files that hapticd has handed to this client; whether there were new ones.
bool take_eyes(const Client& client, uint64_t& changes, SceneInfo& info) {
  const Eyes eyes = client.eyes();
  if (eyes.changes == changes) return false;
  changes = eyes.changes;
  info.eyes.tool = mesh_text(eyes.tools[kFirstHand].get());
  info.eyes.objects = texts_of(eyes.objects);
  info.eyes.tool_pieces = mesh_text(eyes.tool_pieces[kFirstHand].get());
  info.eyes.object_pieces = texts_of(eyes.object_pieces);
  return true;
}

/// The text of the session file; empty where this user may not have it.
std::string config_of(const std::string& session) {
  try {
    const std::string answer = say_to_session(session, "config", kConfigPatience);
    return refusal_in(answer) ? "" : answer;
  } catch (const HandoutError&) {
    return "";
  }
}

double clock_s(clockid_t clock) {
  timespec time{};
  clock_gettime(clock, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

/// When the writer of a segment was started, in seconds of CLOCK_MONOTONIC and to one clock tick of
/// the kernel; the header counts from the boot and goes on where the machine sleeps.
double start_of(const SegmentHeader& header) {
  const double per_second = static_cast<double>(sysconf(_SC_CLK_TCK));
  const double after_boot = static_cast<double>(header.process_start.load()) / per_second;
  return after_boot - (clock_s(CLOCK_BOOTTIME) - clock_s(CLOCK_MONOTONIC));
}

/// Throws HandoutError: no session, or it does not take this client.
std::unique_ptr<Connection> connect(const std::string& session) {
  auto connection = std::make_unique<Connection>(session);
  auto& first = connection->first;
  Event ignored{};
  for (const int64_t begin = now_ns(); first.header() == nullptr; first.latest(ignored)) {
    if (!connection->client.is_connected()) throw HandoutError(connection->client.refusal());
    if (now_ns() - begin > kAttachPatience) throw HandoutError("hapticd hands out no rings");
    sleep_until(now_ns() + kWaitPeriod);
  }
  connection->info.session = session;
  connection->info.started = start_of(*first.header());
  const std::string text = config_of(session);
  if (text.empty()) return connection;
  const std::string problem = use_config(connection->info, text);
  if (!problem.empty()) {
    std::cerr << "haptic-view: the session file cannot be read here, so the page lacks names and "
                 "limits: "
              << one_line(problem) << '\n';
  }
  return connection;
}

/// Tries to connect until it does.
class Connector {
 public:
  explicit Connector(std::string session) : session_(std::move(session)) {}
  ~Connector() {
    stop_ = true;
    if (thread_.joinable()) thread_.join();
  }
  Connector(const Connector&) = delete;

  void begin() {
    if (thread_.joinable()) return;
    thread_ = std::thread([this] { run(); });
  }

  /// The connection once it is there.
  std::unique_ptr<Connection> take() {
    std::unique_ptr<Connection> taken;
    {
      const std::lock_guard lock(mutex_);
      taken = std::move(made_);
    }
    if (taken != nullptr) thread_.join();
    return taken;
  }

 private:
  void run() {
    while (!stop_) {
      try {
        std::unique_ptr<Connection> made = connect(session_);
        const std::lock_guard lock(mutex_);
        made_ = std::move(made);
        return;
      } catch (const std::exception& error) {
        // it may come yet; each reason is told once
        const std::string why = one_line(error.what());
        if (std::exchange(told_, why) != why) std::cerr << "haptic-view: waits: " << why << '\n';
      }
      sleep_until(now_ns() + kRetryPeriod);
    }
  }

  std::string session_, told_;
  std::atomic<bool> stop_{false};
  std::mutex mutex_;
  std::unique_ptr<Connection> made_;
  std::thread thread_;
};

ProcessView process_view(const char* name, const auto& ring, int64_t now, double rate) {
  const SegmentHeader* header = ring.header();
  if (header == nullptr) return {name};
  const int64_t age_ns = now - header->heartbeat_ns.load();
  const auto state = static_cast<SegmentState>(header->state.load());
  return {name,
          header->pid.load(),
          ring.generation(),
          state == SegmentState::kRun && age_ns < kDeadAfter,
          1e-9 * static_cast<double>(age_ns),
          rate};
}

class SessionSource {
 public:
  explicit SessionSource(const std::string& session) : connector_(session) {
    info_.session = session;
    connector_.begin();
  }

  SourceNews advance(int64_t now) {
    view_.now_ns = now;
    if (connection_ == nullptr) return arrive(now);
    read(now);
    if (connection_->client.is_connected()) {
      const bool is_new = take_eyes(connection_->client, connection_->eye_changes, info_);
      return is_new ? SourceNews::kChanged : SourceNews::kNothing;
    }
    connection_.reset();
    ++view_.drawn;
    gone_ns_ = now;
    connector_.begin();
    return SourceNews::kGone;
  }

  const View& view() const { return view_; }
  Drawings* drawings() { return connection_ != nullptr ? &connection_->drawings : nullptr; }
  const SceneInfo& scene() const { return info_; }
  double missed() const { return missed_; }

 private:
  SourceNews arrive(int64_t now) {
    connection_ = connector_.take();
    if (connection_ == nullptr) return SourceNews::kNothing;
    missed_ = gone_ns_ > 0 ? 1e-9 * static_cast<double>(now - gone_ns_) : -1;
    info_ = std::move(connection_->info);
    view_.has_servo = view_.has_contacts = view_.has_scene = view_.has_control = false;
    view_.tick_period = 0;
    lost_before_ = view_.lost;
    view_.X_WB = info_.config ? info_.config->map.X_WB : Pose{};
    if (info_.config) {
      view_.solver =
          static_cast<uint32_t>(haptic::solver_of(info_.config->proxy, info_.config->renderer));
    }
    read(now);
    return SourceNews::kArrived;
  }

  void read(int64_t now) {
    Connection& c = *connection_;
    read_servo(c);
    if (c.contact.latest(view_.contacts)) {
      view_.has_contacts = true;
      add(view_.contact_busy, view_.contacts.busy_ns);
    }
    view_.has_scene |= c.sim.latest(view_.scene);
    const bool is_drawn = c.drawings.advance([&]() -> const ControlFrame& {
      view_.has_control |= c.control.latest(view_.control);
      return view_.control;
    });
    if (is_drawn) ++view_.drawn;
    servo_meter_.add(now, view_.ticks);
    if (view_.has_contacts) contact_meter_.add(now, view_.contacts.seq);
    if (view_.has_scene) sim_meter_.add(now, view_.scene.seq);
    view_.rate_servo = servo_meter_.rate();
    view_.rate_contact = contact_meter_.rate();
    view_.rate_sim = sim_meter_.rate();
    view_.processes = {process_view(ServoChannels::kName, c.servo, now, view_.rate_servo),
                       process_view(ContactChannels::kName, c.contact, now, view_.rate_contact),
                       process_view(SimChannels::kName, c.sim, now, view_.rate_sim),
                       process_view("hapticd", c.control, now, 0)};
    // hapticd's heart does not beat: it is there as long as the connection is
    view_.processes[3].runs = view_.processes[3].generation > 0;
    view_.processes[3].age = 0;
  }

  void read_servo(Connection& c) {
    const uint64_t lost = view_.lost;
    ServoFrame frame;
    while (c.servo.next(frame)) {
      if (view_.has_servo && frame.tick > view_.servo.tick) {
        view_.tick_period = 1e-9 * static_cast<double>(frame.t_ns - view_.servo.t_ns) /
                            static_cast<double>(frame.tick - view_.servo.tick);
      }
      if (frame.fault != 0 && (!view_.has_servo || view_.servo.fault == 0)) ++view_.faults;
      view_.servo = frame;
      view_.has_servo = true;
      view_.samples.add(sample_of(frame, view_.X_WB));
      ++view_.ticks;
      add(view_.wake_late, frame.wake_late_ns);
      add(view_.busy, frame.busy_ns);
    }
    view_.lost = lost_before_ + c.servo.lost();
    view_.ticks += view_.lost - lost;
  }

  static void add(DurationSum& sum, int64_t ns) {
    sum.sum += 1e-9 * static_cast<double>(ns);
    ++sum.count;
  }

  View view_;
  SceneInfo info_;
  std::unique_ptr<Connection> connection_;
  Connector connector_;
  RateMeter servo_meter_, contact_meter_, sim_meter_;
  int64_t gone_ns_ = 0;
  uint64_t lost_before_ = 0;  // by earlier connections
  double missed_ = -1;
};

}  // namespace

std::string name_of_session(const std::string& session) {
  return std::filesystem::path(find_session(session)).stem().string();
}

FrameSource session_source(const std::string& session) {
  const auto source = std::make_shared<SessionSource>(session);
  return {"session",
          [source](int64_t now) { return source->advance(now); },
          [source]() -> const View& { return source->view(); },
          [source]() -> const SceneInfo& { return source->scene(); },
          [source] { return source->missed(); },
          nullptr,
          [source] { return source->drawings(); }};
}

}  // namespace haptic
