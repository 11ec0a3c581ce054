// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <array>
#include <span>
#include <vector>

#include "contact/query/proximity/near_contacts.h"
#include "contact/query/proximity/near_front.h"
#include "contact/query/sweep/swept_mesh.h"
#include "contact/shape/mesh/mesh_topology.h"
#include "proto/math/qp.h"
#include "proto/wire/wire.h"

namespace haptic {

struct GodObject6Options {
  double k_s = 2;        // a move goes k_s/2 of what is left of the way (algorithms.md 0.2)
  double margin = 1e-6;  // kept to every surface [m]
  uint32_t moves = 8;    // in one step, at most
  // what the distance between two poses is measured in, about the origin of T
  double translational_stiffness = 800;  // [N/m]
  double rotational_stiffness = 2;       // [N·m/rad]
};

/// A contact of the tool at its verified pose.
struct GodObjectContact {
  NearContact at;  // in O; the way to the tool is its normal
  uint32_t object = 0;
  bool is_kept = false;  // of an earlier pose of the step: holds in its moves alone
};

struct GodObjectMove {
  double free_fraction = 1;  // of the first move, until it met something
  bool is_settled = true;    // false: the moves were used up on the way
  bool is_behind = false;    // objects have gone on to where no proven way has led it yet
  bool is_lost = false;      // and that for so long that it must not be felt
  uint32_t n_active = 0;     // contacts that hold it back
};

/// The god-object of six degrees of freedom: a pose of the tool that is free of every object, was
/// reached from the pose before by motions that are proven free along their whole way, and is as
/// near to where it is led as constraints allow. In each of some moves
///   a_u = ½ k_s (x_led − x), a = argmin ½ (a − a_u)ᵀ M (a − a_u) s.t. J a ≥ −(gap − margin),
///   x ← x ⊕ a, as far as continuous collision proves it free,
/// M = diag(k_T, k_R) about the tool's origin, the springs of the config. Where a motion
/// meets something, that is a constraint in the moves that follow, and so is what held it back, so
/// that it does not rock to and fro. Slides in the same step, as the paper says it may; what is
/// left of a step that ends is at most some margins.
///
/// Objects that move: the tool goes along with the one that it touches, or stays where it is, if
/// that is free all along. Else it gives way by as little as it must,
///   a = argmin ½ aᵀ M a  s.t. J a ≥ −(gap − margin),  gaps of the tool as it is to the objects
///   where
/// they are now, which carries and turns it; what that motion meets is a constraint of the next
/// try, and where tries do not help the objects go only half as far at first. Parts that are not
/// gone when the tries of a step are used up are left to the next one: until then the tool is
/// `behind`, free of the objects where X_WO() has them. It never leaves the side of an object on
/// which it is, but through place and place_near.
///
/// Source: Ortega, Redon & Coquillart 2007; continuous collision as in Redon, Kheddar & Coquillart
/// 2002 (swept_mesh.h).
class GodObject6 {
 public:
  /// Views: the shapes must outlive this. Allocates when it is made; what the fronts remember
  /// grows until it has held the most.
  GodObject6(std::span<const MeshShape> objects, const MeshShape& tool, const ToolBody& body,
             const GodObject6Options& options);

  /// Begins at a pose that must be free: false where a surface is nearer than half the margin, or
  /// one body holds the other; then nothing changes.
  bool place(std::span<const Pose> X_WO, const Pose& X_WT);

  /// The same at this pose or, where it is not free, at another: where it was before, then away
  /// from the pose in all directions, the shortest way first; never where an object that is not
  /// met at this pose lies between, since the force would pull across it.
  bool place_near(std::span<const Pose> X_WO, const Pose& X_WT);

  bool is_placed() const { return is_placed_; }
  void lose() { is_placed_ = false; }

  /// Towards a pose. Must be placed. What is nearer than `reach` [m] is looked for, if it is not
  /// too much.
  GodObjectMove move(std::span<const Pose> X_WO, const Pose& led_W, double reach);

