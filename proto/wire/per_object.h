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

/// A value for each object of a scene and each such surface. It allocates nothing, never throws,
/// and costs what the scene has.
template <typename T>
using PerObject = boost::container::static_vector<
    T, kMostPlaced,
    boost::container::static_vector_options_t<boost::container::throw_on_overflow<false>>>;

}  // namespace haptic
