// SPDX-License-Identifier: Apache-2.0
#include "scene/gltf_accessor.hpp"

#include <meshoptimizer.h>

#include <algorithm>
#include <cstring>
#include <limits>

#include "base/path.hpp"

namespace gnosphere {
namespace {

size_t componentSize(int componentType) {
  switch (componentType) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE: return 1;
    case TINYGLTF_COMPONENT_TYPE_SHORT:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT: return 2;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
    case TINYGLTF_COMPONENT_TYPE_FLOAT: return 4;
  }
  return 0;
}

bool isUnsigned(int componentType) {
  return componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE ||
         componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT ||
         componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
}

template <typename T>
T loadAs(const uint8_t* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof value);
  return value;
}

/// Converts normalised integers as in glTF 2.0, section 3.11.
template <typename T>
double decoded(const uint8_t* bytes, bool normalized) {
  const double value = loadAs<T>(bytes);
  return normalized ? std::max(value / std::numeric_limits<T>::max(), -1.0) : value;
}

double component(const uint8_t* bytes, int componentType, bool normalized) {
  switch (componentType) {
    case TINYGLTF_COMPONENT_TYPE_BYTE: return decoded<int8_t>(bytes, normalized);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE: return decoded<uint8_t>(bytes, normalized);
    case TINYGLTF_COMPONENT_TYPE_SHORT: return decoded<int16_t>(bytes, normalized);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT: return decoded<uint16_t>(bytes, normalized);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT: return decoded<uint32_t>(bytes, normalized);
    default: return loadAs<float>(bytes);
  }
}

std::string decodedUri(const std::string& uri) {
  const auto digit = [](char c) {
    return c >= '0' && c <= '9'   ? c - '0'
           : c >= 'a' && c <= 'f' ? c - 'a' + 10
           : c >= 'A' && c <= 'F' ? c - 'A' + 10
                                  : -1;
  };
  std::string path;
  for (size_t i = 0; i < uri.size(); ++i) {
    if (uri[i] == '%' && i + 2 < uri.size() && digit(uri[i + 1]) >= 0 && digit(uri[i + 2]) >= 0) {
      path += static_cast<char>(digit(uri[i + 1]) * 16 + digit(uri[i + 2]));
      i += 2;
    } else {
      path += uri[i];
    }
  }
  return path;
}

/// Decodes Base64 up to its padding. A result of size 0 for non-empty `text` means that it has an invalid character.
FileBytes decodeBase64(std::string_view text) {
  while (!text.empty() && text.back() == '=') text.remove_suffix(1);
  FileBytes bytes;
  bytes.data = std::make_unique_for_overwrite<uint8_t[]>(text.size() * 3 / 4 + 1);
  uint32_t bits = 0;
  int bitCount = 0;
  for (char c : text) {
    const int value = c >= 'A' && c <= 'Z'   ? c - 'A'
                      : c >= 'a' && c <= 'z' ? c - 'a' + 26
                      : c >= '0' && c <= '9' ? c - '0' + 52
                      : c == '+' || c == '-' ? 62
                      : c == '/' || c == '_' ? 63
                                             : -1;
    if (value < 0) return {};
    bits = bits << 6 | static_cast<uint32_t>(value);
    bitCount += 6;
    if (bitCount >= 8) bytes.data[bytes.size++] = static_cast<uint8_t>(bits >> (bitCount -= 8));
  }
  return bytes;
}

}  // namespace

GltfArrays::GltfArrays(GltfFile& file, Bytes bytes, const Source& source)
    : file_(file), source_(source), inputBytes_(bytes.size()) {}

void GltfArrays::charge(uint64_t count, uint64_t bytesEach, const std::string& user) {
  const uint64_t limit = (uint64_t{256} << 20) + 256 * inputBytes_;
  if (count > (limit - charged_) / bytesEach)
    source_.fail(user + ": " + std::to_string(count) + " elements are more than a file of " +
                 std::to_string(inputBytes_) + " bytes may unpack to");
  charged_ += count * bytesEach;
}

void GltfArrays::load(GltfBuffer& buffer, const std::string& user) {
  const std::string name = "buffer " + std::to_string(&buffer - file_.buffers.data());
  if (buffer.uri.empty()) source_.fail(user + ": " + name + " has no uri and the file has no binary chunk for it");
  try {
    buffer.bytes = uriBytes(buffer.uri, user + ": " + name, buffer.owned);
  } catch (const Error& error) {
    if (error.code() == ErrorCode::format) throw;
    throw Error(error.code(), source_.name + ": " + user + " needs " + name + ": " + error.what());
  }
  buffer.uri = {};
  buffer.loaded = true;
}

