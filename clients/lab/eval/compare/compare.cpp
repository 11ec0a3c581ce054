// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/eval/compare/compare.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <memory>
#include <sstream>
#include <utility>

#include "clients/hapt/check_outputs.h"
#include "clients/hapt/options.h"
#include "clients/lab/support/measurement.h"
#include "clients/lab/support/offline_session.h"
#include "clients/log/log_columns.h"
#include "clients/log/log_eyes.h"
#include "clients/log/trace_writer.h"
#include "clients/report/summary.h"
#include "contact/bake/eye_files.h"
#include "contact/query/point/closest_point.h"
#include "device-io/device.h"
#include "proto/config/command_line.h"
#include "proto/config/devices.h"
#include "proto/config/renderer_needs.h"
#include "proto/ipc/eye_file.h"
#include "proto/log/trace.h"
#include "proto/os/message.h"
#include "proto/os/text.h"
#include "proto/os/version.h"
#include "proto/wire/scene_pose.h"

namespace haptic {
namespace {

constexpr size_t kMostDepths = 500;     // ticks whose depth is measured
constexpr size_t kMostVertices = 1000;  // of the tool, looked at in each

bool is_soft(Renderer renderer) {
  return is_of_body(renderer) && !is_rigid(renderer);
}

/// The shape of the tool, which the measures use; they share no code with the renderers.
struct ToolPoints {
  std::vector<Vec3> vertices_T;
  Vec3 centre_T;
  double radius = 0;  // of a ball around the centre that holds the tool [m]
};

ToolPoints points_of(const BakedSession& baked) {
  ToolPoints out;
  if (!baked.tool) {
    out.vertices_T = {Vec3{}};
    return out;
  }
  const TriangleMesh& mesh = baked.tool->shape.mesh;
  out.centre_T = 0.5 * (mesh.lower + mesh.upper);
  const size_t every = std::max<size_t>(mesh.vertices.size() / kMostVertices, 1);
  for (size_t i = 0; i < mesh.vertices.size(); ++i) {
    out.radius = std::max(out.radius, norm(mesh.vertices[i] - out.centre_T));
    if (i % every == 0) out.vertices_T.push_back(mesh.vertices[i]);
  }
  return out;
}

/// The closest surface to a point given in W.
ClosestPoint closest(const BakedShape& object, const Pose& X_WO, const Vec3& p_W) {
  return closest_point(object.shape, inverse(X_WO) * p_W, std::numeric_limits<double>::infinity());
}

/// One renderer with its hand, as it goes on.
class Column {
 public:
  Column(const SessionConfig& config, const std::string& name, const BakedSession& baked,
         const ContactShapes& shapes, const LockstepOptions& lockstep, double layer)
      : config_(config),
        baked_(baked),
        device_(open_device(config.device)),
        lockstep_(config, shapes, *device_, lockstep),
        tool_(points_of(baked)),
        layer_(layer) {
    figures_.name = name;
    const bool has_mass = is_soft(config.renderer) &&
                          solver_of(config.proxy, config.renderer) == SoftSolver::kPenaltyDynamics;
    figures_.is_massless = !has_mass && config.renderer != Renderer::kConstrained6;
  }

  bool step() {
    if (!lockstep_.step()) return false;
    const ServoFrame& frame = lockstep_.frame();
    figures_.last = frame;
    if (is_free(frame)) {
      ++figures_.free_ticks;
      figures_.free_force = std::max(figures_.free_force, norm(frame.F_coupling_W.f));
    }
    frames_.push_back(frame);
    scenes_.push_back(lockstep_.scene());
    return true;
  }

  void write(TraceWriter& trace, const LogColumn& topics) {
    const ServoFrame& f = lockstep_.frame();
    trace.write(Topic<ServoFrame>{topics.servo}, f, {f.t_ns, f.realtime_ns, f.tick});
    const ContactSet* set = lockstep_.contacts();
    if (set != nullptr && set->answers_t_ns != written_set_ns_) {
      written_set_ns_ = set->answers_t_ns;
      trace.write(Topic<ContactSet>{topics.contact}, *set, {f.t_ns, f.realtime_ns, set->seq});
    }
    const SceneFrame& scene = lockstep_.scene();
    if (scene.seq == written_scene_) return;
    written_scene_ = scene.seq;
    trace.write(Topic<SceneFrame>{topics.sim}, scene, {f.t_ns, f.realtime_ns, scene.seq});
  }

