// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>

#include "contact/shape/mesh/primitives.h"
#include "proto/config/config.h"

namespace haptic {

/// Makes one generated mesh from its dimensions: a row of proto/config/primitives.def.
using GenerateMesh = Soup(const ShapeConfig& shape);

/// The mesh of that name [m]; empty: there is none.
Soup generate_mesh(std::string_view name, const ShapeConfig& shape);

/// All names, for a message.
std::string generated_names();

}  // namespace haptic
