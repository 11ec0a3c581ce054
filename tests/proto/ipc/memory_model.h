// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <vector>

namespace haptic::test {

/// Enumerates every outcome that the C++ memory model allows for one reader and one writer,
/// independent of this processor.
///
/// A location keeps every value ever stored in it. A thread may load any that is not older than one
/// it knows of; a release store publishes what its thread knows, an acquire load learns it (views,
/// as in Kang et al., "A promising semantics for relaxed-memory concurrency", POPL 2017, without
/// promises: no store moves before an earlier load). The writer loads nothing that others store, so
/// it can run to its end first; readers store nothing, so they cannot see each other and one stands
/// for all. What remains to enumerate is the value that each load of the reader returns.
class MemoryModel {
 public:
  /// The effect of a defect on one access.
  enum class Change { kNone, kRelaxed, kDropped };
  using Defect = Change (*)(size_t location, bool is_store, uint64_t value);

  explicit MemoryModel(Defect defect = nullptr) : defect_(defect) { active() = this; }
  ~MemoryModel() { active() = nullptr; }
  MemoryModel(const MemoryModel&) = delete;

  static MemoryModel*& active() {
    static MemoryModel* model = nullptr;
    return model;
  }

  /// The writer dies after that many stores; later ones are dropped.
  void kill_writer_after(uint64_t stores) { stores_left_ = stores; }
  uint64_t n_stores() const { return n_stores_; }

  /// Runs the reader once for each combination of loaded values, as long as it returns true;
  /// returns the number of runs. `writer_is_gone`: the kernel has told the reader that the writer
  /// is dead, so it sees all stores.
  template <typename Reader>
  uint64_t explore(bool writer_is_gone, Reader reader) {
    uint64_t outcomes = 0;
    choices_.clear();
    is_reader_ = true;
    bool goes_on = true;
    while (goes_on) {
      reader_view_ = writer_is_gone ? writer_view_ : View{};
      depth_ = 0;
      goes_on = reader() && next_outcome();
      ++outcomes;
    }
    is_reader_ = false;
    return outcomes;
  }

  size_t add_location(uint64_t value) {
    if (locations_.size() == kMaxLocations) throw std::length_error("raise kMaxLocations");
    locations_.push_back({Message{value, {}}});
    return locations_.size() - 1;
  }

  void store(size_t location, uint64_t value, std::memory_order order) {
    if (stores_left_ == 0) return;
    --stores_left_;
    ++n_stores_;
    const Change change = change_of(location, true, value);
    if (change == Change::kDropped) return;
    if (change == Change::kRelaxed) order = std::memory_order_relaxed;
    auto& messages = locations_[location];
    writer_view_[location] = static_cast<uint8_t>(messages.size());
    // a relaxed store publishes only itself
    View told{};
    told[location] = writer_view_[location];
    messages.push_back({value, order == std::memory_order_release ? writer_view_ : told});
  }

  uint64_t load(size_t location, std::memory_order order) {
    const auto& messages = locations_[location];
    View& view = is_reader_ ? reader_view_ : writer_view_;
    const size_t oldest = view[location];
    const size_t taken = oldest + (is_reader_ ? choose(messages.size() - oldest) : 0);
    view[location] = static_cast<uint8_t>(taken);
    const bool is_weakened = change_of(location, false, 0) == Change::kRelaxed;
    if (order == std::memory_order_acquire && !is_weakened) {
      for (size_t i = 0; i < kMaxLocations; ++i) {
        view[i] = std::max(view[i], messages[taken].view[i]);
      }
    }
    return messages[taken].value;
  }

 private:
  static constexpr size_t kMaxLocations = 32;
  /// Per location, the newest message known to a thread.
  using View = std::array<uint8_t, kMaxLocations>;
  struct Message {
    uint64_t value;
    View view;
  };
  struct Choice {
    size_t taken, options;
  };

  Change change_of(size_t location, bool is_store, uint64_t value) const {
    return defect_ == nullptr ? Change::kNone : defect_(location, is_store, value);
  }

  size_t choose(size_t options) {
    if (depth_ == choices_.size()) choices_.push_back({0, options});
    return choices_[depth_++].taken;
  }

  /// Depth first: advances the last choice that has another option.
  bool next_outcome() {
    while (!choices_.empty() && choices_.back().taken + 1 == choices_.back().options) {
      choices_.pop_back();
    }
    if (choices_.empty()) return false;
    ++choices_.back().taken;
    return true;
  }

  Defect defect_;
  std::vector<std::vector<Message>> locations_;
  View writer_view_{}, reader_view_{};
  std::vector<Choice> choices_;
  size_t depth_ = 0;
  uint64_t stores_left_ = ~uint64_t{0};
  uint64_t n_stores_ = 0;
  bool is_reader_ = false;
};

/// A std::atomic<uint64_t> in the active MemoryModel.
template <typename T>
class ModelAtomic {
  static_assert(sizeof(T) == 8);

 public:
  static constexpr bool is_always_lock_free = true;
  ModelAtomic(T value = 0) : location_(MemoryModel::active()->add_location(value)) {}
  ModelAtomic(const ModelAtomic&) = delete;
  void store(T value, std::memory_order order) {
    MemoryModel::active()->store(location_, value, order);
  }
  T load(std::memory_order order) const { return MemoryModel::active()->load(location_, order); }

 private:
  size_t location_;
};

}  // namespace haptic::test