  CompareFigures figures() {
    measure_force();
    measure_depth();
    figures_.returned = port_energy(frames_).returned;
    return figures_;
  }

 private:
  Pose object_pose(const SceneFrame& scene, uint32_t i, const ServoFrame& frame) const {
    return scene.objects.size() > i
               ? object_pose_at(scene, i, frame.t_ns, push_of(frame, kFirstHand))
               : config_.objects[i].X_WO;
  }

  bool is_free(const ServoFrame& frame) const {
    const Vec3 centre_W = frame.X_WT * tool_.centre_T;
    for (uint32_t i = 0; i < baked_.objects.size(); ++i) {
      const Pose X_WO = object_pose(lockstep_.scene(), i, frame);
      const ClosestPoint c = closest(baked_.objects[i], X_WO, centre_W);
      if (!c.found || c.inside || c.distance <= tool_.radius + layer_) return false;
    }
    return true;
  }

  void measure_force() {
    double sum = 0;
    size_t touching = 0;
    std::optional<ServoFrame> before;
    for (const ServoFrame& frame : frames_) {
      const Vec3& f = frame.F_device_B.f;
      if (is_touching(frame)) ++touching, sum += norm(f);
      if (before) {
        const double ms = 1e-6 * static_cast<double>(frame.t_ns - before->t_ns);
        figures_.force_step = std::max(figures_.force_step, norm(f - before->F_device_B.f) / ms);
      }
      before = frame;
    }
    figures_.contact_force = touching > 0 ? sum / static_cast<double>(touching) : 0;
    figures_.share =
        static_cast<double>(touching) / static_cast<double>(std::max<size_t>(frames_.size(), 1));
  }

  void measure_depth() {
    std::vector<size_t> touching;
    for (size_t k = 0; k < frames_.size(); ++k) {
      if ((frames_[k].flags & kServoContact) != 0) touching.push_back(k);
    }
    const size_t every = std::max<size_t>(touching.size() / kMostDepths, 1);
    double sum = 0, n = 0;
    for (size_t j = 0; j < touching.size(); j += every, n += 1) {
      const double depth = depth_at(frames_[touching[j]], scenes_[touching[j]]);
      figures_.depth_max = std::max(figures_.depth_max, depth);
      sum += depth;
    }
    figures_.depth_mean = n > 0 ? sum / n : 0;
  }

  double depth_at(const ServoFrame& frame, const SceneFrame& scene) const {
    double deepest = 0;
    for (uint32_t i = 0; i < baked_.objects.size(); ++i) {
      if (!baked_.objects[i].shape.mesh.closed) continue;
      const Pose X_WO = object_pose(scene, i, frame);
      for (const Vec3& p_T : tool_.vertices_T) {
        const ClosestPoint c = closest(baked_.objects[i], X_WO, frame.X_WP * p_T);
        if (c.found && c.inside) deepest = std::max(deepest, c.distance);
      }
    }
    return deepest;
  }