  /// Those that hold it back at the end of the last move, then those that this pose would break the
  /// most, then the nearest; in O. The distance is to the surface, margin included.
  std::span<const GodObjectContact> contacts(const Pose& answered_W);

  const Pose& X_WG() const { return X_WG_; }
  /// Where X_WG is free of this object: where it was last said to be, unless the tool is behind.
  const Pose& X_WO(size_t object) const { return obstacles_[object].X_WO; }

 private:
  struct Obstacle {
    Obstacle(const MeshShape& object, const MeshShape& tool)
        : shape(object),
          shell_points(points_of_shells(object.mesh)),
          front(object, tool),
          sweep(object, tool),
          minima(object, tool) {}
    MeshShape shape;
    std::vector<Vec3> shell_points;
    NearFront front;
    SweptMesh sweep;
    NearContacts minima;
    Pose X_WO, X_OG;
    Pose stood_WO;                              // X_WO when the tool came to X_OG
    RigidMotion way_WO;                         // that is gone in parts
    std::span<const NearPair> near;             // at X_OG, within the band
    std::array<TrianglePair, 32> kept_pairs{};  // the last that were met or held it, in this step
    size_t n_kept = 0;

    std::span<const TrianglePair> kept() const {
      return {kept_pairs.data(), std::min(n_kept, kept_pairs.size())};
    }
    void keep(const TrianglePair& pair) {
      const auto known = kept();
      if (std::find(known.begin(), known.end(), pair) != known.end()) return;
      kept_pairs[n_kept++ % kept_pairs.size()] = pair;
    }
  };

  bool is_free(std::span<const Pose> X_WO, const Pose& X_WT) const;
  bool is_free_of(const Obstacle& o, const Pose& X_OT) const;
  bool is_across(std::span<const Pose> X_WO, const Pose& from_W, const Pose& to_W);
  bool follow_objects(std::span<const Pose> X_WO);
  bool goes_rigidly();
  bool goes_with_any();
  bool gives_way();
  bool gives_way_in_parts(std::span<const Pose> X_WO);
  bool goes(const Pose& X_WT);
  Pose carried_by(size_t object) const;
  struct FreePart {
    double time = 1;               // of the way
    bool are_fronts_there = true;  // at its end
  };
  FreePart free_part(const Pose& to_W);
  void stand_at(const Pose& X_WT);
  int level_of(double length) const;
  void look_around();
  size_t n_near() const;
  double share_of(const Twist& motion) const;
  void gather_rows(double most_push);
  void add_pair(const TrianglePair& triangles, const TriangleDistance& at, uint32_t object,
                bool is_kept);
  void add_too_near(const Obstacle& obstacle, uint32_t object);
  void add_kept(const Obstacle& obstacle, uint32_t object);
  void add_row(const NearContact& contact, uint32_t object, bool is_kept = false);
  ConstrainedMotion constrained_way(const Twist& way);
  double advance(const Twist& motion);
  double length_of(const Twist& motion) const;
  double length_of(const RigidMotion& motion) const;
  double distance_of(const Twist& motion) const;
  double band() const { return options_.margin * static_cast<double>(1u << band_); }

  GodObject6Options options_;
  MeshShape tool_;
  std::vector<Vec3> shell_points_T_;
  double reach_;      // from the origin of T to its furthest point [m]
  int band_ = 2;      // all that is nearer than 2^band_ margins is known
  size_t work_ = 0;   // pairs that the fronts have looked at in this step
  double trust_ = 0;  // how long the next move may be [m]
  MotionMetric metric_;
  std::vector<Obstacle> obstacles_;
  bool is_placed_ = false, was_placed_ = false;
  int steps_behind_ = 0;
  Pose X_WG_;
  std::vector<GodObjectContact> rows_;
  size_t row_room_ = 0;   // for the rows of one object
  double most_push_ = 0;  // by which a row asks for more room [m]
  std::vector<MotionRow> motion_rows_;
  std::array<int, 6> active_{};
  int n_active_ = 0;
  std::vector<std::pair<double, size_t>> order_;
  std::vector<GodObjectContact> contacts_;
};

}  // namespace haptic
