// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

namespace haptic {

/// Checks, before anything starts, that files may be written: each in a folder that can be written
/// to, none a folder, none twice, none that is also read, and none that exists unless `overwrite`
/// says so. Empty names are left out. Throws std::runtime_error with one line.
void check_outputs(const std::vector<std::string>& outputs, const std::vector<std::string>& inputs,
                   bool overwrite);

}  // namespace haptic
