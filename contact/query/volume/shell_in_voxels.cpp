// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/query/volume/shell_in_voxels.h"

#include "proto/math/mat3.h"

namespace haptic {

ShellInVoxels shell_in_voxels(const Voxmap& map, const Pose& X_OT) {
  ShellInVoxels at;
  const Mat3 R = to_matrix(X_OT.q);
  const Vec3 t = map.voxels_per_metre * (X_OT.p - map.lower_O);
  for (size_t i = 0; i < 3; ++i) {
    for (size_t j = 0; j < 3; ++j) {
      at.rotation[3 * i + j] =
          static_cast<float>(map.voxels_per_metre * R.row[i][static_cast<int>(j)]);
    }
    at.translation[i] = static_cast<float>(t[static_cast<int>(i)]);
  }
  return at;
}

}  // namespace haptic
