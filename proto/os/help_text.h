// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace haptic {

/// The content of what `--help` prints about a command, before its layout.
struct HelpPage {
  struct Row {
    std::string name, text;
  };
  struct Group {
    std::string title;
    std::vector<Row> rows;
  };
  std::string about, usage;
  std::vector<Group> groups;
  std::string footer;
};

/// Longest line of a help text [characters].
inline constexpr size_t kHelpWidth = 80;

/// The page in lines of at most kHelpWidth characters. Lines of the footer that begin with a space
/// (examples) stay as they are.
std::string help_text(const HelpPage& page);

}  // namespace haptic
