// SPDX-License-Identifier: Apache-2.0
#include "proto/config/read/config_section.h"

#include <toml++/toml.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace haptic {
namespace {

constexpr double kUnitTolerance = 1e-3;  // of the length of a typed quaternion
constexpr size_t kLongestReason = 240;   // of a parser message, which may quote the file

/// Names of the types of a value, by toml::node_type.
constexpr std::array kTypeNames{
    "nothing",  "a table",       "an array",       "text",           "a number",
    "a number", "true or false", "a date or time", "a date or time", "a date or time"};

std::string type_name(const toml::node& node) {
  return kTypeNames[static_cast<size_t>(node.type())];
}

toml::table parse_toml(std::string_view text, const std::string& origin) {
  try {
    return toml::parse(text, std::string_view(origin));
  } catch (const toml::parse_error& error) {
    const toml::source_position at = error.source().begin;
    throw ConfigError(origin + ":" + std::to_string(at.line) + ":" + std::to_string(at.column) +
                      ": not TOML: " + printable(error.description(), kLongestReason) +
                      "; see https://toml.io for the syntax");
  }
}

}  // namespace

TomlDocument::TomlDocument(std::string_view text, std::string origin)
    : origin_(std::move(origin)),
      table_(std::make_unique<toml::table>(parse_toml(text, origin_))) {}

TomlDocument::~TomlDocument() = default;

Section TomlDocument::root() const {
  return Section(*table_, "the file", origin_);
}

void TomlDocument::prefer(std::string_view list, size_t k, std::span<const std::string_view> keys) {
  toml::array* const tables = table_->get_as<toml::array>(list);
  toml::table* const own = tables != nullptr ? tables->get_as<toml::table>(k) : nullptr;
  if (own == nullptr) return;
  for (const std::string_view key : keys) {
    toml::node* const node = own->get(key);
    if (node == nullptr) continue;
    // moved, since a copy forgets its line
    table_->insert_or_assign(key, std::move(*node));
    own->erase(key);
  }
}

bool Section::has(std::string_view key) const {
  return table_.contains(key);
}

void Section::fail(const toml::source_region& at, const std::string& what) const {
  throw ConfigError(file_ + ":" + std::to_string(at.begin.line) + ":" +
                    std::to_string(at.begin.column) + ": " + what);
}

void Section::fail_at(std::string_view key, const std::string& what) const {
  const toml::node* node = table_.get(key);
  fail(node != nullptr ? node->source() : table_.source(), "'" + std::string(key) + "' " + what);
}

void Section::fail_missing(std::string_view key, const std::string& example) const {
  // an empty file has no position
  toml::source_region at = table_.source();
  at.begin.line = std::max(at.begin.line, toml::source_index{1});
  at.begin.column = std::max(at.begin.column, toml::source_index{1});
  fail(at, name_ + " has no '" + std::string(key) + "'; add for example " + example);
}

void Section::require(std::string_view key, const std::string& example) {
  if (!has(key)) fail_missing(key, example);
}

const toml::node* Section::take(std::string_view key) {
  asked_.push_back(key);
  return table_.get(key);
}

void Section::finish() const {
  for (auto&& [key, node] : table_) {
    if (std::find(asked_.begin(), asked_.end(), key.str()) != asked_.end()) continue;
    fail(key.source(), "unknown key '" + shown(key.str()) + "' in " + name_ + "; " +
                           suggestion(key.str(), asked_));
  }
}

double Section::quantity_of(const toml::node& node, std::string_view key, Dimension dimension,
                            const Range& range) const {
  const std::string quoted = "'" + std::string(key) + "' ";
  const auto text = node.value_exact<std::string_view>();
  if (!text) {
    fail(node.source(),
         quoted +
             (node.is_number() ? std::string("needs a unit")
                               : "is " + type_name(node) + ", not text with a unit") +
             "; " + how_to_write(dimension));
  }
  try {
    return parse_quantity(*text, dimension, range);
  } catch (const QuantityError& error) {
    fail(node.source(), quoted + error.what());
  }
}

double Section::number_of(const toml::node& node, std::string_view key, const Range& range) const {
  const std::string quoted = "'" + std::string(key) + "' ";
  const auto value = node.is_number() ? node.value<double>() : std::nullopt;
  if (!value) {
    fail(node.source(), quoted + "is " + type_name(node) + ", not a number; write it without " +
                            "quotes and unit");
  }
  const std::string wrong = number_problem(*value, range);
  if (!wrong.empty()) fail(node.source(), quoted + wrong);
  return *value;
}

