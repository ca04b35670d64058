// SPDX-License-Identifier: Apache-2.0
#include "base/os.hpp"
#include "command_line.hpp"

int main(int argc, char** argv) {
  gnosphere::os::prepareProgram(argc, argv);
  return gnosphere::cli::runCommandLine(argc, argv);
}
