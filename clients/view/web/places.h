// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <string>

namespace haptic {

/// The person that a connection is counted for: the user, where the other end is a process of this
/// machine; else its address. Of IPv6 that is the network, the first 64 bits: one machine may use
/// them all.
std::string person_behind(int socket);

/// Places for connections, so many in all and fewer for one person, so that nobody holds all.
class Places {
 public:
  Places(size_t most, size_t most_of_one) : most_(most), most_of_one_(most_of_one) {}
  Places(const Places&) = delete;

  /// A place until its last copy is gone, which is before this ends; null: there is none.
  std::shared_ptr<void> take(const std::string& person);
  size_t taken() const { return taken_; }

 private:
  void leave(const std::string& person);

  const size_t most_, most_of_one_;
  size_t taken_ = 0;
  std::map<std::string, size_t> of_;
};

}  // namespace haptic
