// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <unistd.h>

#include <initializer_list>

#include "command_line.hpp"

namespace {

// A file that the program or a driver opens must not get the number of a standard stream that is closed: what is
// printed would be written to that file. A stream that was closed still fails.
void reserveStandardStreams() {
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    if (fcntl(stream, F_GETFD) == -1) open("/dev/null", stream == STDIN_FILENO ? O_WRONLY : O_RDONLY);
}

}  // namespace

int main(int argc, char** argv) {
  reserveStandardStreams();
  return gnosphere::cli::runCommandLine(argc, argv);
}
