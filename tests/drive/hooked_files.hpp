// SPDX-License-Identifier: Apache-2.0
// Calls of the system in this program that a test makes fail, or lets something happen before.
#pragma once

#include <functional>
#include <string>

namespace gnosphere::test {

/// Called before each call of flock(); a reason that it returns is that for which the call fails, 0 for none.
extern std::function<int()> beforeLock;
/// The same of rename() and mkdir(), called with the name that a file shall have, and with that of a new folder.
extern std::function<int(const std::string&)> beforeRename, beforeMkdir;

}  // namespace gnosphere::test
