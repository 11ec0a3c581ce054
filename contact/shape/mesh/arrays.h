// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <vector>

namespace haptic {

/// Every shape is a struct of arrays, `…Of<ArrayView>` or `…Of<ArrayData>`: a view, whose arrays
/// belong to a baked file or to a shape that owns them, or the owner, as it is made.
template <class T>
using ArrayView = std::span<const T>;
template <class T>
using ArrayData = std::vector<T>;

}  // namespace haptic
