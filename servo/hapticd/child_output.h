// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <string>
#include <string_view>

#include "proto/os/file_descriptor.h"

namespace haptic {

/// The stderr of a child, line by line, for hapticd's log.
class ChildOutput {
 public:
  using UseLine = std::function<void(const std::string&)>;

  /// Makes the pipe. Throws std::system_error.
  explicit ChildOutput(std::string_view program);

  /// The child's end: becomes its stderr. Close it in hapticd once the child runs.
  FileDescriptor& child_end() noexcept { return write_; }
  /// For poll(); −1 once the child has closed its end.
  int poll_fd() const noexcept { return read_.get(); }

  /// Passes on every complete line, without the child's own "program: " prefix. An incomplete line
  /// waits for its end or for `flush()`.
  void read(const UseLine& use);
  /// read(), then passes on the incomplete line of a child that has ended.
  void flush(const UseLine& use);

 private:
  void use_line(const UseLine& use, std::string_view line) const;

  std::string prefix_;
  std::string partial_;
  FileDescriptor read_, write_;
};

}  // namespace haptic
