// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <vector>

#include "contact/detect/contact_model.h"

/// The detectors of tools with six degrees of freedom that may enter objects. The proxy is the
/// servo's: the contacts are those of the tool where it has that. kContactNoDetector says that the
/// session has no tool, or nothing that this detector asks.
namespace haptic {

/// Of direct6: all triangles that meet, clustered.
class ExactDetector {
 public:
  explicit ExactDetector(const ContactModel& model);
  void detect(const ContactModel& model, const ContactQuestion& question, ContactSet& set);

 private:
  std::vector<TrianglePair> pairs_;
  std::vector<PointPush> pushes_;
  std::vector<ClusterMemory> clusters_;  // of each object
};

/// Of voxel. It also reports the clearance beyond its contacts, for the tool where it is or as far
/// as a free path leads towards the hand (clear_pose.h).
class VoxelDetector {
 public:
  explicit VoxelDetector(const ContactModel& model);
  void detect(const ContactModel& model, const ContactQuestion& question, ContactSet& set);

 private:
  std::optional<VoxelState> voxel_;  // none: the session has no maps
  ClearanceState clearance_;
};

/// By convex pieces.
class PieceDetector {
 public:
  explicit PieceDetector(const ContactModel& model) : state_(model.pieces) {}

 protected:
  void detect_by(const RefineOptions& refine, const ContactModel& model,
                 const ContactQuestion& question, ContactSet& set);

 private:
  PieceState state_;
};

/// Convex pieces at full detail (Kim, Otaduy, Lin, Manocha 2003).
struct LocalizedDetector : PieceDetector {
  using PieceDetector::PieceDetector;
  void detect(const ContactModel& model, const ContactQuestion& question, ContactSet& set);
};

/// Contact levels of detail (Otaduy & Lin 2003).
struct SensationDetector : PieceDetector {
  using PieceDetector::PieceDetector;
  void detect(const ContactModel& model, const ContactQuestion& question, ContactSet& set);
};

}  // namespace haptic
