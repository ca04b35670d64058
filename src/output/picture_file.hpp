// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "base/text.hpp"
#include "gnosphere/error.hpp"

namespace gnosphere {

/// Throws Error(invalidArgument) if the name of a picture, which is a PNG, says otherwise.
inline void checkPictureFile(const std::filesystem::path& file) {
  if (lower(file.extension().string()) != ".png")
    throw Error(ErrorCode::invalidArgument, file.string() + " must end in .png");
}

}  // namespace gnosphere
