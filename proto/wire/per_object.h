// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <boost/container/options.hpp>
#include <boost/container/static_vector.hpp>

#include "proto/wire/wire.h"

namespace haptic {

/// A value for each object of a scene. It allocates nothing, never throws, and costs what the scene
/// has.
template <typename T>
using PerObject = boost::container::static_vector<
    T, kMaxObjects,
    boost::container::static_vector_options_t<boost::container::throw_on_overflow<false>>>;

}  // namespace haptic
