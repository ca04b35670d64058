// SPDX-License-Identifier: Apache-2.0
// The table of cloud file formats, and the names and comments in the files.
#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "gnosphere/layout.hpp"
#include "gnosphere/scan.hpp"

namespace gnosphere {

struct CloudRows;
struct CloudTable;

/// A format of cloud files.
struct CloudFormat {
  enum class Text { never, ifAsked, always };  ///< whether rows are lines of text or binary

  const char* ending;  ///< of the file's name, in small letters
  const char* name;    ///< empty if the ending says it
  const char* doc;
  Text text;
  char separator;  ///< between the values of a line of text
  /// Returns the bytes before the rows; null if there are none.
  std::string (*header)(const CloudRows& rows, bool ascii);
  /// Returns the layout of the rows, which then are the scan's returns alone; null if the caller chooses the fields.
  RecordLayout (*layout)(const Scan& scan);
  /// Reads the bytes of a file; null if it does not say which beams its points are of.
  CloudTable (*read)(std::string bytes, const std::string& source);
};

std::span<const CloudFormat> cloudFormats();
/// Returns the format for a file's ending. Throws Error(invalidArgument) with the known endings; `readable`: those of
/// the formats that readCloud() reads.
const CloudFormat& cloudFormat(const std::filesystem::path& file, bool readable = false);
/// Returns ".pcd, .ply, .bin (KITTI), .npy or .csv" with this word before the last one; `readable`: of the formats that
/// readCloud() reads.
std::string cloudEndings(const char* word, bool readable = false);

/// Names in PLY files that differ from ours, because readers of PLY expect them.
struct PlyName {
  const char* name;
  const char* inPly;
};
inline constexpr PlyName kPlyNames[] = {{"normal_x", "nx"}, {"normal_y", "ny"}, {"normal_z", "nz"}};

/// Comments of PCD and PLY files. A cloud that keeps only some beams states the grid they come from, and the number of
/// returns per beam if it is more than one.
inline constexpr const char* kGridComment = "gnosphere columns %u channels %u";
inline constexpr const char* kGridCommentReturns = "gnosphere columns %u channels %u returns %u";
/// Ends the numbers of the comment of a cloud whose points are in the frames of their columns.
inline constexpr const char* kSkewed = " skewed";

}  // namespace gnosphere