Bytes GltfArrays::uriBytes(const std::string& uri, const std::string& user, FileBytes& decoded) {
  if (!uri.starts_with("data:")) {
    const std::u8string normal = pathOf(decodedUri(uri)).lexically_normal().generic_u8string();
    const std::string path(normal.begin(), normal.end());
    const auto known = siblings_.find(path);
    if (known != siblings_.end()) return known->second;
    FileBytes bytes = source_.sibling(path);
    inputBytes_ += bytes.size;
    return siblings_.emplace(path, std::move(bytes)).first->second;
  }
  const size_t comma = uri.find(',');
  if (comma == std::string::npos || !std::string_view(uri).substr(0, comma).ends_with(";base64"))
    source_.fail(user + " has a data URI that is not base64");
  decoded = decodeBase64(std::string_view(uri).substr(comma + 1));
  if (decoded.size == 0 && comma + 1 < uri.size()) source_.fail(user + " has a data URI whose base64 is invalid");
  return decoded;
}

Bytes GltfArrays::bufferRange(int index, size_t byteOffset, size_t byteLength, const std::string& user) {
  const std::string name = "buffer " + std::to_string(index);
  if (index < 0 || static_cast<size_t>(index) >= file_.buffers.size())
    source_.fail(user + ": " + name + " does not exist");
  GltfBuffer& buffer = file_.buffers[static_cast<size_t>(index)];
  if (!buffer.loaded) load(buffer, user);
  if (buffer.bytes.size() < buffer.byteLength)
    source_.fail(user + ": " + name + " is cut off: it should have " + std::to_string(buffer.byteLength) +
                 " bytes and has " + std::to_string(buffer.bytes.size()));
  if (byteOffset > buffer.byteLength || byteLength > buffer.byteLength - byteOffset)
    source_.fail(user + ": a bufferView ends past the " + std::to_string(buffer.byteLength) + " bytes of " + name);
  return buffer.bytes.subspan(byteOffset, byteLength);
}

Bytes GltfArrays::view(int index, const std::string& user) {
  if (index < 0 || static_cast<size_t>(index) >= file_.model.bufferViews.size())
    source_.fail(user + ": bufferView " + std::to_string(index) + " does not exist");
  const tinygltf::BufferView& view = file_.model.bufferViews[static_cast<size_t>(index)];
  const auto compression = view.extensions.find("EXT_meshopt_compression");
  if (compression != view.extensions.end()) return decompress(index, compression->second, user);
  return bufferRange(view.buffer, view.byteOffset, view.byteLength, user + ", bufferView " + std::to_string(index));
}

namespace {

/// An array of EXT_meshopt_compression: `count` elements of `stride` bytes.
struct MeshoptArray {
  std::string mode, filter;
  size_t count = 0, stride = 0;

  MeshoptArray(const tinygltf::Value& extension) {
    const auto text = [&](const char* key, const char* otherwise) {
      return extension.Has(key) ? extension.Get(key).Get<std::string>() : std::string(otherwise);
    };
    mode = text("mode", "");
    filter = text("filter", "NONE");
    count = sizeIn(extension, "count");
    stride = sizeIn(extension, "byteStride");
  }

  static size_t sizeIn(const tinygltf::Value& extension, const char* key) {
    return extension.Has(key) ? static_cast<size_t>(extension.Get(key).GetNumberAsInt()) : size_t{0};
  }

  /// Whether the extension has arrays of this mode and stride, and the filter fits them. The conditions are those that
  /// the decoders assert.
  bool hasValidMode() const {
    return (mode == "ATTRIBUTES" && stride % 4 == 0 && stride > 0 && stride <= 256) ||
           (mode == "TRIANGLES" && (stride == 2 || stride == 4) && count % 3 == 0) ||
           (mode == "INDICES" && (stride == 2 || stride == 4));
  }
  bool hasValidFilter() const {
    if (filter == "NONE") return true;
    return mode == "ATTRIBUTES" && ((filter == "OCTAHEDRAL" && (stride == 4 || stride == 8)) ||
                                    (filter == "QUATERNION" && stride == 8) || filter == "EXPONENTIAL");
  }

  /// Writes the elements to `to`. Returns whether the packed data are valid.
  bool decode(uint8_t* to, Bytes packed) const {
    int (*decoder)(void*, size_t, size_t, const unsigned char*, size_t) = meshopt_decodeVertexBuffer;
    if (mode == "TRIANGLES") decoder = meshopt_decodeIndexBuffer;
    if (mode == "INDICES") decoder = meshopt_decodeIndexSequence;
    if (decoder(to, count, stride, packed.data(), packed.size()) != 0) return false;
    if (filter == "OCTAHEDRAL") meshopt_decodeFilterOct(to, count, stride);
    if (filter == "QUATERNION") meshopt_decodeFilterQuat(to, count, stride);
    if (filter == "EXPONENTIAL") meshopt_decodeFilterExp(to, count, stride);
    return true;
  }
};

}  // namespace

