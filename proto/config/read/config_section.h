// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <initializer_list>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "proto/config/config_names.h"
#include "proto/config/quantity.h"
#include "proto/math/pose.h"

// toml++ is slow to compile: only config_section.cpp includes it
namespace toml {
inline namespace v3 {
class array;
class node;
class table;
struct source_region;
}  // namespace v3
}  // namespace toml

/// Checked reading of one table of a configuration file.
namespace haptic {

/// The words a key may have, with their values.
template <typename Enum, size_t N>
using Words = std::array<std::pair<std::string_view, Enum>, N>;

/// The words of a table whose rows have a name and an id.
template <typename Row, size_t N>
constexpr auto words_of(const std::array<Row, N>& rows) {
  Words<decltype(Row::id), N> words;
  for (size_t i = 0; i < N; ++i) words[i] = {rows[i].name, rows[i].id};
  return words;
}

class Key;
class Section;

/// A parsed configuration file. Throws ConfigError with file, line and column if the text is not
/// TOML.
class TomlDocument {
 public:
  TomlDocument(std::string_view text, std::string origin);
  ~TomlDocument();
  TomlDocument(const TomlDocument&) = delete;

  /// The whole document; valid as long as it.
  Section root() const;
  /// Puts those of the tables `keys` that the k-th table of [[list]] has in the place of the
  /// document's.
  void prefer(std::string_view list, size_t k, std::span<const std::string_view> keys);

 private:
  std::string origin_;
  std::unique_ptr<toml::table> table_;
};

/// A table whose keys are read one by one. Each read_* returns whether the key is present and
/// leaves `out` alone if not; it throws ConfigError with file, line and column if the value is
/// invalid. finish() rejects keys that were never asked for.
class Section {
 public:
  /// `name` as written: "[device.hand]".
  Section(const toml::table& table, std::string name, const std::string& file)
      : table_(table), name_(std::move(name)), file_(file) {}

  bool read_quantity(std::string_view key, Dimension dimension, const Range& range, double& out);
  /// Several keys in this order; each may be left out where it has no example.
  void read_all(std::initializer_list<Key> keys);
  bool read_number(std::string_view key, const Range& range, double& out);
  bool read_integer(std::string_view key, int64_t min, int64_t max, int64_t& out);
  template <typename Integer>
  bool read_integer(std::string_view key, int64_t min, int64_t max, Integer& out) {
    int64_t value = 0;
    if (!read_integer(key, min, max, value)) return false;
    out = static_cast<Integer>(value);
    return true;
  }
  bool read_flag(std::string_view key, uint32_t& out);
  bool read_text(std::string_view key, std::string& out);
  /// Text that must fit into a fixed array.
  template <size_t N>
  bool read_text(std::string_view key, std::array<char, N>& out) {
    std::string text;
    if (!read_text(key, text)) return false;
    if (text.size() >= N) {
      fail_at(key, "is longer than " + std::to_string(N - 1) + " characters; shorten it");
    }
    assign(out, text);
    return true;
  }
  /// One to `most` texts; `example` is the line that a message shows.
  bool read_texts(std::string_view key, size_t most, const std::string& example,
                  std::vector<std::string>& out);
  /// A file, by its path from this folder; it need not be there.
  bool read_path(std::string_view key, const std::filesystem::path& folder, Path& out);
  /// One of the given words; `mend` ends the message about another one.
  template <typename Enum, size_t N>
  bool read_choice(std::string_view key, const Words<Enum, N>& words, Enum& out,
                   const std::string& mend = "") {
    std::string text;
    if (!read_text(key, text)) return false;
    std::vector<std::string_view> known;
    for (const auto& [word, value] : words) {
      known.push_back(word);
      if (word != text) continue;
      out = value;
      return true;
    }
    fail_at(key, "is '" + shown(text) + "'; " + suggestion(text, known) + mend);
  }
  /// Three quantities of one kind.
  bool read_quantities(std::string_view key, Dimension dimension, const Range& range, Vec3& out);
  bool read_lengths(std::string_view key, const Range& range, Vec3& out);
  /// Three numbers without unit.
  bool read_numbers(std::string_view key, const Range& range, Vec3& out);
  /// One to `most` rows of quantities, each with these columns:
  /// [["0 deg", "0 N·m"], ["2 deg", "1 N·m"]]; `out` has them row by row.
  bool read_rows(std::string_view key, std::span<const Dimension> columns, size_t most,
                 std::vector<double>& out);
  /// Three numbers, normalised to a unit vector.
  bool read_direction(std::string_view key, Vec3& out);
  /// {axis, angle} or {quaternion = [x, y, z, w]}.
  bool read_rotation(std::string_view key, Quat& out);
  /// Keys `position` and `rotation`.
  void read_pose(Pose& out);

