// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "clients/log/log_index.h"
#include "clients/view/frame_source.h"
#include "clients/view/playback.h"

namespace haptic {

/// One page's view of a log: each page has its own slider.
struct LogPage {
  struct Column {
    View view;
    uint64_t first_new = 0;  // sample: those before it have been sent, or are another time
  };
  Playback playback;
  std::vector<std::unique_ptr<Column>> columns;
  std::optional<uint64_t> shown;  // tick
  uint64_t unseen = 0;            // ticks passed over since the frame before
};

/// A recording that is played. All of it runs on the bridge's thread: it reads the few chunks
/// around a tick, which takes milliseconds; what takes longer is in LogStudy.
class LogSource {
 public:
  /// A file without any servo frame, which is still written, is waited for. With a tightest place
  /// pages begin there. Throws McapError: no recording, or a complete one without frames.
  explicit LogSource(std::string path, std::optional<TightestPlace> tightest = {});

  SourceNews advance(int64_t now_ns);
  const View& view() const { return view_; }
  const SceneInfo& scene() const { return info_; }
  const std::string& path() const { return path_; }
  std::vector<std::string> columns() const;
  /// Takes marks that have been found; `is_news`: more of the file has been read for them.
  void add_marks(const std::vector<LogMark>& marks, bool is_news);
  /// Tells it on standard error, once.
  void tell_trouble(const std::string& trouble);

  /// A page at the beginning, or at the tightest place.
  std::unique_ptr<LogPage> open_page() const;
  void take(LogPage& page, const LogMessage& message, int64_t now_ns) const;
  /// Reads what the page is to be shown now; false if it has that already. A damaged place is told
  /// once on standard error, and not shown.
  bool show(LogPage& page, int64_t now_ns);

 private:
  void look();
  void describe();
  void read_ticks();
  LogTicks ticks() const;
  void fill(LogPage::Column& column, size_t number, uint64_t from, uint64_t tick);
  void next_mark(LogPage& page, const NextMessage& next, int64_t now_ns) const;

  std::string path_;
  std::unique_ptr<LogIndex> index_;  // null: no frame yet
  View view_;                        // the beginning
  SceneInfo info_;
  bool has_arrived_ = false, has_news_ = false;
  int64_t looked_ns_ = 0, told_ns_ = 0;
  std::string trouble_;  // the last one that was told
};

/// A recording as a source of frames. Throws McapError.
FrameSource log_source(const std::string& path, std::optional<TightestPlace> tightest = {});

}  // namespace haptic
