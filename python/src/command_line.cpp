// SPDX-License-Identifier: Apache-2.0
#include "command_line.hpp"

#include "bind.hpp"

namespace gnosphere::python {

void bindCommandLine(nb::module_& m) {
  m.def(
      "_run_command_line",
      [](std::vector<std::string> words) {
        std::vector<char*> pointers;
        for (std::string& word : words) pointers.push_back(word.data());
        pointers.push_back(nullptr);
        const ReleasedGil released;
        return cli::runCommandLine(static_cast<int>(words.size()), pointers.data());
      },
      "words"_a, "Runs the command line of these words, the program's name first; returns its exit status.");
}

}  // namespace gnosphere::python
