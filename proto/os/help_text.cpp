// SPDX-License-Identifier: Apache-2.0
#include "proto/os/help_text.h"

#include <sstream>

#include "proto/os/message.h"

namespace haptic {
namespace {

constexpr size_t kTextColumn = 26;  // where the explanations of a list begin

/// The words of a text in lines that begin at `column`; the first one has reached `at`.
std::string wrapped(const std::string& text, size_t column, size_t at) {
  std::string out;
  std::istringstream words(text);
  bool is_first = true;
  for (std::string word; words >> word;) {
    const size_t width = count_characters(word);
    if (!is_first && at + 1 + width > kHelpWidth) {
      out += "\n" + std::string(column, ' ');
      at = column;
      is_first = true;
    }
    out += (is_first ? "" : " ") + word;
    at += width + (is_first ? 0 : 1);
    is_first = false;
  }
  return out + "\n";
}

std::string row_text(const HelpPage::Row& row) {
  const std::string name = "  " + row.name;
  const size_t width = count_characters(name);
  const bool fits = width + 2 <= kTextColumn;
  const std::string gap =
      fits ? std::string(kTextColumn - width, ' ') : "\n" + std::string(kTextColumn, ' ');
  return name + gap + wrapped(row.text, kTextColumn, kTextColumn);
}

}  // namespace

std::string help_text(const HelpPage& page) {
  std::string out = wrapped(page.about, 0, 0) + "\nUsage: " + page.usage + "\n";
  for (const HelpPage::Group& group : page.groups) {
    if (group.rows.empty()) continue;
    out += "\n" + group.title + ":\n";
    for (const HelpPage::Row& row : group.rows) out += row_text(row);
  }
  if (page.footer.empty()) return out;
  out += "\n";
  std::istringstream footer(page.footer);
  for (std::string line; std::getline(footer, line);) {
    out += line.starts_with(' ') ? line + "\n" : wrapped(line, 0, 0);
  }
  return out;
}

}  // namespace haptic
