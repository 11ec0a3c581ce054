// SPDX-License-Identifier: GPL-3.0-or-later
#include <optional>

#include "contact/bake/soup/formats.h"
#include "contact/bake/soup/text.h"

namespace haptic {
namespace {

/// Reads lines "v x y z" and "f 1/…/… …"; skips everything else.
class ObjText {
 public:
  ObjText(std::string_view bytes, SoupReader& reader)
      : cursor_(bytes, reader.path()), reader_(reader) {}

  void read() {
    do {
      const std::string_view key = word();
      if (key == "v") read_vertex();
      if (key == "f") read_face();
    } while (cursor_.next_line());
    const auto n_points = static_cast<int64_t>(reader_.n_points());
    if (highest_ <= n_points) return;
    highest_at_->fail("vertex index " + std::to_string(highest_) + " is out of range 1 to " +
                      std::to_string(n_points) + ": truncated or damaged; export it again");
  }

 private:
  /// Next word of the statement; a backslash at the end of a line continues it on the next.
  std::string_view word() {
    for (;;) {
      std::string_view found = cursor_.word_on_line();
      if (!found.ends_with('\\')) return found;
      found.remove_suffix(1);
      const bool more = cursor_.next_line();
      if (!found.empty() || !more) return found;
    }
  }
  void read_vertex() {
    Vec3 p;
    for (int i = 0; i < 3; ++i) p[i] = cursor_.coordinate(word());
    reader_.add_point(p);
  }
  void read_face() {
    std::vector<size_t> corners;
    for (std::string_view corner = word(); !corner.empty(); corner = word()) {
      corners.push_back(index(corner.substr(0, corner.find('/'))));
    }
    if (corners.size() < 3) {
      cursor_.fail("a face needs three corners: truncated; export it again");
    }
    reader_.add_polygon(std::move(corners));
  }
  /// Zero-based; the file counts from 1, or with negative numbers backwards from the last vertex so
  /// far.
  size_t index(std::string_view text) {
    const int64_t i = cursor_.integer(text, "a vertex index");
    const auto n_points = static_cast<int64_t>(reader_.n_points());
    if (i == 0 || i < -n_points) {
      cursor_.fail("vertex index " + std::to_string(i) + " is out of range; export it again");
    }
    // faces may precede their vertices: the highest index is checked at the end
    if (i > highest_) {
      highest_ = i;
      highest_at_.emplace(cursor_);
    }
    return static_cast<size_t>(i > 0 ? i - 1 : n_points + i);
  }

  TextCursor cursor_;
  SoupReader& reader_;
  int64_t highest_ = 0;
  std::optional<TextCursor> highest_at_;
};

}  // namespace

void read_obj(std::string_view bytes, SoupReader& reader) {
  ObjText(bytes, reader).read();
}

}  // namespace haptic