  SessionConfig config_;
  const BakedSession& baked_;
  std::unique_ptr<Device> device_;
  Lockstep lockstep_;
  ToolPoints tool_;
  double layer_;  // distance at which a surface may push [m]
  PackedRecords<ServoFrame> frames_;
  PackedRecords<SceneFrame> scenes_;
  int64_t written_set_ns_ = -1;
  uint64_t written_scene_ = 0;
  CompareFigures figures_;
};

/// The writer of the comparison, with topics for each column.
std::unique_ptr<TraceWriter> open_output(const CompareEval& eval,
                                         const std::vector<LogColumn>& columns) {
  if (eval.output.empty()) return nullptr;
  std::vector<TopicInfo> topics;
  std::string names;
  McapMetadata comparison;
  for (size_t i = 0; i < columns.size(); ++i) {
    topics.push_back(info_of(Topic<ServoFrame>{columns[i].servo}, "one record a servo tick"));
    topics.push_back(info_of(Topic<ContactSet>{columns[i].contact}, "answers of contact"));
    topics.push_back(info_of(Topic<SceneFrame>{columns[i].sim}, "poses of the objects"));
    names += (i == 0 ? "" : ",") + columns[i].name;
    comparison["way of " + columns[i].name] =
        way_of_column(config_of_column(eval.config, columns[i].name));
  }
  comparison["columns"] = names;
  comparison["time"] = "virtual";
  // nothing of the machine or of the hour: the same comparison is the same file
  auto trace = std::make_unique<TraceWriter>(
      eval.output,
      McapMetadata{{"version", version()},
                   {"abi", std::to_string(kAbiMajor) + "." + std::to_string(kAbiMinor)},
                   {"session", std::string(view(eval.config.name))},
                   {"config", eval.config_text}},
      topics);
  trace->add_metadata("comparison", comparison);
  return trace;
}

/// The eye files of the scene, as a session hands them out; a mesh that cannot be drawn is left
/// out.
void write_eyes(TraceWriter& trace, const SessionConfig& config, const BakedSession& baked) {
  const auto add = [&](uint32_t object) {
    try {
      trace.add_attachment(eye_attachment(object), kEyeMediaType, 0,
                           make_eye(config, baked, object));
    } catch (const EyeError&) {
      // a viewer shows the rest
    }
  };
  add(kEyeOfTool);
  for (uint32_t i = 0; i < config.n_objects; ++i) add(i);
}

/// A figure of a column: its metric in rows, its head in the table, its unit and its value.
struct Measure {
  const char *metric, *head, *unit;
  double CompareFigures::*value;
};
constexpr std::array kMeasures{
    Measure{"force in free space, max", "free, max", "N", &CompareFigures::free_force},
    Measure{"depth of the proxy, max", "depth, max", "m", &CompareFigures::depth_max},
    Measure{"depth of the proxy, mean", "depth, mean", "m", &CompareFigures::depth_mean},
    Measure{"largest force step", "step", "N/ms", &CompareFigures::force_step},
    Measure{"energy given to the hand", "given back", "J", &CompareFigures::returned},
    Measure{"force in contact, mean", "|F| mean", "N", &CompareFigures::contact_force}};

std::vector<std::string> words_of(const std::string& list) {
  std::vector<std::string> words;
  std::istringstream in(list);
  for (std::string word; std::getline(in, word, ',');) words.push_back(word);
  return words;
}

}  // namespace

SessionConfig config_of_column(const SessionConfig& config, const std::string& column) {
  SessionConfig out = config;
  const size_t slash = column.find('/');
  if (slash != std::string::npos) {
    const std::string word = column.substr(slash + 1);
    const auto solver = std::ranges::find(kSoftSolverNames, word);
    if (solver == kSoftSolverNames.end()) {
      throw UsageError("compare: no solver '" + shown(word) +
                       "'; known: direct, penalty-dynamics, quasi-static");
    }
    out.proxy.solver = static_cast<SoftSolver>(solver - kSoftSolverNames.begin());
  } else {
    out.proxy.solver.reset();
  }
  if (column.starts_with("voxel")) out.voxel.is_wanted = 1;
  use_renderer(out, column.substr(0, slash));
  if (slash != std::string::npos && !is_soft(out.renderer)) {
    throw UsageError("compare: '" + shown(column) +
                     "': only voxel, direct6, localized and "
                     "sensation have solvers");
  }
  return out;
}

std::string way_of_column(const SessionConfig& config) {
  const bool is_direct = is_of_body(config.renderer) ? !has_springs(config.proxy, config.renderer)
                                                     : config.renderer == Renderer::kPenalty3;
  const bool is_penalty = is_of_body(config.renderer) ? !is_rigid(config.renderer) : is_direct;
  return std::string(is_direct ? "direct" : "virtual coupling") +
         (is_penalty ? ", penalty" : ", constraint");
}

std::vector<CompareFigures> compare_renderers(const CompareEval& eval) {
  std::vector<SessionConfig> configs;
  std::vector<LogColumn> topics;
  SessionConfig baking = eval.config;
  double layer = 0;
  for (const std::string& name : eval.columns) {
    configs.push_back(config_of_column(eval.config, name));
    topics.push_back(column_of_comparison(name));
    const bool has_maps = row_of(configs.back().renderer).has_maps;
    if (has_maps) baking.voxel.is_wanted = 1;
    if (row_of(configs.back().renderer).has_pieces) baking.pieces.is_wanted = 1;
    const VoxelConfig& voxel = eval.config.voxel;
    if (has_maps) layer = std::max(layer, (voxel.offset_layers + 1) * voxel.size);
  }
  const BakedSession baked = bake_session(baking);
  const ContactShapes shapes = baked.shapes();
  const std::unique_ptr<TraceWriter> trace = open_output(eval, topics);
  if (trace) write_eyes(*trace, configs.front(), baked);
  std::vector<std::unique_ptr<Column>> columns;
  for (size_t i = 0; i < configs.size(); ++i) {
    columns.push_back(
        std::make_unique<Column>(configs[i], eval.columns[i], baked, shapes, eval.lockstep, layer));
  }
  const uint64_t ticks = ticks_of(eval.config, eval.seconds);
  for (uint64_t k = 0; k < ticks; ++k) {
    size_t running = 0;
    for (size_t i = 0; i < columns.size(); ++i) {
      if (!columns[i]->step()) continue;
      ++running;
      if (trace) columns[i]->write(*trace, topics[i]);
    }
    if (running == 0) break;
  }
  if (trace && !trace->close()) throw McapError(trace->error());
  std::vector<CompareFigures> out;
  for (const auto& column : columns) out.push_back(column->figures());
  return out;
}

void add_rows(const std::vector<CompareFigures>& figures, const CompareEval& eval,
              const Rows& all) {
  for (const CompareFigures& f : figures) {
    Rows rows = all.of(f.name);
    rows.add({{"way", way_of_column(config_of_column(eval.config, f.name))},
              {"massless", f.is_massless ? 1 : 0},
              {"ticks in free space", f.free_ticks}});
    for (const Measure& m : kMeasures) {
      const bool is_judged = m.value == &CompareFigures::free_force && f.is_massless;
      rows.add({{m.metric, f.*m.value, m.unit, is_judged ? kMustBeZero : Goal{}}});
    }
    rows.add("share of ticks in contact", 100 * f.share, "%");
  }
}

void print_comparison(std::ostream& out, const std::vector<CompareFigures>& figures,
                      const CompareEval& eval) {
  constexpr size_t kName = 26, kWay = 30, kCell = 14;
  out << padded("", kName) << padded("way", kWay);
  for (const Measure& m : kMeasures) out << padded(m.head, kCell);
  out << "massless\n";
  for (const CompareFigures& f : figures) {
    out << padded(f.name, kName)
        << padded(way_of_column(config_of_column(eval.config, f.name)), kWay);
    for (const Measure& m : kMeasures) out << padded(readable(f.*m.value, m.unit), kCell);
    out << (f.is_massless ? "yes\n" : "no\n");
  }
  out << "\nThe ways of rendering (after Otaduy & Lin):\n"
         "                     penalty                            constraint\n"
         "  direct             direct6, voxel/direct, penalty3:   none here: a hand that is held\n"
         "                     force by depth at the hand         needs a device that moves it\n"
         "  virtual coupling   voxel/quasi-static (no mass),      god-object6 (no mass),\n"
         "                     voxel/penalty-dynamics (mass):     constrained6 (mass): it never\n"
         "                     the proxy is F/k deep              enters an object\n";
}

Measured suite_compare(Command& command) {
  struct Options {
    OfflineSession session;
    std::string columns, output;
    bool overwrite = false;
  };
  const auto options = std::make_shared<Options>();
  command
      .option("COLUMNS", options->columns,
              "renderers divided by commas, with a solver where they have some, as "
              "god-object6,voxel/quasi-static")
      .required();
  add_offline_session(command, options->session);
  command.option("-o,--output FILE.mcap", options->output,
                 "a recording with the topics of each renderer; no clock is in it, the same "
                 "comparison is the same file");
  add_overwrite(command, options->overwrite);
  return [options](Report& report) {
    const OfflineSession& session = options->session;
    const std::string file = session.file();
    const CompareEval eval{words_of(options->columns), session.load(),
                           read_config_text(file),     options->output,
                           session.lockstep,           session.seconds};
    check_outputs({eval.output}, {session.trace, file}, options->overwrite);
    const std::vector<CompareFigures> figures = compare_renderers(eval);
    add_rows(figures, eval, report.rows);
    report.print = [figures, eval](std::ostream& out) { print_comparison(out, figures, eval); };
  };
}

}  // namespace haptic