Bytes GltfArrays::decompress(int index, const tinygltf::Value& extension, const std::string& user) {
  if (const auto done = decompressed_.find(index); done != decompressed_.end()) return done->second;
  const std::string who = user + ", bufferView " + std::to_string(index) + " (meshopt)";
  const MeshoptArray array(extension);
  const auto number = [&](const char* key) { return MeshoptArray::sizeIn(extension, key); };
  const Bytes packed = bufferRange(static_cast<int>(number("buffer")), number("byteOffset"), number("byteLength"), who);
  if (array.count * array.stride != file_.model.bufferViews[static_cast<size_t>(index)].byteLength)
    source_.fail(who + ": count times byteStride is not its byteLength");
  charge(array.count, std::max<size_t>(array.stride, 1), who);
  if (!array.hasValidMode())
    source_.fail(who + ": mode " + inQuotes(array.mode) + " with " + std::to_string(array.count) + " elements of " +
                 std::to_string(array.stride) + " bytes is not one of the extension's");
  if (!array.hasValidFilter())
    source_.fail(who + ": filter " + inQuotes(array.filter) + " does not fit elements of " +
                 std::to_string(array.stride) + " bytes");

  FileBytes bytes;
  bytes.size = array.count * array.stride;
  bytes.data = std::make_unique<uint8_t[]>(bytes.size);
  if (!array.decode(bytes.data.get(), packed)) source_.fail(who + ": its data is invalid");
  return decompressed_.emplace(index, std::move(bytes)).first->second;
}

const uint8_t* GltfArrays::elements(int index, size_t byteOffset, size_t count, size_t size, size_t stride,
                                    const std::string& user) {
  const Bytes bytes = view(index, user);
  const size_t available = byteOffset <= bytes.size() ? bytes.size() - byteOffset : 0;
  if (count > 0 && (available < size || count - 1 > (available - size) / stride))
    source_.fail(user + ": " + std::to_string(count) + " elements of " + std::to_string(size) + " bytes from byte " +
                 std::to_string(byteOffset) + " end past bufferView " + std::to_string(index) + " of " +
                 std::to_string(bytes.size()) + " bytes");
  return bytes.data() + (count > 0 ? byteOffset : 0);
}

GltfArrays::Layout GltfArrays::layout(int index, const std::string& user) {
  const std::string who = user + ": accessor " + std::to_string(index);
  if (index < 0 || static_cast<size_t>(index) >= file_.model.accessors.size()) source_.fail(who + " does not exist");
  const tinygltf::Accessor& accessor = file_.model.accessors[static_cast<size_t>(index)];
  Layout layout;
  layout.count = accessor.count;
  layout.components = accessor.type == TINYGLTF_TYPE_SCALAR ? 1
                      : accessor.type == TINYGLTF_TYPE_VEC2 ? 2
                      : accessor.type == TINYGLTF_TYPE_VEC3 ? 3
                      : accessor.type == TINYGLTF_TYPE_VEC4 ? 4
                      : accessor.type == TINYGLTF_TYPE_MAT4 ? 16
                                                            : 0;
  layout.componentType = accessor.componentType;
  layout.normalized = accessor.normalized;
  const size_t size = layout.components * componentSize(layout.componentType);
  if (size == 0) source_.fail(who + " has a type that geometry cannot have");
  if (layout.count > std::numeric_limits<uint32_t>::max())
    source_.fail(who + " has " + std::to_string(layout.count) + " elements; the limit is 4294967295");
  layout.stride = size;
  if (accessor.bufferView < 0) return layout;
  if (static_cast<size_t>(accessor.bufferView) < file_.model.bufferViews.size()) {
    const size_t stride = file_.model.bufferViews[static_cast<size_t>(accessor.bufferView)].byteStride;
    if (stride != 0 && stride < size)
      source_.fail(who + ": the byteStride of " + std::to_string(stride) + " is less than its elements of " +
                   std::to_string(size) + " bytes");
    if (stride != 0) layout.stride = stride;
  }
  layout.first = elements(accessor.bufferView, accessor.byteOffset, layout.count, size, layout.stride, who);
  return layout;
}

size_t GltfArrays::count(int accessor, const std::string& user) {
  return layout(accessor, user).count;
}

