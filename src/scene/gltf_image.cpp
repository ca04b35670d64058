// SPDX-License-Identifier: Apache-2.0
// Reads the alpha images of cut-out materials from their base colour textures, and writes them.
#include <stb_image.h>
#include <stb_image_write.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>
#include <string_view>
#include <tuple>

#include "scene/gltf_accessor.hpp"
#include "scene/stb_memory.hpp"

namespace gnosphere {
namespace {

/// Limit on the pixels per side. The limit bounds the memory that a small file can make us allocate: 1 GiB to decode
/// one image.
constexpr int kMostPixels = 16384;

/// Lets stb_image take no more memory for an array than an image of this size may need: twice its pixels of up to 64
/// bits, because arrays double, and twice the packed data, for the same reason.
class StbLimit {
 public:
  StbLimit(size_t width, size_t height, size_t packed) {
    stbMemory = {16 * (width + 1) * height + 2 * packed + (size_t{1} << 16), false};
  }
  ~StbLimit() { stbMemory = {}; }
  StbLimit(const StbLimit&) = delete;
  StbLimit& operator=(const StbLimit&) = delete;
};

bool startsWith(Bytes bytes, std::string_view magic) {
  return bytes.size() >= magic.size() && std::equal(magic.begin(), magic.end(), bytes.begin(),
                                                    [](char a, uint8_t b) { return static_cast<uint8_t>(a) == b; });
}

AlphaImage::Wrap wrapOf(int mode) {
  return mode == TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE     ? AlphaImage::Wrap::clamp
         : mode == TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT ? AlphaImage::Wrap::mirror
                                                         : AlphaImage::Wrap::repeat;
}

/// Matrix of KHR_texture_transform: scale, then rotation, then offset. Rotations are counter-clockwise with v
/// downwards.
std::array<double, 6> transformOf(const tinygltf::Value& extension) {
  const auto number = [&](const char* key, int i, double otherwise) {
    return extension.Has(key) ? extension.Get(key).Get(i).GetNumberAsDouble() : otherwise;
  };
  const double turn = extension.Has("rotation") ? extension.Get("rotation").GetNumberAsDouble() : 0;
  const double c = std::cos(turn), s = std::sin(turn);
  const double scaleU = number("scale", 0, 1), scaleV = number("scale", 1, 1);
  return {c * scaleU, s * scaleV, number("offset", 0, 0), -s * scaleU, c * scaleV, number("offset", 1, 0)};
}

/// A texture of a cut-out material: its alpha, and whether its colours count.
struct Decoded {
  uint32_t alphaImage = kNoImage;  ///< kNoImage also if nothing is transparent, or the image cannot be read
  bool isWhite = false;            ///< whether it is read and all its colours are white, so that they change nothing
};

class ImageReader {
 public:
  ImageReader(const GltfFile& file, GltfArrays& arrays, const Source& source, Scene& scene, LeftOut& leftOut)
      : file_(file), arrays_(arrays), source_(source), scene_(scene), leftOut_(leftOut) {}

  /// Returns nothing if the material has no alpha image.
  std::optional<GltfTexture> read(size_t material);

 private:
  Decoded imageOf(const tinygltf::Texture& texture, const std::string& user);
  Decoded decode(int image, AlphaImage::Wrap wrapU, AlphaImage::Wrap wrapV, const std::string& user);
  Decoded decodePng(Bytes bytes, AlphaImage image, const std::string& who);