const toml::array& Section::array_of(const toml::node& node, std::string_view key, size_t size,
                                     const std::string& example) const {
  const toml::array* array = node.as_array();
  if (array == nullptr || array->size() != size) {
    fail(node.source(), "'" + std::string(key) + "' must be " + std::to_string(size) +
                            " values; write for example " + example);
  }
  return *array;
}

bool Section::read_quantity(std::string_view key, Dimension dimension, const Range& range,
                            double& out) {
  const toml::node* node = take(key);
  if (node != nullptr) out = quantity_of(*node, key, dimension, range);
  return node != nullptr;
}

void Section::read_all(std::initializer_list<Key> keys) {
  for (const Key& key : keys) {
    if (key.example_ != nullptr) require(key.key_, key.example_);
    key.read_(*this);
  }
}

bool Section::read_number(std::string_view key, const Range& range, double& out) {
  const toml::node* node = take(key);
  if (node != nullptr) out = number_of(*node, key, range);
  return node != nullptr;
}

bool Section::read_integer(std::string_view key, int64_t min, int64_t max, int64_t& out) {
  const toml::node* node = take(key);
  if (node == nullptr) return false;
  const auto value = node->value_exact<int64_t>();
  if (!value || *value < min || *value > max) {
    fail_at(key, "must be a whole number from " + std::to_string(min) + " to " +
                     std::to_string(max) + "; write it without quotes");
  }
  out = *value;
  return true;
}

bool Section::read_flag(std::string_view key, uint32_t& out) {
  const toml::node* node = take(key);
  if (node == nullptr) return false;
  const auto value = node->value_exact<bool>();
  if (!value) fail_at(key, "is " + type_name(*node) + "; write true or false");
  out = *value ? 1 : 0;
  return true;
}

bool Section::read_text(std::string_view key, std::string& out) {
  const toml::node* node = take(key);
  if (node == nullptr) return false;
  const auto value = node->value_exact<std::string>();
  if (!value) fail_at(key, "is " + type_name(*node) + ", not text; put it in quotes");
  if (value->empty()) fail_at(key, "is empty; write a value or remove the line");
  out = *value;
  return true;
}

bool Section::read_texts(std::string_view key, size_t most, const std::string& example,
                         std::vector<std::string>& out) {
  const toml::node* node = take(key);
  if (node == nullptr) return false;
  const toml::array* texts = node->as_array();
  if (texts == nullptr || texts->empty() || texts->size() > most) {
    fail_at(key, "must be a list of 1 to " + std::to_string(most) + " texts; write for example " +
                     example);
  }
  out.clear();
  for (const toml::node& text : *texts) {
    const auto value = text.value_exact<std::string>();
    if (!value || value->empty()) {
      fail(text.source(), "'" + std::string(key) + "' holds " + type_name(text) +
                              " where a text is to be; write for example " + example);
    }
    out.push_back(*value);
  }
  return true;
}

bool Section::read_path(std::string_view key, const std::filesystem::path& folder, Path& out) {
  std::string name;
  if (!read_text(key, name)) return false;
  const std::string path = std::filesystem::absolute(folder / name).lexically_normal().string();
  if (path.size() >= out.size()) fail_at(key, "is too long");
  assign(out, path);
  return true;
}

bool Section::read_quantities(std::string_view key, Dimension dimension, const Range& range,
                              Vec3& out) {
  const toml::node* node = take(key);
  if (node == nullptr) return false;
  const std::string one = "\"" + std::string(example_of(dimension)) + "\"";
  const toml::array& array = array_of(*node, key, 3, "[" + one + ", " + one + ", " + one + "]");
  for (int i = 0; i < 3; ++i) {
    out[i] = quantity_of(*array.get(static_cast<size_t>(i)), key, dimension, range);
  }
  return true;
}

bool Section::read_lengths(std::string_view key, const Range& range, Vec3& out) {
  return read_quantities(key, Dimension::kLength, range, out);
}

