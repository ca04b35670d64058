// SPDX-License-Identifier: Apache-2.0
// Files whose positions are far from their origin in single precision, as georeferenced ones may be.
#pragma once

#include <filesystem>
#include <string>

#include "gnosphere/scene.hpp"

namespace gnosphere {

/// Returns a sentence about the steps of the positions of a file's scene, as "its positions are in single precision,
/// which has steps of 0.5 m ...". The text is empty if the steps are at most a millimetre, or if the file states
/// doubles that floats hold exactly.
std::string coarsePositions(const std::filesystem::path& file, const Scene& scene);

}  // namespace gnosphere