  const GltfFile& file_;
  GltfArrays& arrays_;
  const Source& source_;
  Scene& scene_;
  LeftOut& leftOut_;
  std::map<std::tuple<int, AlphaImage::Wrap, AlphaImage::Wrap>, Decoded> decoded_;
};

std::optional<GltfTexture> ImageReader::read(size_t index) {
  const tinygltf::Material& material = file_.model.materials[index];
  const tinygltf::TextureInfo& info = material.pbrMetallicRoughness.baseColorTexture;
  if (material.alphaMode != "MASK" || info.index < 0) return {};
  const std::string who = gltfLabel("material", index, material.name);
  if (static_cast<size_t>(info.index) >= file_.model.textures.size())
    source_.fail(who + ": texture " + std::to_string(info.index) + " does not exist");
  const Decoded image = imageOf(file_.model.textures[static_cast<size_t>(info.index)], who);
  scene_.materials[index].alphaImage = image.alphaImage;
  if (!image.isWhite) leftOut_.add(kTextureColours);
  if (image.alphaImage == kNoImage) return {};

  GltfTexture texture;
  texture.texCoord = info.texCoord;
  const auto transform = info.extensions.find("KHR_texture_transform");
  if (transform == info.extensions.end()) return texture;
  texture.transform = transformOf(transform->second);
  if (transform->second.Has("texCoord")) texture.texCoord = transform->second.Get("texCoord").GetNumberAsInt();
  return texture;
}

Decoded ImageReader::imageOf(const tinygltf::Texture& texture, const std::string& user) {
  AlphaImage::Wrap wrapU = AlphaImage::Wrap::repeat, wrapV = AlphaImage::Wrap::repeat;
  if (texture.sampler >= 0) {
    if (static_cast<size_t>(texture.sampler) >= file_.model.samplers.size())
      source_.fail(user + ": sampler " + std::to_string(texture.sampler) + " does not exist");
    const tinygltf::Sampler& sampler = file_.model.samplers[static_cast<size_t>(texture.sampler)];
    wrapU = wrapOf(sampler.wrapS);
    wrapV = wrapOf(sampler.wrapT);
  }
  const auto [found, isNew] = decoded_.emplace(std::tuple(texture.source, wrapU, wrapV), Decoded());
  if (isNew) found->second = decode(texture.source, wrapU, wrapV, user);
  return found->second;
}

/// Adds the alpha image of an image of the file, and counts images that cannot be read.
Decoded ImageReader::decode(int index, AlphaImage::Wrap wrapU, AlphaImage::Wrap wrapV, const std::string& user) {
  const auto unread = [&] {
    ++scene_.unreadImages;
    return Decoded();
  };
  if (index < 0) return unread();  // only an extension gives its source: KTX2, WebP
  const std::string who = user + ": image " + std::to_string(index);
  if (static_cast<size_t>(index) >= file_.images.size()) source_.fail(who + " does not exist");
  const GltfImage& from = file_.images[static_cast<size_t>(index)];
  FileBytes decoded;
  Bytes bytes;
  if (from.bufferView >= 0) {
    bytes = arrays_.view(from.bufferView, who);
  } else {
    try {
      bytes = arrays_.uriBytes(from.uri, who, decoded);
    } catch (const Error& error) {
      if (error.code() != ErrorCode::file) throw;
      return unread();
    }
  }
  if (startsWith(bytes, "\xff\xd8\xff")) return {};  // JPEG has no alpha
  if (!startsWith(bytes, "\x89PNG\r\n\x1a\n")) return unread();
  return decodePng(bytes, {0, 0, {}, wrapU, wrapV}, who);
}

Decoded ImageReader::decodePng(Bytes bytes, AlphaImage image, const std::string& who) {
  const auto fail = [&](const std::string& why) { source_.fail(who + " is not a valid PNG file: " + why); };
  if (bytes.size() > std::numeric_limits<int>::max()) fail("it is larger than 2 GiB");
  const int size = static_cast<int>(bytes.size());
  int width = 0, height = 0, channels = 0;
  if (!stbi_info_from_memory(bytes.data(), size, &width, &height, &channels)) fail(stbi_failure_reason());
  if (width < 1 || height < 1 || width > kMostPixels || height > kMostPixels)
    source_.fail(who + " has " + std::to_string(width) + " x " + std::to_string(height) + " pixels; the limit is " +
                 std::to_string(kMostPixels) + " per side");
  const size_t pixels = static_cast<size_t>(width) * static_cast<size_t>(height);
  arrays_.charge(pixels, 4, who);
  const StbLimit limit(static_cast<size_t>(width), static_cast<size_t>(height), bytes.size());
  const std::unique_ptr<stbi_uc, void (*)(void*)> colours(
      stbi_load_from_memory(bytes.data(), size, &width, &height, &channels, 4), &stbi_image_free);
  if (!colours && stbMemory.wasRefused)
    fail("its data unpack to far more bytes than its " + std::to_string(width) + " x " + std::to_string(height) +
         " pixels need");
  if (!colours) fail(stbi_failure_reason());
  image.width = static_cast<uint32_t>(width);
  image.height = static_cast<uint32_t>(height);
  image.alpha.resize(pixels);
  Decoded decoded = {kNoImage, true};
  for (size_t i = 0; i < pixels; ++i) {
    const stbi_uc* const pixel = colours.get() + 4 * i;
    image.alpha[i] = pixel[3];
    decoded.isWhite = decoded.isWhite && pixel[0] == 255 && pixel[1] == 255 && pixel[2] == 255;
  }
  if (std::all_of(image.alpha.begin(), image.alpha.end(), [](uint8_t alpha) { return alpha == 255; })) return decoded;
  decoded.alphaImage = static_cast<uint32_t>(scene_.alphaImages.size());
  scene_.alphaImages.push_back(std::move(image));
  return decoded;
}

}  // namespace

std::vector<uint8_t> pngOf(const AlphaImage& image) {
  if (image.width > kMostPixels || image.height > kMostPixels)
    throw Error(ErrorCode::invalidArgument, "an alpha image has " + std::to_string(image.width) + " x " +
                                                std::to_string(image.height) + " pixels; the limit of files is " +
                                                std::to_string(kMostPixels) + " per side");
  std::vector<uint8_t> pixels(2 * image.alpha.size(), 255);
  for (size_t i = 0; i < image.alpha.size(); ++i) pixels[2 * i + 1] = image.alpha[i];
  std::vector<uint8_t> png;
  const auto append = [](void* to, void* data, int size) {
    const auto* bytes = static_cast<const uint8_t*>(data);
    static_cast<std::vector<uint8_t>*>(to)->insert(static_cast<std::vector<uint8_t>*>(to)->end(), bytes, bytes + size);
  };
  const int width = static_cast<int>(image.width), height = static_cast<int>(image.height);
  if (!stbi_write_png_to_func(append, &png, width, height, 2, pixels.data(), 2 * width)) throw std::bad_alloc();
  return png;
}

std::vector<std::optional<GltfTexture>> readGltfImages(const GltfFile& file, GltfArrays& arrays, const Source& source,
                                                       Scene& scene, LeftOut& leftOut) {
  ImageReader reader(file, arrays, source, scene, leftOut);
  std::vector<std::optional<GltfTexture>> textures;
  for (size_t i = 0; i < file.model.materials.size(); ++i) textures.push_back(reader.read(i));
  return textures;
}

}  // namespace gnosphere
