// SPDX-License-Identifier: Apache-2.0
// A Batch as Python holds it.
#pragma once

#include "scan.hpp"

namespace gnosphere::python {

/// As SharedScan: a Batch that an array or a running call shares is never written again.
using SharedBatch = Shared<Batch>;

}  // namespace gnosphere::python
