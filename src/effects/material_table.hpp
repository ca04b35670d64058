// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "gnosphere/effects.hpp"

namespace gnosphere {

/// Throws Error(invalidArgument) that names the material if a value is NaN or too large; negative ones are not stated.
void validate(const MaterialTable& table);

}  // namespace gnosphere