bool Section::read_rows(std::string_view key, std::span<const Dimension> columns, size_t most,
                        std::vector<double>& out) {
  const toml::node* node = take(key);
  if (node == nullptr) return false;
  std::string example = "[";
  for (const Dimension column : columns) {
    example += (example.size() > 1 ? ", \"" : "\"") + std::string(example_of(column)) + "\"";
  }
  example += "]";
  const toml::array* rows = node->as_array();
  if (rows == nullptr || rows->empty() || rows->size() > most) {
    fail(node->source(), "'" + std::string(key) + "' must be a list of 1 to " +
                             std::to_string(most) + " rows; write for example [" + example + "]");
  }
  out.clear();
  for (const toml::node& row : *rows) {
    const toml::array& array = array_of(row, key, columns.size(), example);
    for (size_t i = 0; i < columns.size(); ++i) {
      out.push_back(quantity_of(*array.get(i), key, columns[i], kAny));
    }
  }
  return true;
}

bool Section::read_numbers(std::string_view key, const Range& range, Vec3& out) {
  const toml::node* node = take(key);
  if (node == nullptr) return false;
  const toml::array& array = array_of(*node, key, 3, "[0, 0, 1]");
  for (int i = 0; i < 3; ++i) {
    out[i] = number_of(*array.get(static_cast<size_t>(i)), key, range);
  }
  return true;
}

bool Section::read_direction(std::string_view key, Vec3& out) {
  Vec3 direction;
  if (!read_numbers(key, kAny, direction)) return false;
  const double length = norm(direction);
  if (!(length > 0) || !std::isfinite(length)) {
    fail_at(key, "has no direction; write for example [0, 0, 1]");
  }
  out = direction / length;
  return true;
}

bool Section::read_rotation(std::string_view key, Quat& out) {
  return within(key, [&](Section& rotation) { rotation.read_rotation(out); });
}

void Section::read_rotation(Quat& out) {
  if (const toml::node* node = take("quaternion"); node != nullptr) {
    const toml::array& q = array_of(*node, "quaternion", 4, "[0, 0, 0, 1]");
    const auto part = [&](size_t i) { return number_of(*q.get(i), "quaternion", kAny); };
    const Quat typed{part(0), part(1), part(2), part(3)};
    if (!(std::abs(std::sqrt(dot(typed, typed)) - 1) < kUnitTolerance)) {
      fail_at("quaternion", "has not length 1; order is x, y, z, w, none is [0, 0, 0, 1]");
    }
    out = normalized(typed);
    return;
  }
  Vec3 axis{0, 0, 1};
  double angle = 0;
  require("axis", "axis = [0, 0, 1]");
  require("angle", "angle = \"90 deg\"");
  read_direction("axis", axis);
  read_quantity("angle", Dimension::kAngle, kAny, angle);
  out = from_rotation_vector(angle * axis);
}

void Section::read_pose(Pose& out) {
  read_lengths("position", kAny, out.p);
  read_rotation("rotation", out.q);
}

/// Within [device] the name is device.hand, within [[object]] it is object.motion.
std::string Section::name_within(std::string_view key) const {
  const size_t begin = name_.find_first_not_of('[');
  const bool is_top = begin == 0;
  const std::string outer = is_top ? "" : name_.substr(begin, name_.find(']') - begin) + ".";
  return outer + std::string(key);
}

std::optional<Section> Section::section(std::string_view key) {
  const toml::node* node = take(key);
  if (node == nullptr) return std::nullopt;
  const toml::table* table = node->as_table();
  if (table == nullptr) fail_at(key, "is " + type_name(*node) + ", not a table; see configs/");
  return Section(*table, "[" + name_within(key) + "]", file_);
}

bool Section::within(std::string_view key, const std::function<void(Section&)>& read,
                     const char* example) {
  if (example != nullptr) require(key, example);
  std::optional<Section> inner = section(key);
  if (!inner) return false;
  read(*inner);
  inner->finish();
  return true;
}

std::vector<Section> Section::sections(std::string_view key) {
  std::vector<Section> out;
  const toml::node* node = take(key);
  if (node == nullptr) return out;
  if (!node->is_array_of_tables()) {
    fail_at(key, "must be a list of tables; write [[" + name_within(key) + "]] in double brackets");
  }
  for (const toml::node& element : *node->as_array()) {
    out.emplace_back(*element.as_table(), "[[" + name_within(key) + "]]", file_);
  }
  return out;
}

}  // namespace haptic
