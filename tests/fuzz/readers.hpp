// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>

namespace gnosphere {

/// Gives everything after the first byte to the reader that the first byte chooses: g glTF text, b GLB, o OBJ, p PLY,
/// s STL, j sensor JSON, d Draco data, anything else modulo 7. Ends the process if a reader throws anything but an
/// Error, or returns what is not valid. The fuzzer calls it with what it invents, the tests with the corpus.
void fuzzReaders(std::span<const uint8_t> input);

}  // namespace gnosphere
