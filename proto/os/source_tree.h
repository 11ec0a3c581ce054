// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

namespace haptic {

/// The checkout that this program was built in: the nearest folder above the program that holds
/// configs/ and CMakeLists.txt, or $HAPTICD_SOURCE where it was built elsewhere. Empty for one that
/// is installed. Looked for at run time: a path compiled in would hold for one clone alone.
std::filesystem::path source_tree();

}  // namespace haptic
