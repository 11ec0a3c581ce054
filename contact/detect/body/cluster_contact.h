// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>

#include "contact/detect/body/body_question.h"
#include "contact/detect/body/cluster_pushes.h"
#include "proto/math/assert.h"

namespace haptic {

/// The contact for a cluster of pushes, given in the frame of its object: normal of the cluster,
/// extent 0 (unbounded) and curvature 0, which the caller knows how to find.
Contact contact_of(const PushCluster& cluster_O, uint32_t object, const Pose& X_WO,
                   const Pose& X_WT);

// objects that share what room is left: each then has four of 64 contacts, as the corners of a box
inline constexpr size_t kMostNear = 16;

/// Adds the clusters of each object to a set as contacts. `clusters_of(object, room)` writes them
/// into the room, which is shared by the objects, `most` for one; `describe(object, cluster,
/// contact)` adds what it knows how to find. Sets kContactTruncated where a room is used up.
template <class ClustersOf, class Describe>
void add_clusters(const BodyQuestion& question, size_t n_objects, size_t most, ContactSet& set,
                  const ClustersOf& clusters_of, const Describe& describe) {
  std::array<PushCluster, kMaxContacts> memory;
  for (uint32_t object = 0; object < n_objects; ++object) {
    // the rest of the room is shared by the remaining objects, of which few are near
    const size_t left = kMaxContacts - set.contacts.size();
    const size_t fair = left / std::min(n_objects - object, kMostNear);
    const size_t share = std::min(left, std::max<size_t>(fair, 1));
    const std::span<PushCluster> room = std::span(memory).first(std::min(most, share));
    const size_t n = clusters_of(object, room);
    if (n > 0 && n == room.size()) set.flags |= kContactTruncated;
    for (const PushCluster& cluster : room.first(n)) {
      Contact c = contact_of(cluster, object, question.X_WO[object], question.X_WT);
      describe(object, cluster, c);
      set.contacts.push_back(c);
      set.n_active += cluster.depth > 0;
    }
  }
}

/// Describes by the meshes of tool and object beside a cluster (contact_reach.h).
struct MeshReach {
  const BodyMeshes& meshes;
  const BodyQuestion& question;
  double search = 0;        // distance within which a cluster's place on a surface is sought [m]
  double least_extent = 0;  // [m]

  void operator()(uint32_t object, const PushCluster& cluster, Contact& contact) const;
};

}  // namespace haptic
