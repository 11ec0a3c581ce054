// SPDX-License-Identifier: Apache-2.0
#include "clients/library/ros_messages.h"

#include <cstring>

namespace haptic::ros {
namespace {

constexpr size_t kHeader = 4;  // of CDR; alignment counts from behind it

/// Appends numbers and texts, each number at a multiple of its own size.
class Cdr {
 public:
  Cdr() : bytes_{std::byte{0}, std::byte{1}, std::byte{0}, std::byte{0}} {}

  template <typename T>
  Cdr& number(T value) {
    while ((bytes_.size() - kHeader) % sizeof(T) != 0) bytes_.push_back(std::byte{0});
    const auto* at = reinterpret_cast<const std::byte*>(&value);
    bytes_.insert(bytes_.end(), at, at + sizeof(T));
    return *this;
  }
  Cdr& count(size_t n) { return number(static_cast<uint32_t>(n)); }
  Cdr& text(std::string_view text) {
    count(text.size() + 1);
    const auto* at = reinterpret_cast<const std::byte*>(text.data());
    bytes_.insert(bytes_.end(), at, at + text.size());
    bytes_.push_back(std::byte{0});
    return *this;
  }
  Cdr& vector(const Vec3& v) { return number(v.x).number(v.y).number(v.z); }
  Cdr& pose(const Pose& X) {
    return vector(X.p).number(X.q.x).number(X.q.y).number(X.q.z).number(X.q.w);
  }
  Cdr& header(int64_t realtime_ns, std::string_view frame) {
    constexpr int64_t kSecond = 1'000'000'000;
    number(static_cast<int32_t>(realtime_ns / kSecond));
    number(static_cast<uint32_t>(realtime_ns % kSecond));
    return text(frame);
  }
  Message take() { return std::move(bytes_); }

