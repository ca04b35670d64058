// SPDX-License-Identifier: Apache-2.0
#include "drive/final_files.hpp"

#include <fstream>

#include "base/file.hpp"
#include "base/hash.hpp"

namespace gnosphere::drive {

void FinalFiles::write(const std::string& path, const std::string& bytes) {
  const std::filesystem::path place = placeIn(out_, pathOf(path));
  makeFolder(place.parent_path());
  AtomicFile file(place, partOf(place));
  file.write(bytes);
  file.commit();
  noted_.push_back({path, bytes.size(), hashOf(bytes)});
}

void FinalFiles::add(const std::string& path) {
  noted_.push_back({path, std::filesystem::file_size(*this / path), hashOfFile(*this / path)});
}

std::string hashOfFile(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  Hasher hasher;
  std::vector<char> block(size_t{1} << 20);
  while (stream.read(block.data(), static_cast<std::streamsize>(block.size())) || stream.gcount() > 0)
    hasher.add(block.data(), static_cast<size_t>(stream.gcount()));
  if (!stream.eof()) throw Error(ErrorCode::file, file.string() + ": cannot be read");
  return hasher.hex();
}

}  // namespace gnosphere::drive
