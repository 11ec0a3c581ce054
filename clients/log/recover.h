// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace haptic {

/// The result of copying a recording whose writer was killed, or whose chunks are damaged.
struct Recovered {
  bool had_end = false;                      // nothing was missing at the end
  std::map<std::string, uint64_t> messages;  // written, by topic
  uint64_t chunks = 0;                       // whole ones that were copied
  uint64_t attachments = 0;                  // copied, as the meshes that a viewer draws
  uint64_t rescued = 0;                      // messages read in the chunk that the file ends within
  uint64_t lost_bytes = 0;                   // of the file that could not be read
  std::vector<std::string> damaged;  // whole chunks and attachments that could not be read: why
};

/// Copies everything that can be read of one MCAP file into another, a complete file with an index:
/// schemas, channels, metadata, attachments, the messages of all whole chunks, and those at the
/// beginning of a chunk that is cut. A chunk that is damaged is left out. The copy has the metadata
/// record `recovered`. Messages stay as they are, byte for byte. Throws McapError if `from` is no
/// MCAP file or `to` cannot be written.
Recovered recover_log(const std::string& from, const std::string& to);

}  // namespace haptic
