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
  double k_s = 2;  // a move covers k_s/2 of the remaining way (Ortega, Redon & Coquillart 2007)
  double margin = 1e-6;  // kept from every surface [m]
  uint32_t moves = 8;    // per step, at most
  // weights of the metric in which poses are compared, about the origin of T, until the servo says
  // which springs are in force
  double translational_stiffness = 800;  // [N/m]
  double rotational_stiffness = 2;       // [N·m/rad]
};

/// A contact of the tool at its verified pose.
struct GodObjectContact {
  NearContact at;  // in O; normal_A points from the object to the tool
  uint32_t object = 0;
  bool is_kept = false;  // of an earlier pose of the step: reported only if active
};

struct GodObjectMove {
  double free_fraction = 1;  // share of the first move until it met something
  bool is_settled = true;    // false: the moves were used up before the end
  bool is_behind = false;    // the objects have moved on; no free path after them was found
  bool is_lost = false;      // and has been for longer than kMostStepsBehind: no force
  uint32_t n_active = 0;     // size of the active set
};

/// The 6-DoF god-object: a pose of the tool that is free of every object, was reached from the
/// previous pose by motions proven free along their whole length, and is as near to its target as
/// the constraints allow. Each of several moves computes
///   a_u = ½ k_s (x_target − x), a = argmin ½ (a − a_u)ᵀ M (a − a_u) s.t. J a ≥ −(gap − margin),
///   x ← x ⊕ a, as far as continuous collision detection proves it free,
/// with M = diag(k_T, k_R) about the tool's origin, the stiffness of the coupling. What a motion
/// meets becomes a constraint of the following moves; what held it back is retained as well, or it
/// would chatter. It slides within the same step, as the paper permits; a step that ends early
/// leaves at most a few margins.
///
/// Moving objects: the tool is carried along with the object that it touches, or stays where it is,
/// if that motion is free. Else it gives way by the least motion
///   a = argmin ½ aᵀ M a  s.t. J a ≥ −(gap − margin),  gaps to the objects at their new poses,
/// which translates and rotates it; what that motion meets is a constraint of the next attempt, and
/// where attempts fail the motion of the objects is halved. What remains of it when the attempts
/// are used up is left to the next step: until then the tool is `behind`, free of the objects where
/// X_WO() has them. It never changes the side of an object except by place and place_near.
///
/// Source: Ortega, Redon & Coquillart 2007; continuous collision detection as in Redon, Kheddar &
/// Coquillart 2002 (swept_mesh.h).
class GodObject6 {
 public:
  /// The arrays that the shapes view must outlive it. Allocates at construction; the fronts grow
  /// until they have held the most.
  GodObject6(std::span<const MeshShape> objects, const MeshShape& tool, const ToolBody& body,
             const GodObject6Options& options);

  /// Starts at a pose that must be free: false, with nothing changed, if a surface is nearer than
  /// half the margin or one body contains the other.
  bool place(std::span<const Pose> X_WO, const Pose& X_WT);

  /// Starts at this pose. If it is not free, tries the previous one, then translations in all
  /// directions, the shortest first; never one behind an object of which this pose is free, since
  /// the force would pull across it.
  bool place_near(std::span<const Pose> X_WO, const Pose& X_WT);

  /// Compares poses by these springs from now on [N/m], [N·m/rad]; above zero.
  void set_springs(double translational, double rotational);

  bool is_placed() const { return is_placed_; }
  void lose() { is_placed_ = false; }

  /// Moves towards a pose. Must be placed. Contacts within `reach` [m] are searched, as far as
  /// their number allows.
  GodObjectMove move(std::span<const Pose> X_WO, const Pose& led_W, double reach);

  /// The active set of the last move, then the contacts that this pose would violate most, then the
  /// nearest; in O. Distances are to the surface, margin included.
  std::span<const GodObjectContact> contacts(const Pose& answered_W);

  const Pose& X_WG() const { return X_WG_; }
  /// The object pose for which X_WG is free: the last one given, unless the tool is behind.
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
    RigidMotion way_WO;                         // motion of the object, followed in parts
    std::span<const NearPair> near;             // at X_OG, within the band
    std::array<TrianglePair, 32> kept_pairs{};  // ring buffer: met or active in this step
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
    double time = 1;               // free share of the motion
    bool are_fronts_there = true;  // the fronts are at its end
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
  double reach_;      // largest distance of a point of the tool from its origin [m]
  int band_ = 2;      // contacts within 2^band_ margins are known
  size_t work_ = 0;   // pairs visited by the fronts in this step
  double trust_ = 0;  // trust radius: longest next move [m]
  MotionMetric metric_;
  std::vector<Obstacle> obstacles_;
  bool is_placed_ = false, was_placed_ = false;
  int steps_behind_ = 0;
  Pose X_WG_;
  std::vector<GodObjectContact> rows_;
  size_t row_room_ = 0;   // most rows after this object
  double most_push_ = 0;  // largest separation that a violated row requires [m]
  std::vector<MotionRow> motion_rows_;
  std::array<int, 6> active_{};
  int n_active_ = 0;
  std::vector<std::pair<double, size_t>> order_;
  std::vector<GodObjectContact> contacts_;
};

}  // namespace haptic
