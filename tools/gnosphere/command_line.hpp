// SPDX-License-Identifier: Apache-2.0
// The command line of the program `gnosphere`, which main.cpp and other programs call.
#pragma once

namespace gnosphere::cli {

/// Runs the command line `argv`. Returns the exit status: 0 for success, 1 if the work failed, 2 for a wrong call;
/// errors are one line on stderr.
int runCommandLine(int argc, char** argv);

}  // namespace gnosphere::cli
