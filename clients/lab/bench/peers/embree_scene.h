// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#ifdef HAPTICD_EMBREE
#include <embree3/rtcore.h>

#include <algorithm>

#include "contact/shape/mesh/triangle_mesh.h"

namespace haptic {

/// A mesh in Embree, robust and of high quality.
class EmbreeScene {
 public:
  explicit EmbreeScene(const TriangleMesh& mesh) {
    rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_ROBUST);
    rtcSetSceneBuildQuality(scene_, RTC_BUILD_QUALITY_HIGH);
    RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* points = static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0,
                                                               RTC_FORMAT_FLOAT3, 3 * sizeof(float),
                                                               mesh.vertices.size()));
    for (const Vec3& v : mesh.vertices) {
      for (const double x : {v.x, v.y, v.z}) *points++ = static_cast<float>(x);
    }
    auto* corners = static_cast<unsigned*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                3 * sizeof(unsigned), mesh.triangles.size()));
    for (const Triangle& t : mesh.triangles) corners = std::copy(t.begin(), t.end(), corners);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene_, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene_);
  }
  ~EmbreeScene() {
    rtcReleaseScene(scene_);
    rtcReleaseDevice(device_);
  }
  EmbreeScene(const EmbreeScene&) = delete;
  EmbreeScene& operator=(const EmbreeScene&) = delete;

  RTCScene get() const { return scene_; }

 private:
  RTCDevice device_ = rtcNewDevice("threads=1");
  RTCScene scene_ = rtcNewScene(device_);
};

}  // namespace haptic
#endif
