// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/bake/convex/growing_hull.h"

#include <algorithm>

#include "contact/query/triangle/orientation.h"

namespace haptic {
namespace {

constexpr uint32_t kNone = ~0u;

}  // namespace

GrowingHull::Face GrowingHull::make_face(const std::array<Vec3, 3>& p,
                                         const std::array<uint32_t, 3>& neighbour) {
  return {p, plane_through(p[0], p[1], p[2]), neighbour};
}

bool GrowingHull::sees(const Face& face) const {
  return orientation(face.p[0], face.p[1], face.p[2], point_) < 0;
}

void GrowingHull::begin(const std::array<Vec3, 3>& triangle, const Vec3& apex) {
  const auto& [a, b, c] = triangle;
  faces_ = {make_face({a, b, c}, {1, 2, 3}), make_face({b, a, apex}, {0, 3, 2}),
            make_face({c, b, apex}, {0, 1, 3}), make_face({a, c, apex}, {0, 2, 1})};
  question_ = 0;
  visible_.clear();
  gains_.clear();
}

const std::vector<GrowingHull::Gain>& GrowingHull::gains(const Vec3& p) {
  point_ = p;
  ++question_;
  visible_.clear();
  gains_.clear();
  planes_around_.clear();
  // the newest faces are the likeliest
  for (size_t f = faces_.size(); f-- > 0 && visible_.empty();) {
    if (!faces_[f].is_gone && sees(faces_[f])) visible_.push_back(static_cast<uint32_t>(f));
  }
  if (visible_.empty()) return gains_;
  faces_[visible_[0]].seen = question_;
  for (size_t k = 0; k < visible_.size(); ++k) {
    const Face face = faces_[visible_[k]];
    for (const uint32_t other : face.neighbour) {
      if (faces_[other].seen == question_ || !sees(faces_[other])) continue;
      faces_[other].seen = question_;
      visible_.push_back(other);
    }
  }
  for (const uint32_t f : visible_) {
    Gain gain{faces_[f].p, {}};
    for (size_t i = 0; i < 3; ++i) {
      const Face& beyond = faces_[faces_[f].neighbour[i]];
      gain.is_outer[i] = beyond.seen != question_;
      if (!gain.is_outer[i]) continue;
      planes_around_.push_back(plane_through(gain.face[i], gain.face[(i + 1) % 3], point_));
      planes_around_.push_back(beyond.plane);
    }
    gains_.push_back(gain);
  }
  return gains_;
}

void GrowingHull::add() {
  // the rim of what is seen: from each of its corners one side leads on
  struct Rim {
    Vec3 from, to;
    uint32_t beyond;  // the face that remains
  };
  std::vector<Rim> rim;
  for (const uint32_t f : visible_) {
    for (size_t i = 0; i < 3; ++i) {
      const uint32_t beyond = faces_[f].neighbour[i];
      if (faces_[beyond].seen == question_) continue;
      rim.push_back({faces_[f].p[i], faces_[f].p[(i + 1) % 3], beyond});
    }
    faces_[f].is_gone = true;
  }
  const auto first = static_cast<uint32_t>(faces_.size());
  for (uint32_t k = 0; k < rim.size(); ++k) {
    Face face = make_face({rim[k].from, rim[k].to, point_}, {rim[k].beyond, kNone, kNone});
    for (uint32_t other = 0; other < rim.size(); ++other) {
      if (rim[other].from == rim[k].to) face.neighbour[1] = first + other;
      if (rim[other].to == rim[k].from) face.neighbour[2] = first + other;
    }
    Face& beyond = faces_[rim[k].beyond];
    for (size_t i = 0; i < 3; ++i) {
      if (beyond.p[i] == rim[k].to && beyond.p[(i + 1) % 3] == rim[k].from) {
        beyond.neighbour[i] = first + k;
      }
    }
    faces_.push_back(face);
  }
  visible_.clear();
  gains_.clear();
}

}  // namespace haptic
