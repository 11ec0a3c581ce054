// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <boost/container/options.hpp>
#include <boost/container/static_vector.hpp>

#include "proto/wire/wire.h"

namespace haptic {

/// Surfaces of clients in a ContactSet, each the planes of one client on one object: a servo places
/// them behind the objects.
inline constexpr uint32_t kMostSurfaces = 16;
inline constexpr uint32_t kMostPlaced = kMaxObjects + kMostSurfaces;

/// A list of at most kMost values, which allocates nothing, never throws, and costs what it holds.
template <typename T, size_t kMost>
using UpTo = boost::container::static_vector<
    T, kMost,
    boost::container::static_vector_options_t<boost::container::throw_on_overflow<false>>>;

/// A value for each object of a scene and each such surface.
template <typename T>
using PerObject = UpTo<T, kMostPlaced>;

}  // namespace haptic