 private:
  Message bytes_;
};

#define HAPTIC_ROS_PART \
  "================================================================================\n"
#define HAPTIC_ROS_HEADER                                            \
  HAPTIC_ROS_PART                                                    \
  "MSG: std_msgs/Header\n"                                           \
  "builtin_interfaces/Time stamp\nstring frame_id\n" HAPTIC_ROS_PART \
  "MSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n"
#define HAPTIC_ROS_VECTOR \
  HAPTIC_ROS_PART         \
  "MSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n"
#define HAPTIC_ROS_POINT \
  HAPTIC_ROS_PART        \
  "MSG: geometry_msgs/Point\nfloat64 x\nfloat64 y\nfloat64 z\n"
#define HAPTIC_ROS_QUATERNION \
  HAPTIC_ROS_PART             \
  "MSG: geometry_msgs/Quaternion\nfloat64 x\nfloat64 y\nfloat64 z\nfloat64 w\n"
#define HAPTIC_ROS_POSE                                                              \
  HAPTIC_ROS_PART                                                                    \
  "MSG: geometry_msgs/Pose\ngeometry_msgs/Point position\ngeometry_msgs/Quaternion " \
  "orientation\n" HAPTIC_ROS_POINT HAPTIC_ROS_QUATERNION

}  // namespace

const Type kPoseStamped{
    "geometry_msgs/msg/PoseStamped",
    "std_msgs/Header header\ngeometry_msgs/Pose pose\n" HAPTIC_ROS_HEADER HAPTIC_ROS_POSE};

const Type kWrenchStamped{
    "geometry_msgs/msg/WrenchStamped",
    "std_msgs/Header header\ngeometry_msgs/Wrench wrench\n" HAPTIC_ROS_HEADER HAPTIC_ROS_PART
    "MSG: geometry_msgs/Wrench\ngeometry_msgs/Vector3 force\n"
    "geometry_msgs/Vector3 torque\n" HAPTIC_ROS_VECTOR};

const Type kTfMessage{
    "tf2_msgs/msg/TFMessage",
    "geometry_msgs/TransformStamped[] transforms\n" HAPTIC_ROS_PART
    "MSG: geometry_msgs/TransformStamped\nstd_msgs/Header header\nstring child_frame_id\n"
    "geometry_msgs/Transform transform\n" HAPTIC_ROS_HEADER HAPTIC_ROS_PART
    "MSG: geometry_msgs/Transform\ngeometry_msgs/Vector3 translation\n"
    "geometry_msgs/Quaternion rotation\n" HAPTIC_ROS_VECTOR HAPTIC_ROS_QUATERNION};

const Type kMarker{
    "visualization_msgs/msg/Marker",
    "int32 ARROW=0\nint32 TRIANGLE_LIST=11\nint32 ADD=0\n"
    "std_msgs/Header header\nstring ns\nint32 id\nint32 type\nint32 action\n"
    "geometry_msgs/Pose pose\ngeometry_msgs/Vector3 scale\nstd_msgs/ColorRGBA color\n"
    "builtin_interfaces/Duration lifetime\nbool frame_locked\ngeometry_msgs/Point[] points\n"
    "std_msgs/ColorRGBA[] colors\nstring texture_resource\n"
    "sensor_msgs/CompressedImage texture\nvisualization_msgs/UVCoordinate[] uv_coordinates\n"
    "string text\nstring mesh_resource\nvisualization_msgs/MeshFile mesh_file\n"
    "bool mesh_use_embedded_materials\n" HAPTIC_ROS_HEADER HAPTIC_ROS_POSE HAPTIC_ROS_VECTOR
        HAPTIC_ROS_PART
    "MSG: std_msgs/ColorRGBA\nfloat32 r\nfloat32 g\nfloat32 b\nfloat32 a\n" HAPTIC_ROS_PART
    "MSG: builtin_interfaces/Duration\nint32 sec\nuint32 nanosec\n" HAPTIC_ROS_PART
    "MSG: sensor_msgs/CompressedImage\nstd_msgs/Header header\nstring format\n"
    "uint8[] data\n" HAPTIC_ROS_PART
    "MSG: visualization_msgs/UVCoordinate\nfloat32 u\nfloat32 v\n" HAPTIC_ROS_PART
    "MSG: visualization_msgs/MeshFile\nstring filename\nuint8[] data\n"};

Message pose_stamped(int64_t realtime_ns, std::string_view frame, const Pose& pose) {
  return Cdr().header(realtime_ns, frame).pose(pose).take();
}

Message wrench_stamped(int64_t realtime_ns, std::string_view frame, const Wrench& wrench) {
  return Cdr().header(realtime_ns, frame).vector(wrench.f).vector(wrench.t).take();
}

Message tf_message(int64_t realtime_ns, std::span<const Transform> transforms) {
  Cdr out;
  out.count(transforms.size());
  for (const Transform& one : transforms) {
    out.header(realtime_ns, one.parent).text(one.child).pose(one.X);
  }
  return out.take();
}

Message triangle_list(int64_t realtime_ns, const MeshMarker& marker) {
  constexpr int32_t kTriangleList = 11, kAdd = 0;
  Cdr out;
  out.header(realtime_ns, marker.frame).text(marker.name).number(marker.number);
  out.number(kTriangleList).number(kAdd).pose(Pose{}).vector({1, 1, 1});
  for (const float channel : marker.colour) out.number(channel);
  // it stays until it is replaced, and follows its frame
  out.number(int32_t{0}).number(uint32_t{0}).number(uint8_t{1});
  out.count(3 * marker.triangles.size());
  for (const auto& triangle : marker.triangles) {
    for (const uint32_t corner : triangle) out.vector(marker.vertices[corner]);
  }
  out.count(0).text("");                     // colours of the points, texture_resource
  out.header(0, "").text("").count(0);       // texture
  out.count(0).text("").text("");            // uv_coordinates, text, mesh_resource
  out.text("").count(0).number(uint8_t{0});  // mesh_file, mesh_use_embedded_materials
  return out.take();
}

}  // namespace haptic::ros
