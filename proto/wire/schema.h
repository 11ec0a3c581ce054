// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "proto/wire/parts.h"
#include "proto/wire/wire.h"

/// The wire structs as text: ROS 2 message definitions whose CDR encoding equals the struct in
/// memory byte for byte, up to its first part (packed.h); a part is a bounded sequence. They are
/// the schemas in a recording and part of a segment's ABI hash, comments included. A `[unit]` at
/// the start of a comment is the field's unit; `[a, b]` gives the units of a compound's members in
/// order. schema.cpp checks every offset at compile time.
namespace haptic {

/// Stands for the index of the element that the field is of.
inline constexpr uint32_t kOwnIndex = 0xffff'ffff;

/// Since which layout records have a field, and the value that stands for it in older ones; of a
/// part the number of its values.
struct Since {
  uint32_t layout = 1, value = 0;
  std::string_view why;
};

/// A field of a record as the list states it.
struct RecordField {
  std::string_view type, name;
  size_t count;         // of an array or a part; 0: neither
  size_t offset, size;  // [bytes]
  bool is_part;
  std::string_view doc, readers;
  Since since{};
};

/// `name`: MCAP schema name; `type`: as in a field; `text`: definition of the fields, without
/// nested types.
template <typename T>
struct Schema;

// types of fields in ROS 2
#define HAPTIC_ROS_double "float64"
#define HAPTIC_ROS_int64_t "int64"
#define HAPTIC_ROS_uint64_t "uint64"
#define HAPTIC_ROS_uint32_t "uint32"
#define HAPTIC_ROS_Vec3 "geometry_msgs/Vector3"
#define HAPTIC_ROS_Pose "geometry_msgs/Pose"
#define HAPTIC_ROS_Twist "geometry_msgs/Twist"
#define HAPTIC_ROS_Wrench "geometry_msgs/Wrench"
#define HAPTIC_ROS_DeviceState "haptic_msgs/DeviceState"
#define HAPTIC_ROS_Contact "haptic_msgs/Contact"
#define HAPTIC_ROS_ToolBody "haptic_msgs/ToolBody"
#define HAPTIC_ROS_GuideRow "haptic_msgs/GuideRow"
#define HAPTIC_ROS_ObjectPush "haptic_msgs/ObjectPush"
#define HAPTIC_ROS_ObjectSeen "haptic_msgs/ObjectSeen"
#define HAPTIC_ROS_SceneObject "haptic_msgs/SceneObject"
#define HAPTIC_ROS_SeenPush "haptic_msgs/SeenPush"
#define HAPTIC_ROS_ObjectResponse "haptic_msgs/ObjectResponse"
#define HAPTIC_ROS_JointState "haptic_msgs/JointState"
#define HAPTIC_ROS_GiverState "haptic_msgs/GiverState"
#define HAPTIC_ROS_GivenMotion "haptic_msgs/GivenMotion"
#define HAPTIC_ROS_FeltClient "haptic_msgs/FeltClient"
#define HAPTIC_ROS_ToolWrench "haptic_msgs/ToolWrench"
#define HAPTIC_ROS_AppliedWrench "haptic_msgs/AppliedWrench"
#define HAPTIC_ROS_GivenWrench "haptic_msgs/GivenWrench"
#define HAPTIC_ROS_GivenPlane "haptic_msgs/GivenPlane"
#define HAPTIC_ROS_DrawnPoint "haptic_msgs/DrawnPoint"
#define HAPTIC_ROS_DrawnLine "haptic_msgs/DrawnLine"

#define RECORD(record, writer, doc)                                      \
  template <>                                                            \
  struct Schema<record> {                                                \
    static constexpr std::string_view type = "haptic_msgs/" #record;     \
    static constexpr std::string_view name = "haptic_msgs/msg/" #record; \
    static constexpr std::string_view text =
#define FIELD(type, field, doc, ...) HAPTIC_ROS_##type " " #field "  # " doc "\n"
#define ARRAY(type, count, field, doc, ...) HAPTIC_ROS_##type "[" #count "] " #field "  # " doc "\n"
#define PART(type, most, field, doc, ...) HAPTIC_ROS_##type "[<=" #most "] " #field "  # " doc "\n"
#define END(record) \
  ;                 \
  }                 \
  ;
#include "proto/wire/records.def"

/// A record as the list states it; `fields` in the order of their bytes.
struct RecordRow {
  std::string_view name, writer, doc, text;
  size_t size;  // [bytes]
  std::vector<RecordField> fields;
};

/// All records, nested ones before those that hold them.
const std::vector<RecordRow>& all_records();

/// The record of this name; null: there is none.
const RecordRow* find_record(std::string_view name);

/// One number of a message and its place in the bytes.
struct Field {
  std::string name;  // path from the message, "device.X_BH.position.x", "contacts[3].extent"
  std::string type;  // ROS 2 primitive: float64, int64, uint64, uint32, …
  size_t offset;     // from the start of the struct [bytes]
  std::string unit;  // "m", "N·s"; empty for pure numbers
};

/// A message as a struct in memory: its numbers in the order of their bytes, and the parts behind
/// the last field. The number of values of part `objects` has the name `n_objects`, where they
/// begin.
struct Fields : std::vector<Field> {
  std::vector<RecordPart> parts;
  size_t bytes = 0;  // of the struct
};

/// Every number of the message `text` in byte order. Nested types must be those of this header or
/// geometry_msgs; throws std::runtime_error otherwise.
Fields flatten(std::string_view text);

/// Every number of the schema of a file, without units: `definition` holds the nested types as
/// well, as full_definition() writes them. It is not trusted: throws std::runtime_error where it is
/// malformed, refers to itself, or describes more than a record can hold.
Fields flatten_definition(std::string_view definition);

/// Bytes of one number.
size_t size_of(const Field& field);

/// A name in lower case: readers of ROS 2 demand it of fields.
std::string lower_case(std::string_view name);

/// `text` followed by the definitions of all nested types, for MCAP's `ros2msg` encoding. Field
/// names are in lower case (`x_wp`), as ROS 2 readers demand.
std::string full_definition(std::string_view text);

}  // namespace haptic
