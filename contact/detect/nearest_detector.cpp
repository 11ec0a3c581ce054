// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/detect/nearest_detector.h"

#include "contact/detect/point/nearest_surface.h"
#include "proto/math/assert.h"

namespace haptic {
namespace {

Vec3 report(const PointScene& scene, const Vec3& tool_W, double reach, ContactSet& set) {
  PerObject<NearestSurface> surfaces(scene.shapes.size());
  const size_t count = nearest_surfaces(scene, tool_W, reach, {surfaces.data(), surfaces.size()});
  // the deepest come first
  if (count > kMaxContacts) set.flags |= kContactTruncated;
  for (size_t i = 0; i < std::min<size_t>(count, kMaxContacts); ++i) {
    const auto& [facet, at, depth] = surfaces[i];
    set.contacts.push_back(contact_at(scene, facet, at, 1));
    set.n_active += depth > 0;
  }
  if (set.n_active == 0) return tool_W;
  const NearestSurface& deepest = surfaces[0];
  return scene.X_WO[deepest.facet.object] *
         (deepest.at.point_O + scene.epsilon * deepest.at.normal_O);
}

}  // namespace

void NearestDetector::detect(const ContactModel&, const ContactQuestion& question,
                             ContactSet& set) {
  const Pose& X_WT = question.servo.X_WT;
  if (question.usable && question.changed) set.flags |= kContactReseeded;
  if (question.usable) free_W_ = report(question.now, X_WT.p, question.reach, set);
  set.X_WG = {free_W_, X_WT.q};
}

}  // namespace haptic
