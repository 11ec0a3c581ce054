// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "clients/desk/machine_facts.h"

namespace haptic {

/// The device at a node and the machine, a line each, for a report that is sent in. A serial number
/// is left out, and so is the path of a node that is not below /dev.
std::vector<std::string> report_facts(const MachineFacts& facts, const std::string& node);

/// The same of this machine, before the node is opened. Throws nothing: what is not known is said
/// to be so.
std::vector<std::string> report_facts(const std::string& node);

}  // namespace haptic
