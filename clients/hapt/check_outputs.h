// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

namespace haptic {

/// Checks in advance that output files can be written: the folder is writable, no name is a folder,
/// occurs twice or is also an input, and no file exists unless `overwrite` is set. Empty names are
/// skipped. Throws std::runtime_error with one line.
void check_outputs(const std::vector<std::string>& outputs, const std::vector<std::string>& inputs,
                   bool overwrite);

}  // namespace haptic
