// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

namespace haptic {

/// The checkout this program was built in: the nearest folder above the program with configs/ and
/// CMakeLists.txt, or $HAPTICD_SOURCE if it was built elsewhere. Empty for an installed program.
/// Searched at run time: a compiled-in path would be right for one clone only.
std::filesystem::path source_tree();

}  // namespace haptic
