// SPDX-License-Identifier: Apache-2.0
// The kernels of a scan: the translated shaders, compiled as CUDA, or as C++ for tests.
#pragma once

#ifdef __CUDACC__  // nvcc warns that it ignores some annotations of GLM, which shared.h includes
#pragma nv_diagnostic push
#pragma nv_diag_suppress 20012
#endif
#include "common/arrays.h"
#include "common/shared.h"
#include "pipeline/kernels.hpp"
#ifdef __CUDACC__
#pragma nv_diagnostic pop
#endif

namespace gnosphere::cuda {

/// The arguments of a kernel.
struct Job {
  gpu::Addresses addresses;
  gpu::Pass pass;
  Options options;
};

/// Launches the given number of workgroups; the next launch sees what this one has written. There are two
/// implementations: `parity` compiles without fused multiply-add, `fast` with it.
namespace parity {
void launch(Kernel kernel, const Job& job, uint32_t workgroupsX, uint32_t workgroupsY);
}
namespace fast {
void launch(Kernel kernel, const Job& job, uint32_t workgroupsX, uint32_t workgroupsY);
}

}  // namespace gnosphere::cuda
