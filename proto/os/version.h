// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace haptic {

/// Release and commit of this build, as "0.1.0 (a1b2c3d)"; "-dirty" where files were changed since.
const char* version();

}  // namespace haptic