  /// A table inside this one; empty if absent.
  std::optional<Section> section(std::string_view key);
  /// Reads a table inside this one and finishes it; false: it is absent. With an example it must be
  /// there.
  bool within(std::string_view key, const std::function<void(Section&)>& read,
              const char* example = nullptr);
  /// The tables of [[key]], in order.
  std::vector<Section> sections(std::string_view key);

  bool has(std::string_view key) const;
  void finish() const;

  /// Throws ConfigError at the value of `key`: "file:line:column: 'key' what".
  [[noreturn]] void fail_at(std::string_view key, const std::string& what) const;
  /// Throws ConfigError at the head of the table: 'key' is missing, for example `example`.
  [[noreturn]] void fail_missing(std::string_view key, const std::string& example) const;
  void require(std::string_view key, const std::string& example);

 private:
  const toml::node* take(std::string_view key);
  void read_rotation(Quat& out);
  std::string name_within(std::string_view key) const;
  [[noreturn]] void fail(const toml::source_region& at, const std::string& what) const;
  double quantity_of(const toml::node& node, std::string_view key, Dimension dimension,
                     const Range& range) const;
  double number_of(const toml::node& node, std::string_view key, const Range& range) const;
  const toml::array& array_of(const toml::node& node, std::string_view key, size_t size,
                              const std::string& example) const;

  const toml::table& table_;
  std::string name_;
  const std::string& file_;
  std::vector<std::string_view> asked_;
};

/// A key of a table, the kind of its value, and where that goes. With an example it must be there.
class Key {
 public:
  /// A quantity, or three of one kind.
  template <typename Value>
  Key(std::string_view key, Dimension dimension, const Range& range, Value& out,
      const char* example = nullptr)
      : Key(key, example, [key, dimension, range, &out](Section& section) {
          if constexpr (std::is_same_v<Value, Vec3>) {
            section.read_quantities(key, dimension, range, out);
          } else {
            section.read_quantity(key, dimension, range, out);
          }
        }) {}
  /// A number without unit.
  Key(std::string_view key, const Range& range, double& out)
      : Key(key, nullptr, [key, range, &out](Section& s) { s.read_number(key, range, out); }) {}
  /// A whole number.
  template <typename Integer>
  Key(std::string_view key, int64_t min, int64_t max, Integer& out, const char* example = nullptr)
      : Key(key, example,
            [key, min, max, &out](Section& s) { s.read_integer(key, min, max, out); }) {}
  /// True or false.
  Key(std::string_view key, uint32_t& out)
      : Key(key, nullptr, [key, &out](Section& s) { s.read_flag(key, out); }) {}
  /// Text that must fit into a fixed array.
  template <size_t N>
  Key(std::string_view key, std::array<char, N>& out, const char* example = nullptr)
      : Key(key, example, [key, &out](Section& s) { s.read_text(key, out); }) {}
  /// One of the given words.
  template <typename Enum, size_t N>
  Key(std::string_view key, const Words<Enum, N>& words, Enum& out, const char* example = nullptr)
      : Key(key, example, [key, &words, &out](Section& s) { s.read_choice(key, words, out); }) {}

 private:
  friend class Section;
  Key(std::string_view key, const char* example, std::function<void(Section&)> read)
      : key_(key), example_(example), read_(std::move(read)) {}

  std::string_view key_;
  const char* example_;
  std::function<void(Section&)> read_;
};

}  // namespace haptic
