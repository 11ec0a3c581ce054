// SPDX-License-Identifier: GPL-3.0-or-later
// The bridge plays a recording: each page has its own slider, and long reads run on a thread.
#include "clients/view/bridge.h"
#include "proto/os/realtime.h"

namespace haptic {
namespace {

constexpr int64_t kStudyPeriod = kNsPerSecond / 2;  // [ns], between two looks at a log that grows

}  // namespace

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
