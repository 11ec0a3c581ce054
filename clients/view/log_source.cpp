// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/view/log_source.h"

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <limits>

#include "clients/log/log_eyes.h"
#include "clients/view/frame.h"
#include "proto/config/renderer_needs.h"
#include "proto/ipc/eye_file.h"
#include "proto/os/message.h"
#include "proto/os/realtime.h"

namespace haptic {
namespace {

constexpr int64_t kLookPeriod = kNsPerSecond / 4;  // [ns], as often as a recorder writes
constexpr int64_t kTellPeriod = kNsPerSecond / 2;  // [ns], between two scenes with new marks
constexpr uint64_t kRateTicks = 100;               // before a jump, for the rate of contact
constexpr size_t kMostColumns = 16;                // of a comparison; each is a frame

void tell(const std::string& text) {
  std::cerr << "haptic-view: " << one_line(text) << '\n';
}

/// An eye file for a browser; null where there is none that can be read.
SharedText eye_of(const std::vector<std::byte>& bytes) {
  if (bytes.empty()) return nullptr;
  try {
    view_eye(bytes);
  } catch (const EyeError& error) {
    tell(error.what());
    return nullptr;
  }
  return std::make_shared<const std::string>(reinterpret_cast<const char*>(bytes.data()),
                                             bytes.size());
}

EyeFiles eyes_of(const McapReader& file) {
  const LogEyes found = read_log_eyes(file);
  if (!found.problem.empty()) tell(found.problem);
  EyeFiles eyes;
  eyes.tool = eye_of(found.tools[kFirstHand]);
  for (const auto& [object, bytes] : found.objects) {
    eyes.objects.resize(object + 1);
    eyes.objects[object] = eye_of(bytes);
  }
  return eyes;
}

}  // namespace

LogSource::LogSource(std::string path, std::optional<TightestPlace> tightest)
    : path_(std::move(path)) {
  info_.session = std::filesystem::path(path_).filename().string();
  info_.log.emplace();
  info_.log->tightest = std::move(tightest);
  look();
  if (index_ == nullptr) tell(path_ + ": has no servo frame yet; waiting for the first");
}

/// Opens the file if it has a frame.
void LogSource::look() {
  std::unique_ptr<LogIndex> index;
  try {
    index = std::make_unique<LogIndex>(path_);
  } catch (const McapError&) {
    if (McapReader(path_).finished()) throw;
    return;  // its recorder has not got as far
  }
  if (index->columns().size() > kMostColumns) {
    throw McapError(path_ + ": compares more than " + std::to_string(kMostColumns) +
                    " renderers; that many cannot be shown");
  }
  if (!index->frame_at(std::numeric_limits<uint32_t>::max())) {
    if (!index->is_growing()) {
      throw McapError(path_ + ": has no servo frames; name a recording of a session");
    }
    return;
  }
  index_ = std::move(index);
  describe();
}

/// Fills in what stays the same while the log is played: session file, meshes, columns.
void LogSource::describe() {
  const std::string text = index_->trace().mcap().metadata("recording", "config");
  const std::string problem = text.empty() ? "" : use_config(info_, text);
  if (!problem.empty()) {
    tell("the session file in it cannot be read here, so the page lacks names and limits: " +
         problem);
  }
  if (info_.config) {
    view_.X_WB = info_.config->map.X_WB;
    view_.solver =
        static_cast<uint32_t>(haptic::solver_of(info_.config->proxy, info_.config->renderer));
    view_.control.translational_stiffness = info_.config->coupling.translational_stiffness;
    view_.control.translational_damping = info_.config->coupling.translational_damping;
    view_.control.rotational_stiffness = info_.config->coupling.rotational_stiffness;
    view_.control.rotational_damping = info_.config->coupling.rotational_damping;
  }
  read_ticks();
  LogPage::Column first;
  first.view = view_;
  fill(first, 0, index_->first_tick(), index_->first_tick());
  view_ = first.view;
}

void LogSource::read_ticks() {
  LogFacts& log = *info_.log;
  log.first_tick = index_->first_tick();
  log.last_tick = index_->last_tick();
  log.first_time = 1e-9 * static_cast<double>(index_->time_of(log.first_tick));
  log.last_time = 1e-9 * static_cast<double>(index_->time_of(log.last_tick));
  log.growing = index_->is_growing();
  if (info_.eyes.tool == nullptr && info_.eyes.objects.empty()) {
    info_.eyes = eyes_of(index_->trace().mcap());
  }
}

SourceNews LogSource::advance(int64_t now) {
  if (now - looked_ns_ >= kLookPeriod && (index_ == nullptr || index_->is_growing())) {
    looked_ns_ = now;
    if (index_ == nullptr) {
      look();
    } else if (index_->refresh()) {
      read_ticks();
      has_news_ = true;
    }
  }
  if (index_ == nullptr) return SourceNews::kNothing;
  if (!std::exchange(has_arrived_, true)) return SourceNews::kArrived;
  if (!has_news_ || now - told_ns_ < kTellPeriod) return SourceNews::kNothing;
  told_ns_ = now;
  has_news_ = false;
  return SourceNews::kChanged;
}

std::vector<std::string> LogSource::columns() const {
  std::vector<std::string> names;
  if (index_ == nullptr) return names;
  for (const LogColumn& column : index_->columns()) names.push_back(column.name);
  return names;
}

void LogSource::tell_trouble(const std::string& trouble) {
  if (trouble_ != trouble) tell(trouble_ = trouble);
}

void LogSource::add_marks(const std::vector<LogMark>& marks, bool is_news) {
  if (!is_news) return;
  std::vector<LogMark>& all = info_.log->marks;
  all.insert(all.end(), marks.begin(), marks.end());
  std::ranges::stable_sort(all, {}, &LogMark::tick);
  has_news_ = true;
}

LogTicks LogSource::ticks() const {
  return {index_->first_tick(), index_->last_tick(), index_->rate()};
}

std::unique_ptr<LogPage> LogSource::open_page() const {
  if (index_ == nullptr) return nullptr;
  const auto& tightest = info_.log->tightest;
  const uint64_t begin = tightest ? tightest->tick : index_->first_tick();
  auto page = std::make_unique<LogPage>(LogPage{Playback(begin), {}, {}});
  for (size_t i = 0; i < index_->columns().size(); ++i) {
    page->columns.push_back(std::make_unique<LogPage::Column>());
    page->columns.back()->view = view_;
  }
  return page;
}

void LogSource::take(LogPage& page, const LogMessage& message, int64_t now) const {
  page.playback.at(now, ticks());  // what was played until now counts at the old speed
  if (const auto* next = std::get_if<NextMessage>(&message)) return next_mark(page, *next, now);
  std::visit(
      [&](const auto& one) {
        if constexpr (!std::is_same_v<std::decay_t<decltype(one)>, NextMessage>) {
          page.playback.take(one);
        }
      },
      message);
}

void LogSource::next_mark(LogPage& page, const NextMessage& next, int64_t now) const {
  const uint64_t tick = page.playback.at(now, ticks());
  std::optional<uint64_t> there;
  for (const LogMark& mark : info_.log->marks) {
    if (mark.kind != next.kind) continue;
    if (next.forward && mark.tick > tick) {
      there = mark.tick;
      break;
    }
    if (!next.forward && mark.tick < tick) there = mark.tick;
  }
  if (there) page.playback.take(SeekMessage{*there});
}

bool LogSource::show(LogPage& page, int64_t now) {
  const uint64_t tick = page.playback.at(now, ticks());
  if (page.shown == tick) return false;
  const bool goes_on = page.shown && *page.shown < tick && tick - *page.shown <= kMostSamples;
  const uint64_t from = goes_on ? *page.shown + 1 : tick;
  page.shown = tick;
  page.unseen = tick - from;
  try {
    for (size_t i = 0; i < page.columns.size(); ++i) {
      if (!goes_on) page.columns[i]->view.samples = {};
      fill(*page.columns[i], i, from, tick);
    }
  } catch (const McapError& error) {
    tell_trouble(error.what());
    return false;
  }
  return true;
}

/// The records of a tick, and the samples from `from` on.
void LogSource::fill(LogPage::Column& column, size_t number, uint64_t from, uint64_t tick) {
  View& view = column.view;
  const auto frame = index_->frame_at(tick, number);
  view.has_servo = frame.has_value();
  if (!frame) return;
  const auto add = [&](const ServoFrame& one) { view.samples.add(sample_of(one, view.X_WB)); };
  if (view.samples.end() == 0 && from > index_->first_tick()) {
    const uint64_t before = from - std::min(kRateTicks, from - index_->first_tick());
    index_->for_each_frame(before, from - 1, number, add);
  }
  column.first_new = view.samples.end();
  index_->for_each_frame(from, tick, number, add);
  view.servo = *frame;
  view.now_ns = frame->t_ns;
  view.tick_period = 1 / index_->rate();
  const auto contacts = index_->contacts_at(*frame, number);
  view.has_contacts = contacts != nullptr;
  view.contacts = contacts ? *contacts : ContactSet{};
  const auto scene = index_->scene_at(*frame, number);
  view.has_scene = scene.has_value();
  if (scene) view.scene = *scene;
  view.rate_servo = index_->rate();
  const uint64_t end = view.samples.end();
  view.rate_contact = end > 0 ? view.samples.at(end - 1).contact_rate : 0;
  view.rate_sim = std::numeric_limits<double>::quiet_NaN();
}

FrameSource log_source(const std::string& path, std::optional<TightestPlace> tightest) {
  const auto log = std::make_shared<LogSource>(path, std::move(tightest));
  return {"log",
          [log](int64_t now) { return log->advance(now); },
          [log]() -> const View& { return log->view(); },
          [log]() -> const SceneInfo& { return log->scene(); },
          [] { return -1.0; },
          log};
}

}  // namespace haptic