template <typename Set>
void GltfArrays::forEachValue(int index, const Layout& layout, const std::string& user, Set&& set) {
  const size_t width = componentSize(layout.componentType);
  const auto visit = [&](size_t element, const uint8_t* bytes) {
    for (size_t c = 0; c < layout.components; ++c)
      set(element, c, component(bytes + c * width, layout.componentType, layout.normalized));
  };
  if (layout.first != nullptr)
    for (size_t i = 0; i < layout.count; ++i) visit(i, layout.first + i * layout.stride);

  const auto& sparse = file_.model.accessors[static_cast<size_t>(index)].sparse;
  if (!sparse.isSparse) return;
  const std::string who = user + ": accessor " + std::to_string(index) + " (sparse)";
  const int indexType = sparse.indices.componentType;
  if (!isUnsigned(indexType)) source_.fail(who + ": its indices are not unsigned integers");
  const size_t changes = static_cast<size_t>(sparse.count);
  const size_t indexSize = componentSize(indexType), size = layout.components * width;
  const uint8_t* indices = elements(sparse.indices.bufferView, static_cast<size_t>(sparse.indices.byteOffset), changes,
                                    indexSize, indexSize, who + ", indices");
  const uint8_t* values = elements(sparse.values.bufferView, static_cast<size_t>(sparse.values.byteOffset), changes,
                                   size, size, who + ", values");
  for (size_t i = 0; i < changes; ++i) {
    const auto element = static_cast<size_t>(component(indices + i * indexSize, indexType, false));
    if (element >= layout.count)
      source_.fail(who + ": index " + std::to_string(element) + " is out of range, there are " +
                   std::to_string(layout.count));
    visit(element, values + i * size);
  }
}

std::vector<float> GltfArrays::floats(int index, size_t components, const char* what, const std::string& user) {
  const Layout layout = this->layout(index, user);
  if (layout.components != components)
    source_.fail(user + ": accessor " + std::to_string(index) + " of " + what + " is not VEC" +
                 std::to_string(components));
  const size_t size = components * sizeof(float);
  charge(layout.count, size, user);
  std::vector<float> values(layout.count * components);
  const bool plain = layout.componentType == TINYGLTF_COMPONENT_TYPE_FLOAT &&
                     !file_.model.accessors[static_cast<size_t>(index)].sparse.isSparse;
  if (!plain)
    forEachValue(index, layout, user,
                 [&](size_t i, size_t c, double value) { values[components * i + c] = static_cast<float>(value); });
  else if (layout.first != nullptr && layout.stride == size && layout.count > 0)
    std::memcpy(values.data(), layout.first, layout.count * size);
  else if (layout.first != nullptr)
    for (size_t i = 0; i < layout.count; ++i)
      std::memcpy(&values[components * i], layout.first + i * layout.stride, size);
  return values;
}

const std::vector<float>& GltfArrays::keptFloats(int index, size_t components, const char* what,
                                                 const std::string& user) {
  const auto [found, isNew] = kept_.try_emplace({index, components});
  if (isNew) found->second = floats(index, components, what, user);
  return found->second;
}

void GltfArrays::appendIndices(int index, const std::string& user, std::vector<uint32_t>& indices) {
  const Layout layout = this->layout(index, user);
  if (layout.components != 1 || !isUnsigned(layout.componentType))
    source_.fail(user + ": accessor " + std::to_string(index) + " of indices is not SCALAR of unsigned integers");
  charge(layout.count, 4, user);
  const size_t start = indices.size();
  indices.resize(start + layout.count);
  const bool plain = layout.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT && layout.stride == 4 &&
                     !file_.model.accessors[static_cast<size_t>(index)].sparse.isSparse;
  if (!plain)
    forEachValue(index, layout, user,
                 [&](size_t i, size_t, double value) { indices[start + i] = static_cast<uint32_t>(value); });
  else if (layout.first != nullptr && layout.count > 0)
    std::memcpy(&indices[start], layout.first, layout.count * 4);
}

std::vector<double> GltfArrays::vectors(int index, int components, const std::string& user) {
  const Layout layout = this->layout(index, user);
  if (layout.components != static_cast<size_t>(components))
    source_.fail(user + ": accessor " + std::to_string(index) + " must have " + std::to_string(components) +
                 " components");
  charge(layout.count, 8 * static_cast<uint64_t>(components), user);
  std::vector<double> values(layout.count * layout.components);
  forEachValue(index, layout, user,
               [&](size_t i, size_t c, double value) { values[i * layout.components + c] = value; });
  return values;
}

}  // namespace gnosphere
