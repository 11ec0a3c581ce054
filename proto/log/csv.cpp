// SPDX-License-Identifier: Apache-2.0
#include "proto/log/csv.h"
#include "proto/os/message.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <map>
#include <type_traits>

#include "proto/os/regular_file.h"
#include "proto/os/text.h"

namespace haptic {
namespace {

// [bytes]; the widest export has some 700 columns of at most 30 characters
constexpr size_t kLongestLine = size_t{64} << 10;

/// An array at the top level of a message, and how many of its elements need a column.
struct Array {
  size_t begin = 0, element = 0;  // [bytes]
  size_t length = 0;
  const Field* count = nullptr;  // elements in use per record; null: unknown
  size_t used = 0;               // largest number in use in any record

  size_t used_in(const std::byte* record) const {
    size_t n = 0;
    if (count != nullptr) {
      with_number(count->type, record + count->offset,
                  [&](auto value) { n = static_cast<size_t>(value); });
      return std::min(n, length);
    }
    for (size_t i = 0; i < length * element; ++i) {
      if (record[begin + i] != std::byte{0}) n = i / element + 1;
    }
    return n;
  }
};

struct Column {
  const Field* field = nullptr;
  const Array* array = nullptr;  // null: a plain field
  size_t index = 0;              // in the array
};

std::string_view array_name(const Field& field) {
  const size_t bracket = field.name.find('[');
  return std::string_view(field.name).substr(0, bracket == std::string::npos ? 0 : bracket);
}

std::map<std::string_view, Array> find_arrays(const std::vector<Field>& fields, size_t size) {
  std::map<std::string_view, Array> arrays;
  for (size_t i = 0; i < fields.size(); ++i) {
    const std::string_view name = array_name(fields[i]);
    if (name.empty()) continue;
    const auto [at, is_new] = arrays.try_emplace(name);
    Array& array = at->second;
    if (is_new) array.begin = fields[i].offset;
    const size_t end = i + 1 < fields.size() ? fields[i + 1].offset : size;
    const std::string_view rest = std::string_view(fields[i].name).substr(name.size() + 1);
    size_t index = 0;
    std::from_chars(rest.data(), rest.data() + rest.size(), index);
    array.length = index + 1;
    array.element = (end - array.begin) / array.length;
  }
  for (auto& [name, array] : arrays) {
    for (const Field& field : fields) {
      if (field.name == "n_" + std::string(name)) array.count = &field;
    }
  }
  return arrays;
}

/// One column per number, without array elements that no record uses.
std::vector<Column> choose_columns(const std::vector<Field>& fields,
                                   const std::map<std::string_view, Array>& arrays) {
  std::vector<Column> columns;
  for (const Field& field : fields) {
    Column column{&field, nullptr, 0};
    if (const auto at = arrays.find(array_name(field)); at != arrays.end()) {
      column.array = &at->second;
      column.index = (field.offset - at->second.begin) / at->second.element;
      if (column.index >= at->second.used) continue;
    }
    columns.push_back(column);
  }
  return columns;
}

void append_cell(std::string& row, const Field& field, const std::byte* record) {
  char text[32];
  with_number(field.type, record + field.offset, [&](auto value) {
    row.append(text, std::to_chars(text, text + sizeof text, value).ptr);
  });
}

std::string_view trimmed(std::string_view text) {
  const size_t begin = std::min(text.find_first_not_of(" \t"), text.size());
  return text.substr(begin, text.find_last_not_of(" \t") + 1 - begin);
}

std::vector<std::string_view> split(std::string_view line) {
  std::vector<std::string_view> cells;
  for (size_t begin = 0;;) {
    const size_t comma = line.find(',', begin);
    cells.push_back(trimmed(line.substr(begin, comma - begin)));
    if (comma == std::string_view::npos) return cells;
    begin = comma + 1;
  }
}

}  // namespace

CsvReader::CsvReader(const std::string& path) : path_(path) {
  const std::string problem = open_stream(path, file_);
  if (!problem.empty()) throw CsvError(path + ": " + problem + "; name a CSV file");
  if (!read_line()) fail("is empty; the first line must name the columns");
  for (const std::string_view cell : split(text_)) columns_.emplace_back(cell);
}

void CsvReader::fail(const std::string& what) const {
  throw CsvError(path_ + ":" + std::to_string(line_) + ": " + what);
}

/// Reads the next line that is not blank.
bool CsvReader::read_line() {
  buffer_.resize(kLongestLine + 1);
  while (file_.getline(buffer_.data(), static_cast<std::streamsize>(buffer_.size()))) {
    ++line_;
    // what getline() took, without the end of line
    text_.assign(buffer_.data(), static_cast<size_t>(file_.gcount()) - (file_.eof() ? 0 : 1));
    if (!text_.empty() && text_.back() == '\r') text_.pop_back();
    if (!trimmed(text_).empty()) return true;
  }
  if (!file_.eof()) {
    ++line_;
    fail("is longer than " + std::to_string(kLongestLine) + " characters; it is no table");
  }
  return false;
}

size_t CsvReader::find(std::string_view column) const {
  const auto at = std::find(columns_.begin(), columns_.end(), column);
  return at == columns_.end() ? npos : static_cast<size_t>(at - columns_.begin());
}

size_t CsvReader::require(std::string_view column, std::string_view mend) const {
  const size_t index = find(column);
  if (index != npos) return index;
  constexpr size_t kNamed = 12;  // columns listed; enough to recognise the file
  std::string there;
  if (columns_.size() == 1 && columns_.front().find(';') != std::string::npos) {
    throw CsvError(path_ +
                   ":1: its columns are separated by semicolons; save it with commas, and " +
                   "with points in the numbers");
  }
  for (size_t i = 0; i < std::min(columns_.size(), kNamed); ++i) {
    there += (i > 0 ? ", " : "") + printable(columns_[i], 40);
  }
  if (columns_.size() > kNamed) there += ", …";
  throw CsvError(path_ + ":1: has no column '" + shown(column) + "'; it has " + there +
                 std::string(mend));
}

bool CsvReader::next() {
  if (!read_line()) return false;
  cells_ = split(text_);
  if (cells_.size() != columns_.size()) {
    fail("has " + std::to_string(cells_.size()) + " cells where the header has " +
         std::to_string(columns_.size()) + "; the line was cut or has a comma too many");
  }
  return true;
}

template <typename Number>
Number CsvReader::parse(size_t column, const char* kind) const {
  const std::string_view cell = cells_.at(column);
  const std::optional<Number> value = number_from<Number>(cell);
  bool good = value.has_value();
  if constexpr (std::is_floating_point_v<Number>) good = good && std::isfinite(*value);
  if (!good) {
    fail("'" + shown(columns_[column]) + "' is '" + shown(cell) + "', not " + kind +
         "; mend or remove the line");
  }
  return *value;
}

double CsvReader::number(size_t column) const {
  return parse<double>(column, "a finite number");
}
int64_t CsvReader::integer(size_t column) const {
  return parse<int64_t>(column, "a whole number");
}

std::string column_name(const Field& field) {
  const std::string suffix =
      "_" + replaced(field.unit, {{"·", ""}, {"1/", "per_"}, {"/", "_per_"}});
  const bool has_it = suffix.size() == 1 || field.name.ends_with(suffix);
  return has_it ? field.name : field.name + suffix;
}

size_t export_csv(const TraceReader& trace, const TopicInfo& topic, std::ostream& out,
                  const std::function<void(double share)>& told) {
  const CsvRecords records = [&](const std::function<void(const std::byte*)>& use) {
    TopicCursor cursor(trace, topic);
    while (cursor.next()) use(cursor.bytes());
  };
  return export_csv(topic, records, out, told);
}

size_t export_csv(const TopicInfo& topic, const CsvRecords& records, std::ostream& out,
                  const std::function<void(double share)>& told) {
  const Fields fields = flatten(topic.text);
  std::map<std::string_view, Array> arrays = find_arrays(fields, topic.size);
  size_t all = 0;
  records([&](const std::byte* record) {
    ++all;
    for (auto& [name, array] : arrays) array.used = std::max(array.used, array.used_in(record));
  });

  const std::vector<Column> columns = choose_columns(fields, arrays);
  std::string row;
  for (const Column& c : columns) row += (row.empty() ? "" : ",") + column_name(*c.field);
  out << row << '\n';

  size_t rows = 0;
  records([&](const std::byte* record) {
    row.clear();
    const Array* array = nullptr;
    size_t used = 0;
    for (const Column& c : columns) {
      if (&c != columns.data()) row += ',';
      // counted once per array, not per cell
      if (c.array != nullptr && c.array != array) {
        array = c.array;
        used = array->count != nullptr ? array->used_in(record) : array->used;
      }
      if (c.array == nullptr || c.index < used) append_cell(row, *c.field, record);
    }
    row += '\n';
    out << row;
    ++rows;
    if (told) told(static_cast<double>(rows) / static_cast<double>(all));
  });
  return rows;
}

}  // namespace haptic
