// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/eval/table.h"

#include <algorithm>
#include <array>
#include <cstdio>
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

constexpr int kNameWidth = 46, kColumnWidth = 13;  // [characters]

const Row* find(const std::vector<Row>& rows, const std::string& metric) {
  const auto it =
      std::find_if(rows.begin(), rows.end(), [&](const Row& row) { return row.metric == metric; });
  return it == rows.end() ? nullptr : &*it;
}

void print_cell(std::ostream& out, const std::string& text, int width) {
  char padded[128];
  std::snprintf(padded, sizeof padded, "%-*s", width, text.c_str());
  out << padded;
}

std::string table_cell(const Row* row) {
  if (row == nullptr) return "";
  char text[32];
  std::snprintf(text, sizeof text, "%.2g%s%s%s", row->value, row->unit.empty() ? "" : " ",
                row->unit.c_str(), row->holds.value_or(true) ? "" : " !");
  return text;
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
  print_cell(out, "  case ('!': misses its goal)", kNameWidth);
  for (const auto& [metric, head] : kColumns) print_cell(out, head, kColumnWidth);
  out << "goals\n";
  for (const std::vector<Row>& rows : cases) {
    print_cell(out, "  " + rows[0].case_name, kNameWidth);
    for (const auto& [metric, head] : kColumns)
      print_cell(out, table_cell(find(rows, metric)), kColumnWidth);
    const char* const held = find(rows, kNoAnswer) != nullptr ? "no answer\n" : "hold\n";
    out << (all_hold(rows) ? held : "MISSED\n");
  }
}

}  // namespace haptic
