// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>

namespace gnosphere {

/// Passes everything after the first byte to the reader that the first byte selects: g glTF text, b GLB, o OBJ, p PLY,
/// s STL, j sensor JSON, d Draco data, f a sensor file of any family, t firing times of Hesai, c a cloud (the next byte
/// selects the format), e effects, y a trajectory (likewise), m a table of materials, v a drive file, n the manifest of
/// a frame, x OpenDRIVE, k a cache of pipelines, r a tape of RGL's interface, w a file that gnosphere view reads (the
/// next byte selects which); other values are taken modulo 19. Ends the process if a reader throws anything but an
/// Error, or returns an invalid result. The fuzzer calls it with generated input, the tests with the corpus.
void fuzzReaders(std::span<const uint8_t> input);

/// Plays a tape: its calls as YAML, a byte 0, and its arrays. Calls that write files or publish are left out.
void fuzzTape(std::span<const uint8_t> input);

/// Shows a cloud, or the output of a drive one of whose files has this content.
void fuzzView(std::span<const uint8_t> input);

[[noreturn]] void complain(const char* what, const char* why);

}  // namespace gnosphere
