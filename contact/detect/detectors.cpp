// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/detect/detector.h"
#include "proto/math/assert.h"
#include "proto/wire/renderer.h"

namespace haptic {
namespace {

template <class Detector>
void detect_by(const ContactModel& model, AnyDetector& kept, const ContactQuestion& question,
               ContactSet& set) {
  auto* detector = std::get_if<Detector>(&kept);
  if (detector == nullptr) detector = &kept.emplace<Detector>(model);
  detector->detect(model, question, set);
}

}  // namespace

void detect(const ContactModel& model, AnyDetector& kept, const ContactQuestion& question,
            ContactSet& set) {
  switch (question.renderer) {
#define RENDERER(id, name, detector, ...) \
  case Renderer::id:                      \
    return detect_by<detector>(model, kept, question, set);
#include "proto/wire/renderers.def"
  }
  HAPTIC_ASSERT(false);
}

}  // namespace haptic
