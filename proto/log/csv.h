// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <functional>
#include <ostream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "proto/log/trace.h"
#include "proto/os/message.h"

namespace haptic {

/// A mistake in a CSV file: one line "file:line: what; how to mend".
struct CsvError : InputError {
  using InputError::InputError;
};

/// Reads a file of numbers with a header line, row by row. Comma-separated, no quotes; blank lines
/// are skipped; lines may end in CR LF.
class CsvReader {
 public:
  /// Reads the header. Throws CsvError.
  explicit CsvReader(const std::string& path);

  const std::vector<std::string>& columns() const { return columns_; }
  /// Index of a column; npos if there is none.
  static constexpr size_t npos = static_cast<size_t>(-1);
  size_t find(std::string_view column) const;
  /// Index of a column; throws CsvError, which lists the existing columns and ends with `mend`.
  size_t require(std::string_view column,
                 std::string_view mend = "; rename or add the column") const;

  /// Reads the next row; false at the end. Throws CsvError if its number of cells differs from that
  /// of the columns.
  bool next();
  /// A cell of the current row; throws CsvError unless it is one finite number.
  double number(size_t column) const;
  /// An integer cell, exact to 64 bits.
  int64_t integer(size_t column) const;

  size_t line() const { return line_; }
  /// Throws a CsvError with this file and line.
  [[noreturn]] void fail(const std::string& what) const;

 private:
  bool read_line();
  template <typename Number>
  Number parse(size_t column, const char* kind) const;

  std::string path_;
  std::ifstream file_;
  size_t line_ = 0;
  std::string text_;
  std::vector<std::string> columns_;
  std::vector<std::string_view> cells_;  // of text_
  std::vector<char> buffer_;
};

/// Calls `use` with the number at `bytes` in its own type.
template <typename Use>
void with_number(const std::string& type, const std::byte* bytes, const Use& use) {
  const auto load = [&]<typename T>(T value) {
    std::memcpy(&value, bytes, sizeof value);
    use(value);
  };
  if (type == "float64") return load(double{});
  if (type == "int64") return load(int64_t{});
  if (type == "uint64") return load(uint64_t{});
  if (type == "uint32") return load(uint32_t{});
  throw std::logic_error("no wire struct has a " + type);
}

/// Column name of a field: its unit as a suffix, "X_WP.position.x_m", "F_device_B.torque.y_Nm",
/// "curvature_per_m"; no suffix for pure numbers or if the name ends in it.
std::string column_name(const Field& field);

/// Calls `use` with each record to be written, in the layout of this program, unaligned; it is
/// asked twice.
using CsvRecords = std::function<void(const std::function<void(const std::byte*)>& use)>;

/// Writes records of one kind as below; returns the number of rows.
size_t export_csv(const TopicInfo& topic, const CsvRecords& records, std::ostream& out,
                  const std::function<void(double share)>& told = {});

/// Writes a topic of a recording as CSV: one row per record, one column per number, with enough
/// digits to restore the same bits. Only array elements used somewhere in the file get columns;
/// cells beyond the count of a record stay empty. `told` hears how much is written. Returns the
/// number of rows.
size_t export_csv(const TraceReader& trace, const TopicInfo& topic, std::ostream& out,
                  const std::function<void(double share)>& told = {});

}  // namespace haptic
