// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstring>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

/// Reads frames as a page does: by /layout.json alone.
namespace haptic::test {

class LayoutReader {
 public:
  explicit LayoutReader(const std::string& layout) : layout_(nlohmann::json::parse(layout)) {}

  static std::vector<double> numbers(const std::string& bytes) {
    std::vector<double> out(bytes.size() / 8);
    std::memcpy(out.data(), bytes.data(), out.size() * 8);
    return out;
  }

  std::vector<double> fixed(const std::vector<double>& frame, const std::string& name) const {
    return part(frame, 0, layout_.at("fixed").at(name));
  }
  double one(const std::vector<double>& frame, const std::string& name) const {
    return fixed(frame, name).at(0);
  }
  std::vector<double> object(const std::vector<double>& frame, size_t i,
                             const std::string& name) const {
    return part(frame, fixed_size() + i * size("object"), layout_.at("object").at(name));
  }
  std::vector<double> contact(const std::vector<double>& frame, size_t i,
                              const std::string& name) const {
    return part(frame, contacts(frame) + i * size("contact"), layout_.at("contact").at(name));
  }
  std::vector<double> joint(const std::vector<double>& frame, size_t i,
                            const std::string& name) const {
    return part(frame, joints(frame) + i * size("joint"), layout_.at("joint").at(name));
  }
  std::vector<double> sample(const std::vector<double>& frame, size_t i,
                             const std::string& name) const {
    return part(frame, samples(frame) + i * size("sample"), layout_.at("sample").at(name));
  }
  /// The length that the counts of a frame give it.
  size_t length(const std::vector<double>& frame) const {
    return samples(frame) + count(frame, "n_samples") * size("sample");
  }
  size_t count(const std::vector<double>& frame, const std::string& name) const {
    return static_cast<size_t>(one(frame, name));
  }

 private:
  size_t fixed_size() const { return layout_.at("fixed_size").get<size_t>(); }
  size_t size(const std::string& what) const { return layout_.at(what).at("size").get<size_t>(); }
  size_t contacts(const std::vector<double>& frame) const {
    return fixed_size() + count(frame, "n_objects") * size("object");
  }
  size_t joints(const std::vector<double>& frame) const {
    return contacts(frame) + count(frame, "n_listed") * size("contact");
  }
  size_t samples(const std::vector<double>& frame) const {
    return joints(frame) + count(frame, "n_joints") * size("joint");
  }
  static std::vector<double> part(const std::vector<double>& frame, size_t begin,
                                  const nlohmann::json& place) {
    const size_t from = begin + place.at(0).get<size_t>(), n = place.at(1).get<size_t>();
    std::vector<double> out;
    for (size_t i = 0; i < n; ++i) out.push_back(frame.at(from + i));
    return out;
  }

  nlohmann::json layout_;
};

}  // namespace haptic::test
