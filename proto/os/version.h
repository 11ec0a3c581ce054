// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace haptic {

/// Release and commit of this build: "0.1.0 (a1b2c3d)"; "-dirty" if files were changed since.
const char* version();

}  // namespace haptic
