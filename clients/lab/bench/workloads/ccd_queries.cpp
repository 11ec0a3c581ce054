// SPDX-License-Identifier: GPL-3.0-or-later
#include "clients/lab/bench/workloads/ccd_queries.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>

#include "clients/lab/support/dice.h"
#include "proto/os/regular_file.h"

namespace haptic {
namespace {

namespace fs = std::filesystem;

void read_file(const fs::path& path, bool is_face, std::vector<CcdQuery>& queries) {
  std::ifstream in;
  const std::string problem = open_stream(path.string(), in);
  if (!problem.empty()) throw std::runtime_error(path.string() + ": " + problem);
  std::array<Vec3, 8> rows;
  size_t n = 0, line_number = 0;
  for (std::string line; std::getline(in, line);) {
    ++line_number;
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream words(line);
    std::array<double, 7> v{};
    for (double& value : v) words >> value;
    if (!words) {
      throw std::runtime_error(path.string() + ": line " + std::to_string(line_number) +
                               " is not seven numbers; give a folder of ground-truth queries");
    }
    rows[n++] = {v[0] / v[1], v[2] / v[3], v[4] / v[5]};
    if (n < rows.size()) continue;
    n = 0;
    CcdQuery query{{}, is_face, v[6] != 0};
    for (size_t i = 0; i < 4; ++i) query.corners[i] = {rows[i], rows[i + 4]};
    queries.push_back(query);
  }
}

}  // namespace

std::vector<CcdFile> read_ccd_queries(const std::string& folder) {
  std::map<std::string, std::vector<fs::path>> kinds;
  if (!fs::is_directory(folder)) return {};
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    const fs::path& path = entry.path();
    if (path.extension() != ".csv") continue;
    const fs::path kind = path.parent_path();
    kinds[kind.parent_path().filename().string() + " " + kind.filename().string()].push_back(path);
  }
  std::vector<CcdFile> files;
  for (auto& [scene, paths] : kinds) {
    std::sort(paths.begin(), paths.end());
    files.push_back({scene, {}});
    const bool is_face = scene.ends_with("vertex-face");
    for (const fs::path& path : paths) read_file(path, is_face, files.back().queries);
  }
  return files;
}

std::vector<CcdQuery> hand_scale_queries(size_t n) {
  Dice dice(11);
  const auto uniform = [&](double low, double high) { return dice.uniform(low, high); };
  const auto direction = [&] { return direction_in_ball(dice); };
  std::vector<CcdQuery> queries(n);
  for (size_t k = 0; k < n; ++k) {
    CcdQuery& query = queries[k];
    query.is_face = k % 2 == 0;
    const size_t moving = query.is_face ? 1 : 2;
    const double size = uniform(0.2e-3, 2e-3);
    const Vec3 apart = uniform(0, 1e-3) * direction(), way = uniform(0.05e-3, 2e-3) * direction();
    const Quat turn = from_rotation_vector(uniform(0, 0.03) * direction());
    for (size_t i = 0; i < 4; ++i) {
      const Vec3 at = size * uniform(0, 1) * direction();
      query.corners[i] = {at, at};
      if (i < moving) query.corners[i] = {at + apart, rotate(turn, at) + apart + way};
    }
  }
  return queries;
}

std::optional<SweptMeeting> meeting_of(const CcdQuery& query, double tolerance) {
  const auto& [a, b, c, d] = query.corners;
  if (query.is_face) return vertex_face_meeting(a, {b, c, d}, tolerance);
  return edge_edge_meeting({a, b}, {c, d}, tolerance);
}

}  // namespace haptic
