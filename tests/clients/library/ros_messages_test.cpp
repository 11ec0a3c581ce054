// SPDX-License-Identifier: GPL-3.0-or-later
// Messages of ROS against a reader of CDR written for this test, from the rules of the encoding.
#include "clients/library/ros_messages.h"
#include "clients/log/trace_writer.h"

#include <catch2/catch.hpp>
#include <cstring>

#include "clients/library/standard_messages.h"
#include "tests/support/temporary_folder.h"

namespace haptic {
namespace {

/// Every number lies at a multiple of its size, counted from behind the four bytes of the header.
class CdrReader {
 public:
  explicit CdrReader(std::span<const std::byte> message) : message_(message) {
    REQUIRE(message.size() > 4);
    REQUIRE(message[1] == std::byte{1});  // little endian
  }
  template <typename T>
  T number() {
    at_ = (at_ + sizeof(T) - 1) / sizeof(T) * sizeof(T);
    REQUIRE(4 + at_ + sizeof(T) <= message_.size());
    T value;
    std::memcpy(&value, message_.data() + 4 + at_, sizeof(T));
    at_ += sizeof(T);
    return value;
  }
  std::string text() {
    const auto n = number<uint32_t>();
    REQUIRE(n > 0);
    REQUIRE(4 + at_ + n <= message_.size());
    std::string out(reinterpret_cast<const char*>(message_.data()) + 4 + at_, n - 1);
    REQUIRE(message_[4 + at_ + n - 1] == std::byte{0});
    at_ += n;
    return out;
  }
  std::vector<double> numbers(int n) {
    std::vector<double> out;
    for (int i = 0; i < n; ++i) out.push_back(number<double>());
    return out;
  }
  void header(int32_t sec, uint32_t nsec, const std::string& frame) {
    CHECK(number<int32_t>() == sec);
    CHECK(number<uint32_t>() == nsec);
    CHECK(text() == frame);
  }
  bool at_end() const { return 4 + at_ == message_.size(); }

