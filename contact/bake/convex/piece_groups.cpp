// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact/bake/convex/piece_groups.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <queue>
#include <set>
#include <tuple>

namespace haptic {
namespace {

constexpr int kMortonBits = 20;  // of each coordinate

Box united(Box a, const Box& b) {
  a.add(b);
  return a;
}

/// Its place along a Morton curve through `all`.
uint64_t morton_code(const Box& box, const Box& all) {
  const Vec3 middle = 0.5 * (box.lower + box.upper);
  uint64_t code = 0;
  std::array<uint64_t, 3> place{};
  for (int k = 0; k < 3; ++k) {
    const double side = all.upper[k] - all.lower[k];
    const double share = side > 0 ? (middle[k] - all.lower[k]) / side : 0;
    place[static_cast<size_t>(k)] =
        static_cast<uint64_t>(std::clamp(share, 0.0, 1.0) * ((1 << kMortonBits) - 1));
  }
  for (int bit = kMortonBits - 1; bit >= 0; --bit) {
    for (const uint64_t p : place) code = code << 1 | (p >> bit & 1);
  }
  return code;
}

struct Group {
  Box box;
  std::vector<uint32_t> members;
  std::set<uint32_t> neighbours;
  bool is_gone = false;
};

}  // namespace

std::vector<std::vector<uint32_t>> group_pieces(const std::vector<Box>& boxes,
                                                const PiecePairs& neighbours, size_t target) {
  std::vector<Group> groups(boxes.size());
  for (uint32_t i = 0; i < boxes.size(); ++i) groups[i] = {boxes[i], {i}, {}};
  using Offer = std::tuple<double, uint32_t, uint32_t>;
  std::priority_queue<Offer, std::vector<Offer>, std::greater<>> offers;
  const auto join = [&](uint32_t a, uint32_t b) {
    if (a == b) return;
    groups[a].neighbours.insert(b);
    groups[b].neighbours.insert(a);
    const Box box = united(groups[a].box, groups[b].box);
    offers.emplace(norm_squared(box.size()), std::min(a, b), std::max(a, b));
  };
  for (const auto& [a, b] : neighbours) join(a, b);
  size_t n = boxes.size();
  while (n > target) {
    if (offers.empty()) {
      std::vector<uint32_t> left;
      Box all = boxes[0];
      for (uint32_t i = 0; i < groups.size(); ++i) {
        if (!groups[i].is_gone) left.push_back(i), all = united(all, groups[i].box);
      }
      std::sort(left.begin(), left.end(), [&](uint32_t a, uint32_t b) {
        return std::pair(morton_code(groups[a].box, all), a) <
               std::pair(morton_code(groups[b].box, all), b);
      });
      for (size_t i = 0; i + 1 < left.size(); ++i) join(left[i], left[i + 1]);
    }
    const auto [cost, a, b] = offers.top();
    offers.pop();
    if (groups[a].is_gone || groups[b].is_gone) continue;
    // a group that has grown is another one, so that offers to it are always up to date
    const auto made = static_cast<uint32_t>(groups.size());
    groups.push_back({united(groups[a].box, groups[b].box), groups[a].members, {}});
    std::vector<uint32_t>& members = groups[made].members;
    members.insert(members.end(), groups[b].members.begin(), groups[b].members.end());
    groups[a].is_gone = groups[b].is_gone = true;
    for (const uint32_t old : {a, b}) {
      for (const uint32_t other : groups[old].neighbours) {
        if (!groups[other].is_gone && !groups[made].neighbours.contains(other)) join(made, other);
      }
      groups[old].neighbours.clear();
    }
    --n;
  }
  std::vector<std::vector<uint32_t>> result;
  for (Group& group : groups) {
    if (group.is_gone) continue;
    std::sort(group.members.begin(), group.members.end());
    result.push_back(std::move(group.members));
  }
  std::sort(result.begin(), result.end());
  return result;
}

}  // namespace haptic
