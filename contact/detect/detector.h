// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <utility>

#include "contact/detect/contact_model.h"

namespace haptic {

/// What a detector keeps between steps, of any type.
class DetectorState {
 public:
  /// What was kept of this type; made from the arguments where it was another, or nothing.
  template <class State, class... Arguments>
  State& keep(const Arguments&... arguments) {
    if (type_ != &kType<State>) kept_ = std::make_shared<State>(arguments...);
    type_ = &kType<State>;
    return *static_cast<State*>(kept_.get());
  }

 private:
  template <class State>
  static constexpr char kType = 0;  // its address stands for the type

  std::shared_ptr<void> kept_;
  const char* type_ = nullptr;
};

/// A detector fills in the contacts of a set whose header is there: contacts, n_contacts, n_active
/// and the place X_WG. Where the question is not usable: no contacts, and the place that is known.
/// Renderers whose detectors keep the same type share what they keep.
using Detect = void(const ContactModel& model, DetectorState& state,
                    const ContactQuestion& question, ContactSet& set);

/// The one in the renderer's line of proto/wire/renderers.def.
Detect& detector_of(Renderer renderer);

}  // namespace haptic