 private:
  std::span<const std::byte> message_;
  size_t at_ = 0;
};

constexpr int64_t kTime = 1'700'000'000'123'456'789;
constexpr int32_t kSec = 1'700'000'000;
constexpr uint32_t kNanosec = 123'456'789;

using Numbers = std::vector<double>;

}  // namespace

TEST_CASE("ros messages: pose, wrench and transforms as a reader of CDR finds them") {
  const Pose pose{{1, 2, 3}, {0, 0, 0.6, 0.8}};
  const ros::Message posed = ros::pose_stamped(kTime, "world", pose);
  CdrReader in(posed);
  in.header(kSec, kNanosec, "world");
  CHECK(in.numbers(7) == Numbers{1, 2, 3, 0, 0, 0.6, 0.8});
  CHECK(in.at_end());

  const ros::Message pushed = ros::wrench_stamped(kTime, "base", {{4, 5, 6}, {7, 8, 9}});
  CdrReader wrench(pushed);
  wrench.header(kSec, kNanosec, "base");
  CHECK(wrench.numbers(6) == Numbers{4, 5, 6, 7, 8, 9});
  CHECK(wrench.at_end());

  const std::vector<ros::Transform> all{{"world", "tool", pose}, {"world", "object_0", {}}};
  const ros::Message moved = ros::tf_message(kTime, all);
  CdrReader tf(moved);
  REQUIRE(tf.number<uint32_t>() == 2);
  for (const std::string child : {"tool", "object_0"}) {
    tf.header(kSec, kNanosec, "world");
    CHECK(tf.text() == child);
    CHECK(tf.numbers(7) ==
          (child == "tool" ? Numbers{1, 2, 3, 0, 0, 0.6, 0.8} : Numbers{0, 0, 0, 0, 0, 0, 1}));
  }
  CHECK(tf.at_end());
}

TEST_CASE("ros messages: a mesh as a list of triangles") {
  const std::vector<Vec3> vertices{{0, 0, 0}, {1, 0, 0}, {0, 2, 0}, {0, 0, 3}};
  const std::vector<std::array<uint32_t, 3>> triangles{{0, 1, 2}, {0, 3, 1}};
  ros::MeshMarker marker{"object_3", "block", 3, {0.25f, 0.5f, 0.75f, 1}, vertices, triangles};
  const ros::Message message = ros::triangle_list(kTime, marker);
  CdrReader in(message);
  in.header(kSec, kNanosec, "object_3");
  CHECK(in.text() == "block");
  CHECK(in.number<int32_t>() == 3);
  CHECK(in.number<int32_t>() == 11);  // TRIANGLE_LIST
  CHECK(in.number<int32_t>() == 0);   // ADD
  CHECK(in.numbers(10) == Numbers{0, 0, 0, 0, 0, 0, 1, 1, 1, 1});
  for (const float channel : {0.25f, 0.5f, 0.75f, 1.0f}) CHECK(in.number<float>() == channel);
  CHECK((in.number<int32_t>() == 0 && in.number<uint32_t>() == 0));
  CHECK(in.number<uint8_t>() == 1);
  REQUIRE(in.number<uint32_t>() == 6);
  CHECK(in.numbers(18) == Numbers{0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0, 0, 0, 0, 3, 1, 0, 0});
  CHECK(in.number<uint32_t>() == 0);  // colors
  CHECK(in.text().empty());           // texture_resource
  in.header(0, 0, "");
  CHECK(in.text().empty());
  CHECK(in.number<uint32_t>() == 0);
  CHECK(in.number<uint32_t>() == 0);  // uv_coordinates
  CHECK((in.text().empty() && in.text().empty() && in.text().empty()));
  CHECK(in.number<uint32_t>() == 0);
  CHECK(in.number<uint8_t>() == 0);
  CHECK(in.at_end());
}

TEST_CASE("standard messages: at their rate, at the time of the frame, none at rate 0") {
  const test::TemporaryFolder folder;
  const double rate = GENERATE(60.0, 0.0);
  const std::string path = folder.path() + "/a.mcap";
  {
    TraceWriter trace(path, {});
    StandardMessages standard(trace, rate);
    standard.set_base({{1, 2, 3}, {}});
    const std::array<Vec3, 3> corners{Vec3{0, 0, 0}, Vec3{1, 0, 0}, Vec3{0, 1, 0}};
    const std::array<std::array<uint32_t, 3>, 1> triangles{{{0, 1, 2}}};
    standard.add_mesh(
        {.frame = "object_0", .name = "it", .vertices = corners, .triangles = triangles},
        {5, kTime, 0});
    for (int64_t k = 0; k < 2000; ++k) {
      ServoFrame frame{};
      frame.t_ns = k * 1'000'000, frame.realtime_ns = kTime + frame.t_ns;
      SceneFrame scene{};
      scene.objects.resize(2);
      standard.add(frame, &scene);
    }
    trace.close();
  }
  const McapReader reader(path);
  CHECK(reader.channels().size() == (rate > 0 ? 10u : 5u));
  const McapChannel* tf = reader.find_channel("/tf");
  REQUIRE((tf != nullptr) == (rate > 0));
  CHECK((reader.find_channel("/scene/markers/object_0") != nullptr) == (rate > 0));
  if (tf == nullptr) return;
  CHECK(reader.schema_of(*tf).name == "tf2_msgs/msg/TFMessage");
  int count = 0;
  const auto check = [&](const McapMessage& message) {
    if (message.channel != tf->id) return;
    ++count;
    CdrReader in(message.data);
    CHECK(in.number<uint32_t>() == 5);  // tool, proxy, base, two objects
    const auto sec = static_cast<uint64_t>(in.number<int32_t>());
    CHECK(sec * 1'000'000'000 + in.number<uint32_t>() == message.log_time_ns);
  };
  for (const McapChunkIndex& chunk : reader.chunks()) reader.for_each_in(chunk, check);
  CHECK(std::abs(count - 120) <= 1);
}

}  // namespace haptic
