// SPDX-License-Identifier: Apache-2.0
#include "output/cloud_format.hpp"

#include <vector>

#include "base/text.hpp"
#include "gnosphere/error.hpp"
#include "output/cloud_bytes.hpp"
#include "output/cloud_rows.hpp"
#include "output/cloud_table.hpp"

namespace gnosphere {
namespace {

using Text = CloudFormat::Text;
constexpr CloudFormat kFormats[] = {
    {".pcd", "", "PCD, organised unless compact", Text::ifAsked, ' ', pcdHeader, nullptr, readPcd},
    {".ply", "", "PLY", Text::ifAsked, ' ', plyHeader, nullptr, readPly},
    {".bin", "KITTI", "x y z and the intensity, or 0; returns only", Text::never, 0, nullptr, kittiLayout, nullptr},
    {".npy", "", "a structured array of NumPy", Text::never, 0, npyHeader, nullptr, readNpy},
    {".csv", "", "lines of text, the first with the names", Text::always, ',', csvHeader, nullptr, readCsv},
};

}  // namespace

std::span<const CloudFormat> cloudFormats() {
  return kFormats;
}

const CloudFormat& cloudFormat(const std::filesystem::path& file, bool readable) {
  const std::string ending = lower(file.extension().string());
  for (const CloudFormat& format : kFormats)
    if (ending == format.ending) return format;
  throw Error(ErrorCode::invalidArgument, file.string() + ": the ending says which kind of cloud it is; known are " +
                                              cloudEndings("and", readable));
}

std::string cloudEndings(const char* word, bool readable) {
  std::vector<std::string> endings;
  for (const CloudFormat& format : kFormats)
    if (!readable || format.read)
      endings.push_back(format.ending + (*format.name ? " (" + std::string(format.name) + ")" : std::string()));
  std::string text = endings.front();
  for (size_t i = 1; i < endings.size(); ++i)
    text += (i + 1 < endings.size() ? ", " : std::string(" ") + word + " ") + endings[i];
  return text;
}

}  // namespace gnosphere
