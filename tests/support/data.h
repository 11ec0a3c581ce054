// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>

namespace haptic::test {

/// A file or folder of the checkout that the test was built in, by its path from the root. Found
/// when the test runs: a path in the binary would be that of whoever filled the compiler's cache.
std::string from_source(const std::string& path);

/// A recording: in $HAPTICD_DATA, else in ../shared/data beside the source tree. Or nothing, said
/// loudly: a test that needs it then has nothing to do.
std::optional<std::string> find_data(const std::string& name);

/// A mesh of Debian's libcgal-demo: in $HAPTICD_MESHES, else in build/meshes; or nothing, as above.
std::optional<std::string> find_mesh(const std::string& name);

}  // namespace haptic::test
