// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/eval/mesh/table.h"
#include "clients/hapt/check_outputs.h"
#include "clients/hapt/options.h"
#include "clients/lab/support/measurement.h"
#include "clients/lab/support/offline_session.h"
#include "proto/os/text.h"
#include "proto/wire/renderer.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <map>
#include <memory>
#include <utility>

namespace haptic {
namespace {

/// Metric of a row and heading of its column.
constexpr std::array<std::pair<const char*, const char*>, 9> kColumns{
    {{"force error, max", "error max"},
     {"force error, rms", "error rms"},
     {"ripple, max", "ripple max"},
     {"jammed ticks", "jams"},
     {"ticks fallen through", "lost"},
     {"verified proxy behind the surface, max", "behind"},
     {"ticks not in a local minimum", "not at rest"},
     {"ticks not finite", "NaN"},
     {"force held by the device, max", "held max"}}};

constexpr size_t kNameWidth = 46, kColumnWidth = 13;  // [characters]

const Row* find(const std::vector<Row>& rows, const std::string& metric) {
  const auto it =
      std::find_if(rows.begin(), rows.end(), [&](const Row& row) { return row.metric == metric; });
  return it == rows.end() ? nullptr : &*it;
}

std::string table_cell(const Row* row) {
  if (row == nullptr) return "";
  return formatted("%.2g%s%s%s", row->value, row->unit.empty() ? "" : " ", row->unit.c_str(),
                   row->holds.value_or(true) ? "" : " !");
}

}  // namespace

std::vector<std::string> published_work() {
  return {"flat:50",   "hf:50",     "hf:187",     "hf:374",    "hf:742",
          "sphere:16", "sphere:59", "sphere:118", "sphere:235"};
}

std::vector<RendererEval> cases_of(const EvalTable& table) {
  std::vector<RendererEval> cases;
  for (const std::string& asked : table.meshes) {
    const std::vector<std::string> meshes =
        asked == "all" ? published_work() : std::vector<std::string>{asked};
    for (const std::string& mesh : meshes) {
      for (const double radius : table.radii) {
        for (const uint32_t latency : table.latencies) {
          RendererEval one = table.each;
          one.mesh = mesh;
          one.radius = radius;
          one.lockstep.contact_latency = latency;
          cases.push_back(one);
        }
      }
    }
  }
  return cases;
}

void print_cases(std::ostream& out, const std::vector<std::vector<Row>>& cases) {
  if (cases.empty()) return;
  if (const Row* machine = find(cases[0], "machine")) out << "  " << machine->note << "\n\n";
  out << padded("  case ('!': misses its goal)", kNameWidth);
  for (const auto& [metric, head] : kColumns) out << padded(head, kColumnWidth);
  out << "goals\n";
  for (const std::vector<Row>& rows : cases) {
    out << padded("  " + rows[0].case_name, kNameWidth);
    for (const auto& [metric, head] : kColumns)
      out << padded(table_cell(find(rows, metric)), kColumnWidth);
    const char* const held = find(rows, kNoAnswer) != nullptr ? "no answer\n" : "hold\n";
    out << (all_hold(rows) ? held : "MISSED\n");
  }
}

namespace {

/// One case or several. Throws std::runtime_error for --plot with several.
void eval_cases(const EvalTable& table, bool overwrite, Report& report) {
  const std::vector<RendererEval> cases = cases_of(table);
  std::vector<std::string> inputs{table.each.trace};
  for (const RendererEval& one : cases) {
    if (!is_eval_work(one.mesh)) inputs.push_back(one.mesh);
  }
  check_outputs({table.each.plot}, inputs, overwrite);
  if (cases.size() == 1) return eval_renderer(cases[0], report.rows);
  if (!table.each.plot.empty()) throw std::runtime_error("--plot: draws one case; give one MESH");
  std::vector<std::vector<Row>> judged;
  for (RendererEval one : cases) {
    one.progress =
        "case " + std::to_string(judged.size() + 1) + " of " + std::to_string(cases.size());
    const Rows rows;
    eval_renderer(one, rows);
    judged.push_back(rows.rows());
    report.rows.append(rows.rows());
  }
  report.print = [judged](std::ostream& out) { print_cases(out, judged); };
}

void add_renderer_options(Command& command, RendererEval& judged) {
  std::map<std::string, Renderer> renderers;
  for (const RendererRow& row : kRenderers) {
    if (!is_of_body(row.id)) renderers.emplace(row.name, row.id);
  }
  command.choice("--renderer", judged.renderer, renderers, "the renderer, of a point")
      .show_default("god-object3");
  command.number("--friction", judged.friction, {0, 10}, "μ of virtual-proxy3, measured on flat:N")
      .show_default();
  add_scan_size(command, judged.size);
  command
      .quantity("--stiffness", judged.stiffness, Dimension::kStiffness, {1, 1e5},
                "of the coupling; a number without unit is in N/m", "N/m")
      .show_default();
  command
      .quantity("--max-force", judged.max_force, Dimension::kForce, {0.1, 1e3},
                "limit of the device; a number without unit is in N", "N")
      .show_default();
  add_counts(command, {{"--ticks", &judged.ticks, "length of the tool's path", 1, 10'000'000}});
  command.option("--trace FILE", judged.trace, "a recorded hand instead of the mesh's own path");
  add_plot(command, judged.plot, "draw force, error and ripple into this file");
}

}  // namespace

Measured suite_mesh(Command& command) {
  struct Options {
    EvalTable table{{}, {}, {1e-3}, {}};
    bool overwrite = false;
  };
  const auto options = std::make_shared<Options>();
  EvalTable& table = options->table;
  command
      .option("MESH", table.meshes,
              "hf:N, sphere:N, flat:N, a mesh file, or all for the benchmark set; several make a "
              "table")
      .required();
  command
      .quantity("--radius", table.radii, Dimension::kLength, {0, 0.1},
                "of the proxy of virtual-proxy3, as \"1 mm\"; 0: a point; a number without unit "
                "is in metres",
                "m")
      .show_default();
  add_renderer_options(command, table.each);
  add_lockstep(command, table.each.lockstep);
  add_overwrite(command, options->overwrite);
  return [options, command](Report& report) {
    EvalTable asked = options->table;
    asked.latencies = {asked.each.lockstep.contact_latency};
    // the benchmark set is published with both
    if (asked.meshes == std::vector<std::string>{"all"} &&
        !command.was_given("--contact-latency")) {
      asked.latencies = {0, 1};
    }
    eval_cases(asked, options->overwrite, report);
  };
}

}  // namespace haptic
