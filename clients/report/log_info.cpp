// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/report/log_info.h"

#include <algorithm>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <map>
#include <optional>

#include "clients/log/log_columns.h"
#include "clients/report/summary.h"
#include "proto/log/trace.h"
#include "proto/os/json.h"
#include "proto/os/message.h"
#include "proto/os/text.h"
#include "proto/wire/renderer.h"

namespace haptic {
namespace {

constexpr double kNs = 1e-9;  // [s]

/// Counts and times of a channel, gathered while the file is read.
struct Channel {
  TopicSummary summary;
  int64_t first_ns = 0, last_ns = 0;
  std::optional<TopicDecoder> frames;  // of the servo
  uint64_t skipped = 0;                // by the last frame
};

std::string fault_word(uint32_t fault) {
  static constexpr const char* kWords[] = {
      "none",       "device not finite", "contacts not finite", "force not finite",
      "force huge", "pose jump",         "device stale",        "device noisy"};
  return fault < std::size(kWords) ? kWords[fault] : "number " + std::to_string(fault);
}

void add_frame(const ServoFrame& frame, uint64_t& skipped, LogInfo& info) {
  if ((frame.flags & kServoStopped) != 0) return;  // the closing frame of a servo is not a tick
  ++info.frames;
  info.touching += is_touching(frame);
  info.max_force = std::max(info.max_force, norm(frame.F_device_B.f));
  info.fault_ticks += (frame.flags & kServoFault) != 0;
  if (frame.fault != 0) info.faults.insert(fault_word(frame.fault));
  // a servo that was started again counts from zero
  info.late_ticks += frame.skipped >= skipped ? frame.skipped - skipped : frame.skipped;
  skipped = frame.skipped;
  if (is_renderer(frame.renderer)) {
    info.renderers.insert(std::string(row_of(static_cast<Renderer>(frame.renderer)).name));
  }
}

std::map<uint16_t, Channel> channels_of(const TraceReader& trace) {
  std::map<uint16_t, Channel> out;
  const std::vector<TopicInfo> ours = trace.topics();
  for (const McapChannel& channel : trace.mcap().channels()) {
    Channel& entry = out[channel.id];
    entry.summary.topic = channel.topic;
    const auto is_it = [&](const TopicInfo& topic) { return topic.name == channel.topic; };
    const auto own = std::ranges::find_if(ours, is_it);
    entry.summary.ours = own != ours.end();
    for (const McapSchema& schema : trace.mcap().schemas()) {
      if (schema.id == channel.schema) entry.summary.schema = schema.name;
    }
    if (entry.summary.ours && own->schema == Schema<ServoFrame>::name) {
      entry.frames = trace.decoder(*own);
    }
  }
  return out;
}

void add_message(const McapMessage& message, std::map<uint16_t, Channel>& channels, LogInfo& info) {
  const auto found = channels.find(message.channel);
  if (found == channels.end()) return;
  Channel& channel = found->second;
  const auto t_ns = static_cast<int64_t>(message.log_time_ns);
  if (channel.summary.count++ == 0) channel.first_ns = channel.last_ns = t_ns;
  channel.first_ns = std::min(channel.first_ns, t_ns);
  channel.last_ns = std::max(channel.last_ns, t_ns);
  if (!channel.frames) return;
  ServoFrame frame;
  std::memcpy(&frame, channel.frames->decode(message), sizeof frame);
  if (channel.summary.count == 1) channel.skipped = frame.skipped;
  add_frame(frame, channel.skipped, info);
}

void add_metadata(const McapReader& mcap, LogInfo& info) {
  info.session = mcap.metadata("recording", "session");
  info.version = mcap.metadata("recording", "version");
  info.abi = mcap.metadata("recording", "abi");
  info.host = mcap.metadata("recording", "host");
  info.has_config = !mcap.metadata("recording", "config").empty();
  info.knows_losses = mcap.metadata().contains("counts");
  for (TopicSummary& topic : info.topics) {
    const std::string lost = mcap.metadata("counts", topic.topic + " lost");
    topic.lost = std::strtoull(lost.c_str(), nullptr, 10);
    info.lost += topic.lost;
  }
}

std::string local_time(int64_t realtime_ns) {
  const std::time_t seconds = realtime_ns / 1'000'000'000;
  std::tm broken{};
  char text[64] = "";
  if (localtime_r(&seconds, &broken) != nullptr) {
    std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%S%z", &broken);
  }
  return text;
}

/// "a, b", or "none".
std::string list_of(const auto& words) {
  return words.empty() ? "none" : joined(words);
}

double contact_share(const LogInfo& info) {
  return info.frames == 0
             ? 0
             : 100 * static_cast<double>(info.touching) / static_cast<double>(info.frames);
}

}  // namespace

LogInfo read_log_info(const std::string& path, const std::function<void(double)>& told) {
  const TraceReader trace(path);
  const McapReader& mcap = trace.mcap();
  LogInfo info;
  info.path = path;
  info.bytes = std::filesystem::file_size(path);
  info.was_finished = mcap.finished();
  info.notice = trace.notice(*find_topic(servo_topic(kFirstHand).name));
  std::map<uint16_t, Channel> channels = channels_of(trace);
  for (size_t i = 0; i < mcap.chunks().size(); ++i) {
    mcap.for_each_in(mcap.chunks()[i],
                     [&](const McapMessage& message) { add_message(message, channels, info); });
    if (told) told(static_cast<double>(i + 1) / static_cast<double>(mcap.chunks().size()));
  }
  int64_t end_ns = 0;
  for (auto& [id, channel] : channels) {
    const double seconds = kNs * static_cast<double>(channel.last_ns - channel.first_ns);
    TopicSummary& topic = channel.summary;
    if (topic.count > 1 && seconds > 0) topic.rate = static_cast<double>(topic.count - 1) / seconds;
    // control and events are of before, too
    if (topic.count > 0 && (channel.frames || info.begin_ns == 0)) {
      const bool is_first = info.begin_ns == 0 || channel.first_ns < info.begin_ns;
      if (is_first) info.begin_ns = channel.first_ns;
      end_ns = std::max(end_ns, channel.last_ns);
    }
    info.topics.push_back(topic);
  }
  info.duration = kNs * static_cast<double>(end_ns - info.begin_ns);
  add_metadata(mcap, info);
  for (const LogColumn& column : log_columns(trace)) {
    if (column.name != kSessionColumn) info.columns.push_back(column.name);
  }
  return info;
}

void print_info(std::ostream& out, const LogInfo& info) {
  const auto line = [&](const std::string& name, const std::string& text) {
    out << "  " << name << std::string(name.size() < 16 ? 16 - name.size() : 1, ' ') << text
        << '\n';
  };
  out << shown(info.path) << '\n';
  line("session", info.session.empty() ? "not said" : shown(info.session));
  line("began", local_time(info.begin_ns));
  line("version", shown(info.version) + ", layout " + shown(info.abi));
  if (!info.notice.empty()) line("layout", info.notice);
  line("duration", formatted("%.1f s", info.duration));
  line("size", std::to_string(info.bytes >> 10) + " KiB");
  if (!info.columns.empty()) line("columns", joined(info.columns));
  line("renderers", list_of(info.renderers));
  line("contact", formatted("%.1f %% of the ticks", contact_share(info)));
  line("max force", formatted("%.3g N", info.max_force));
  line("late ticks", std::to_string(info.late_ticks));
  line("faults",
       list_of(info.faults) +
           (info.fault_ticks == 0 ? "" : ", " + std::to_string(info.fault_ticks) + " ticks"));
  line("lost records", info.knows_losses ? std::to_string(info.lost) : "not counted");
  line("session file", info.has_config ? "inside" : "not inside");
  line("end", info.was_finished ? "complete"
                                : "missing: the recorder was killed or still records; "
                                  "`hapt recover` makes a complete file");
  for (const TopicSummary& topic : info.topics) {
    line(shown(topic.topic),
         std::to_string(topic.count) + formatted(", %.4g Hz, ", topic.rate) + shown(topic.schema) +
             (topic.lost == 0 ? "" : ", " + std::to_string(topic.lost) + " lost"));
  }
}

void print_info_json(std::ostream& out, const LogInfo& info) {
  Json topics = Json::array();
  for (const TopicSummary& topic : info.topics) {
    topics.push_back({{"topic", topic.topic},
                      {"schema", topic.schema},
                      {"count", topic.count},
                      {"rate_hz", topic.rate},
                      {"lost", topic.lost},
                      {"ours", topic.ours}});
  }
  out << json_line({{"file", info.path},
                    {"session", info.session},
                    {"began", local_time(info.begin_ns)},
                    {"version", info.version},
                    {"abi", info.abi},
                    {"host", info.host},
                    {"duration_s", info.duration},
                    {"bytes", info.bytes},
                    {"renderers", info.renderers},
                    {"columns", info.columns},
                    {"frames", info.frames},
                    {"contact_percent", contact_share(info)},
                    {"max_force_n", info.max_force},
                    {"late_ticks", info.late_ticks},
                    {"fault_ticks", info.fault_ticks},
                    {"faults", info.faults},
                    {"lost", info.knows_losses ? Json(info.lost) : Json(nullptr)},
                    {"config", info.has_config},
                    {"ended", info.was_finished},
                    {"notice", info.notice},
                    {"topics", topics}})
      << '\n';
}

}  // namespace haptic
