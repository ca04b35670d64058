// SPDX-License-Identifier: Apache-2.0
#include "output/cloud_format.hpp"

#include "base/text.hpp"
#include "gnosphere/error.hpp"

namespace gnosphere {

CloudFormat cloudFormat(const std::filesystem::path& file) {
  const std::string ending = lower(file.extension().string());
  if (ending == ".pcd") return CloudFormat::pcd;
  if (ending == ".ply") return CloudFormat::ply;
  if (ending == ".bin") return CloudFormat::kitti;
  if (ending == ".npy") return CloudFormat::npy;
  if (ending == ".csv") return CloudFormat::csv;
  throw Error(ErrorCode::invalidArgument, file.string() + ": the ending says which kind of cloud it is; known are " +
                                              ".pcd, .ply, .bin (KITTI), .npy and .csv");
}

}  // namespace gnosphere
