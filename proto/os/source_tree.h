// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

/// Searched at run time: a compiled-in path would be right for one clone or prefix only.
namespace haptic {

/// The checkout this program was built in: the nearest folder above the program with configs/ and
/// CMakeLists.txt, or $HAPTICD_SOURCE if it was built elsewhere. Empty for an installed program.
std::filesystem::path source_tree();

/// Folder of the "configs" or "meshes" that belong to this program: those of the source tree, or of
/// an installed program those in the nearest share/hapticd above it. Empty: there is neither.
std::filesystem::path shared_folder(const std::string& what);

/// Says that a program of ours cannot be started, why (an errno), and what builds or installs it.
std::string cannot_start(const std::string& path, int error);

/// Where meshes are kept that an installed program has fetched for this user:
/// $XDG_DATA_HOME/hapticd/meshes, else ~/.local/share/hapticd/meshes; without a home empty.
std::filesystem::path fetched_meshes();

}  // namespace haptic
