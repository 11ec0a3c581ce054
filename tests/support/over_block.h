// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>

#include "contact/bake/session.h"
#include "contact/step.h"
#include "proto/config/config.h"

namespace haptic::test {

inline constexpr primitive::Box kCube{{0.02, 0.02, 0.02}};

/// A tool of 50 g over a block of 10 cm whose top is at z = 0.
inline SessionConfig over_block(Renderer renderer, const Primitive& tool) {
  SessionConfig config{};
  config.renderer = renderer;
  config.n_objects = 1;
  config.objects[0].primitive = primitive::Box{{0.1, 0.1, 0.1}};
  config.objects[0].X_WO.p = {0, 0, -0.05};
  config.tool.primitive = tool;
  config.tool.mass = 0.05;
  return config;
}

/// A session's contact, baked and at its beginning.
struct BakedContact {
  SessionConfig config;
  BakedSession baked;
  ContactModel model;
  std::unique_ptr<ContactState> state;

  explicit BakedContact(const SessionConfig& session)
      : config(session),
        baked(bake_session(config)),
        model(build_contact_model(config, baked.shapes())),
        state(std::make_unique<ContactState>(model)) {}
};

}  // namespace haptic::test
