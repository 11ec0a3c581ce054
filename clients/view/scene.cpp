// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/view/scene.h"

#include <algorithm>
#include <array>

#include "proto/config/config.h"
#include "proto/config/devices.h"
#include "proto/config/renderer_needs.h"
#include "proto/os/json.h"
#include "proto/wire/proxy_solver.h"

namespace haptic {
namespace {

Json path_of(const SharedText& eye, const std::string& folder, const std::string& name) {
  return eye == nullptr ? Json(nullptr) : Json("/" + folder + "/" + name + ".bin");
}

SharedText eye_at(const std::vector<SharedText>& eyes, size_t index) {
  return index < eyes.size() ? eyes[index] : nullptr;
}

Json material_json(const MaterialConfig& material) {
  return {{"friction_static", material.friction_static},
          {"friction_dynamic", material.friction_dynamic},
          {"friction_viscous", material.friction_viscous},
          {"stiffness_share", material.stiffness_share},
          {"crease_angle", material.crease_angle},
          {"texture", material.texture.kind != TextureKind::kNone}};
}

Json objects_json(const SceneInfo& info, const View& view) {
  const size_t n =
      std::max<size_t>({info.config ? info.config->n_objects : 0,
                        view.has_scene ? view.scene.objects.size() : 0, info.eyes.objects.size()});
  Json objects = Json::array();
  for (size_t i = 0; i < std::min<size_t>(n, kMaxObjects); ++i) {
    const std::string number = std::to_string(i);
    Json object{{"index", i},
                {"name", "object " + number},
                {"mesh", path_of(eye_at(info.eyes.objects, i), "mesh", number)},
                {"pieces", path_of(eye_at(info.eyes.object_pieces, i), "pieces", number)}};
    if (info.config && i < info.config->n_objects) {
      const ObjectConfig& configured = info.config->objects[i];
      if (!haptic::view(configured.name).empty()) object["name"] = haptic::view(configured.name);
      object["material"] = material_json(configured.material);
    }
    objects.push_back(object);
  }
  return objects;
}

/// The joints in the order of their states; an end stop that a joint does not have is null.
Json joints_json(const SceneInfo& info) {
  Json joints = Json::array();
  if (!info.config) return joints;
  const auto end = [](double q) { return is_stop(q) ? Json(q) : Json(nullptr); };
  for (uint32_t i = 0; i < info.config->n_joints; ++i) {
    const JointConfig& joint = info.config->joints[i];
    const std::string name(haptic::view(joint.name));
    const JointKindRow& row = row_of(joint.kind);
    joints.push_back({{"name", name.empty() ? "joint " + std::to_string(i) : name},
                      {"kind", row.name},
                      {"turns", row.turns()},
                      {"lower", end(joint.lower)},
                      {"upper", end(joint.upper)}});
  }
  return joints;
}

Json renderers_json(const SceneInfo& info) {
  Json renderers = Json::array();
  for (const RendererRow& row : kRenderers) {
    std::string lack;
    if (info.config) {
      const Coupling& coupling = info.config->coupling;
      lack = lack_of(*info.config, row.id, solver_of(info.config->proxy, row.id),
                     {coupling.translational_stiffness, coupling.rotational_stiffness},
                     baked_for(*info.config));
    }
    renderers.push_back({{"name", row.name},
                         {"available", lack.empty()},
                         {"lack", lack},
                         {"has_solver", row.moves == Moves::kSoftBody}});
  }
  return renderers;
}

Json tool_json(const SceneInfo& info) {
  Json tool{{"mesh", path_of(info.eyes.tool, "mesh", "tool")},
            {"pieces", path_of(info.eyes.tool_pieces, "pieces", "tool")}};
  if (info.config) tool["radius"] = info.config->proxy_radius;
  return tool;
}

Json renderer_json(const View& view) {
  const bool is_known = view.has_servo && is_renderer(view.servo.renderer);
  return is_known ? Json(row_of(static_cast<Renderer>(view.servo.renderer)).name) : Json(nullptr);
}

void add_device(Json& scene, const SessionConfig& config) {
  const DeviceConfig& device = config.device;
  const DeviceRow& row = row_of(device.kind);
  scene.update(Json{{"device",
                     {{"description", row.name},
                      {"simulated", !row.has_node()},
                      {"max_force", device.max_force},
                      {"max_torque", device.max_torque}}},
                    {"limits",
                     {{"max_force", config.safety.max_force},
                      {"max_torque", config.safety.max_torque},
                      {"stiffness", config.coupling.translational_stiffness}}}});
}

/// A page gets every n-th mark of a kind that has very many: it has fewer pixels than marks.
Json marks_json(const std::vector<LogMark>& marks) {
  constexpr size_t kMostMarks = 4000;  // of a kind
  std::array<size_t, kMarkKinds.size()> counts{}, seen{};
  for (const LogMark& mark : marks) ++counts.at(static_cast<size_t>(mark.kind));
  Json list = Json::array();
  for (const LogMark& mark : marks) {
    const auto kind = static_cast<size_t>(mark.kind);
    if (seen[kind]++ % (counts[kind] / kMostMarks + 1) != 0) continue;
    list.push_back({{"tick", mark.tick},
                    {"time", 1e-9 * static_cast<double>(mark.t_ns)},
                    {"kind", kMarkKinds[kind]},
                    {"column", mark.column}});
  }
  return list;
}

void add_log(Json& scene, const LogFacts& log) {
  scene.update(Json{{"first_tick", log.first_tick},
                    {"last_tick", log.last_tick},
                    {"first_time", log.first_time},
                    {"last_time", log.last_time},
                    {"growing", log.growing},
                    {"marks", marks_json(log.marks)}});
}

Json scene_numbers(const Vec3& p) {
  return {p.x, p.y, p.z};
}

void add_tightest(Json& scene, const TightestPlace& place) {
  const auto& [p, q] = place.X_WT;
  scene["clearance"] = {{"object", place.object},
                        {"distance", place.distance},
                        {"tick", place.tick},
                        {"tool", {p.x, p.y, p.z, q.w, q.x, q.y, q.z}},
                        {"tool_point", scene_numbers(place.tool_point_W)},
                        {"object_point", scene_numbers(place.object_point_W)},
                        {"text", words_of(place)}};
}

}  // namespace

std::string use_config(SceneInfo& info, const std::string& text) {
  info.config_text = text;
  info.config.reset();
  try {
    info.config = parse_config(text, info.session + ".toml");
    return "";
  } catch (const std::exception& error) {
    return error.what();
  }
}

std::string scene_json(const SceneInfo& info, const View& view, bool with_config) {
  Json scene{{"type", "scene"},
             {"session", info.session},
             {"objects", objects_json(info, view)},
             {"tool", tool_json(info)},
             {"joints", joints_json(info)},
             {"renderers", renderers_json(info)},
             {"renderer", renderer_json(view)},
             {"solvers", kSoftSolverNames}};  // by SoftSolver
  if (info.config) add_device(scene, *info.config);
  if (info.started >= 0) scene["started"] = info.started;
  if (info.log) add_log(scene, *info.log);
  if (info.log && info.log->tightest) add_tightest(scene, *info.log->tightest);
  if (info.log && info.eyes.tool == nullptr && info.eyes.objects.empty()) {
    scene["notice"] = "This recording holds no meshes: pose, proxy and contacts are shown alone.";
  }
  scene["config"] = with_config ? info.config_text : "";
  return json_compact(scene);
}

}  // namespace haptic
