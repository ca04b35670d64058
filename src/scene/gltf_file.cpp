// SPDX-License-Identifier: Apache-2.0
// Parses the container and the JSON of a glTF file, checks them and removes what tinygltf need not see.
#include "scene/gltf_file.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <initializer_list>
#include <limits>
#include <optional>
#include <set>

#include "base/json_text.hpp"
#include "base/lasting.hpp"

namespace gnosphere {
namespace {

using Json = nlohmann::json;

constexpr uint32_t kGlbMagic = 0x46546C67;  // "glTF"
constexpr uint32_t kJsonChunk = 0x4E4F534A;
constexpr uint32_t kBinaryChunk = 0x004E4942;

struct Container {
  std::string_view json;
  std::optional<Bytes> binary;
};

uint32_t word(Bytes bytes, size_t offset) {
  uint32_t value;
  std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

std::string_view text(Bytes bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

Container splitGlb(Bytes bytes, const Source& source) {
  if (bytes.size() < 20) source.fail("the GLB file is cut off in its header");
  if (word(bytes, 4) != 2)
    source.fail("it is GLB version " + std::to_string(word(bytes, 4)) + "; convert it to version 2");
  const size_t length = word(bytes, 8);
  if (length > bytes.size())
    source.fail("the GLB file is cut off: its header says " + std::to_string(length) + " bytes, it has " +
                std::to_string(bytes.size()));
  Container container;
  for (size_t offset = 12; offset + 8 <= length;) {
    const size_t size = word(bytes, offset);
    const uint32_t type = word(bytes, offset + 4);
    offset += 8;
    if (size > length - offset) source.fail("the GLB file is cut off in a chunk of " + std::to_string(size) + " bytes");
    const Bytes chunk = bytes.subspan(offset, size);
    if (type == kJsonChunk && container.json.data() == nullptr) container.json = text(chunk);
    if (type == kBinaryChunk && !container.binary) container.binary = chunk;
    offset += size;
  }
  if (container.json.data() == nullptr) source.fail("the GLB file has no JSON chunk");
  return container;
}

enum class Kind { object, array, text, boolean, number, numbers, count, index, indices };

/// A property of a material that changes how much light a surface reflects or lets through, and that is not read.
struct UnreadProperty {
  const char* extension;
  const char* name;  ///< null: the extension itself
  Json neutral;      ///< the value that changes nothing; null: any value changes something
};

const std::vector<UnreadProperty>& unreadProperties() {
  static const auto& kProperties = lasting(std::vector<UnreadProperty>{
      {"KHR_materials_pbrSpecularGlossiness", nullptr, {}},
      {"KHR_materials_unlit", nullptr, {}},
      {"KHR_materials_ior", "ior", 1.5},
      {"KHR_materials_specular", "specularFactor", 1},
      {"KHR_materials_specular", "specularColorFactor", Json::array({1, 1, 1})},
      {"KHR_materials_specular", "specularTexture", {}},
      {"KHR_materials_specular", "specularColorTexture", {}},
      {"KHR_materials_clearcoat", "clearcoatFactor", 0},
      {"KHR_materials_sheen", "sheenColorFactor", Json::array({0, 0, 0})},
      {"KHR_materials_iridescence", "iridescenceFactor", 0},
      {"KHR_materials_anisotropy", "anisotropyStrength", 0},
      {"KHR_materials_diffuse_transmission", "diffuseTransmissionFactor", 0},
      {"KHR_materials_volume", "attenuationColor", Json::array({1, 1, 1})},
  });
  return kProperties;
}

struct Key {
  const char* name;
  Kind kind;
  size_t size = 0;  ///< required length of an array of numbers; 0: any
};

/// Converts 3.0 to 3, because some exporters write integers so.
bool makeWhole(Json& value, double maximum) {
  if (value.is_number_float()) {
    const double number = value.get<double>();
    if (!(number >= 0) || number > maximum || number != std::floor(number)) return false;
    value = static_cast<uint64_t>(number);
  }
  return value.is_number_unsigned() && static_cast<double>(value.get<uint64_t>()) <= maximum;
}

bool fits(Json& value, const Key& key) {
  constexpr double kMaximumCount = 9007199254740992.0;  // 2^53: up to here a double represents every integer
  constexpr double kMaximumIndex = std::numeric_limits<int>::max();
  const auto all = [&](auto&& test) {
    if (!value.is_array() || (key.size != 0 && value.size() != key.size)) return false;
    for (Json& item : value)
      if (!test(item)) return false;
    return true;
  };
  switch (key.kind) {
    case Kind::object: return value.is_object();
    case Kind::array: return value.is_array();
    case Kind::text: return value.is_string();
    case Kind::boolean: return value.is_boolean();
    case Kind::number: return value.is_number();
    case Kind::numbers: return all([](Json& item) { return item.is_number(); });
    case Kind::count: return makeWhole(value, kMaximumCount);
    case Kind::index: return makeWhole(value, kMaximumIndex);
    case Kind::indices: return all([&](Json& item) { return makeWhole(item, kMaximumIndex); });
  }
  return false;
}

std::string described(const Key& key) {
  switch (key.kind) {
    case Kind::object: return "an object";
    case Kind::array: return "an array";
    case Kind::text: return "a string";
    case Kind::boolean: return "true or false";
    case Kind::number: return "a number";
    case Kind::numbers: return key.size != 0 ? std::to_string(key.size) + " numbers" : "an array of numbers";
    case Kind::count: return "a whole number of at least 0";
    case Kind::index: return "a whole number from 0 to 2147483647";
    case Kind::indices: return "an array of whole numbers from 0 to 2147483647";
  }
  return "something else";
}

/// Walks through the JSON, removes what the reader does not use and checks the type of the rest.
class Tidying {
 public:
  Tidying(const Source& source, LeftOut& leftOut) : source_(source), leftOut_(leftOut) {}

  void root(Json& json) {
    leaveOutExtensions(json);
    keep(json, "the file",
         {{"asset", Kind::object},
          {"scene", Kind::index},
          {"scenes", Kind::array},
          {"nodes", Kind::array},
          {"meshes", Kind::array},
          {"accessors", Kind::array},
          {"bufferViews", Kind::array},
          {"buffers", Kind::array},
          {"materials", Kind::array},
          {"skins", Kind::array},
          {"animations", Kind::array},
          {"textures", Kind::array},
          {"samplers", Kind::array},
          {"images", Kind::array},
          {"extensionsRequired", Kind::array}});
    each(json, "scenes", [&](Json& o, const std::string& where) { keep(o, where, {{"nodes", Kind::indices}}); });
    each(json, "nodes", [&](Json& o, const std::string& where) { node(o, where); });
    each(json, "meshes", [&](Json& o, const std::string& where) { mesh(o, where); });
    each(json, "accessors", [&](Json& o, const std::string& where) { accessor(o, where); });
    each(json, "bufferViews", [&](Json& o, const std::string& where) { bufferView(o, where); });
    each(json, "buffers", [&](Json& o, const std::string& where) {
      keep(o, where, {{"uri", Kind::text}, {"byteLength", Kind::count}}, {"byteLength"});
    });
    each(json, "materials", [&](Json& o, const std::string& where) { material(o, where); });
    each(json, "skins", [&](Json& o, const std::string& where) {
      keep(o, where, {{"name", Kind::text}, {"joints", Kind::indices}, {"inverseBindMatrices", Kind::index}},
           {"joints"});
    });
    each(json, "animations", [&](Json& o, const std::string& where) { animation(o, where); });
    // Without alpha cut-outs the textures are not needed, so errors in them do not matter.
    if (!hasHoles_)
      for (const char* name : {"textures", "samplers", "images"}) json.erase(name);
    each(json, "textures", [&](Json& o, const std::string& where) {
      keep(o, where, {{"source", Kind::index}, {"sampler", Kind::index}});
    });
    each(json, "samplers", [&](Json& o, const std::string& where) {
      keep(o, where, {{"wrapS", Kind::index}, {"wrapT", Kind::index}});
    });
    each(json, "images", [&](Json& o, const std::string& where) {
      keep(o, where, {{"uri", Kind::text}, {"bufferView", Kind::index}});
    });
  }

 private:
  void keep(Json& object, const std::string& where, const std::vector<Key>& keys,
            std::initializer_list<const char*> required = {}) {
    if (!object.is_object()) source_.fail(where + " must be an object");
    Json kept = Json::object();
    for (const Key& key : keys) {
      const auto found = object.find(key.name);
      if (found == object.end()) continue;
      if (!fits(*found, key)) source_.fail(where + ": " + key.name + " must be " + described(key));
      kept[key.name] = std::move(*found);
    }
    for (const char* name : required)
      if (!kept.contains(name)) source_.fail(where + ": " + name + " is missing");
    object = std::move(kept);
  }

  template <typename Visit>
  void each(Json& object, const char* name, Visit&& visit, const std::string& prefix = "") {
    const auto found = object.find(name);
    if (found == object.end()) return;
    size_t i = 0;
    for (Json& item : *found) visit(item, prefix + name + "[" + std::to_string(i++) + "]");
  }

  /// Keeps one extension of an object.
  template <typename Visit>
  void extension(Json& object, const std::string& where, const char* name, Visit&& visit) {
    const auto found = object.find("extensions");
    if (found == object.end()) return;
    keep(*found, where + ".extensions", {{name, Kind::object}});
    if (found->contains(name)) visit((*found)[name], where + "." + name);
  }

  /// Keeps the class that the extras state, as "class": its number, or else its name. Extras may hold anything, so the
  /// rest is not ours.
  void classOf(Json& o) {
    if (!o.is_object() || !o.contains("extras")) return;
    Json number, name;
    for (const char* key : {"label", "class"}) {
      if (!o["extras"].is_object() || !o["extras"].contains(key)) continue;
      Json stated = o["extras"][key];
      const bool isName = stated.is_string() && !stated.get_ref<const std::string&>().empty();
      if (isName)
        name = stated;
      else if (makeWhole(stated, 65535))
        number = stated;
      else
        leftOut_.add("classes that are neither names nor whole numbers from 0 to 65535");
    }
    o.erase("extras");
    if (const Json& stated = number.is_null() ? name : number; !stated.is_null()) o["extras"] = {{"class", stated}};
  }

  /// Returns an entry of the extras; null if there is none.
  static Json extraOf(const Json& o, const char* name) {
    if (!o.is_object() || !o.contains("extras") || !o["extras"].is_object()) return {};
    return o["extras"].value(name, Json());
  }

  void node(Json& o, const std::string& where) {
    Json instance = extraOf(o, kInstanceExtra);
    classOf(o);
    if (makeWhole(instance, std::numeric_limits<int>::max())) o["extras"][kInstanceExtra] = instance;
    keep(o, where,
         {{"extras", Kind::object},
          {"name", Kind::text},
          {"matrix", Kind::numbers, 16},
          {"translation", Kind::numbers, 3},
          {"rotation", Kind::numbers, 4},
          {"scale", Kind::numbers, 3},
          {"mesh", Kind::index},
          {"skin", Kind::index},
          {"weights", Kind::numbers},
          {"children", Kind::indices},
          {"extensions", Kind::object}});
    if (isHidden(o)) {
      o.erase("mesh");
      o["extras"]["hidden"] = true;
    }
    extension(o, where, "EXT_mesh_gpu_instancing", [&](Json& e, const std::string& at) {
      keep(e, at, {{"attributes", Kind::object}}, {"attributes"});
      leaveOutNumbers(e["attributes"], "instances");
      std::vector<Key> keys;  // also others, because any attribute has the number of instances
      for (const auto& item : e["attributes"].items()) keys.push_back({item.key().c_str(), Kind::index});
      keep(e["attributes"], at, keys);
    });
  }

  /// Whether KHR_node_visibility hides a node, and with it the nodes below.
  static bool isHidden(const Json& node) {
    const Json::json_pointer visible("/extensions/KHR_node_visibility/visible");
    return node.contains(visible) && node[visible] == false;
  }

  void mesh(Json& o, const std::string& where) {
    classOf(o);
    keep(o, where,
         {{"extras", Kind::object}, {"name", Kind::text}, {"weights", Kind::numbers}, {"primitives", Kind::array}},
         {"primitives"});
    each(
        o, "primitives", [&](Json& p, const std::string& at) { primitive(p, at); }, where + ".");
  }

  void primitive(Json& o, const std::string& where) {
    keep(o, where,
         {{"attributes", Kind::object},
          {"indices", Kind::index},
          {"material", Kind::index},
          {"mode", Kind::index},
          {"targets", Kind::array},
          {"extensions", Kind::object}},
         {"attributes"});
    each(
        o, "targets",
        [&](Json& t, const std::string& at) {
          keep(t, at, {{"POSITION", Kind::index}});
        },
        where + ".");
    Json& attributes = o["attributes"];
    if (attributes.is_object() && attributes.contains("COLOR_0")) leftOut_.add(kVertexColours);
    leaveOutNumbers(attributes, "vertices");
    keep(attributes, where + ".attributes", vertexKeys(attributes));
    if (o.contains("indices")) attributes[kIndicesAttribute] = std::move(o["indices"]);
    o.erase("indices");
    extension(o, where, "KHR_draco_mesh_compression", [&](Json& e, const std::string& at) {
      keep(e, at, {{"bufferView", Kind::index}, {"attributes", Kind::object}}, {"bufferView", "attributes"});
      keep(e["attributes"], at, vertexKeys(e["attributes"]));
    });
  }

  void animation(Json& o, const std::string& where) {
    const Json duration = extraOf(o, kDurationExtra);
    keep(o, where, {{"name", Kind::text}, {"channels", Kind::array}, {"samplers", Kind::array}},
         {"channels", "samplers"});
    if (duration.is_number() && duration >= 0) o[kDurationExtra] = duration;
    const auto channel = [&](Json& c, const std::string& at) {
      keep(c, at, {{"sampler", Kind::index}, {"target", Kind::object}}, {"sampler", "target"});
      keep(c["target"], at + ".target", {{"node", Kind::index}, {"path", Kind::text}}, {"path"});
    };
    const auto sampler = [&](Json& s, const std::string& at) {
      keep(s, at, {{"input", Kind::index}, {"output", Kind::index}, {"interpolation", Kind::text}},
           {"input", "output"});
    };
    each(o, "channels", channel, where + ".");
    each(o, "samplers", sampler, where + ".");
  }

  /// Keeps POSITION and every set of TEXCOORD, JOINTS and WEIGHTS.
  static std::vector<Key> vertexKeys(const Json& attributes) {
    std::vector<Key> keys = {{"POSITION", Kind::index}};
    for (auto item = attributes.begin(); item != attributes.end(); ++item)
      for (const char* prefix : {"TEXCOORD_", "JOINTS_", "WEIGHTS_"})
        if (item.key().starts_with(prefix)) keys.push_back({item.key().c_str(), Kind::index});
    return keys;
  }

  void accessor(Json& o, const std::string& where) {
    keep(o, where,
         {{"bufferView", Kind::index},
          {"byteOffset", Kind::count},
          {"componentType", Kind::index},
          {"normalized", Kind::boolean},
          {"count", Kind::count},
          {"type", Kind::text},
          {"sparse", Kind::object}},
         {"componentType", "count", "type"});
    const auto sparse = o.find("sparse");
    if (sparse == o.end()) return;
    keep(*sparse, where + ".sparse", {{"count", Kind::index}, {"indices", Kind::object}, {"values", Kind::object}},
         {"count", "indices", "values"});
    keep((*sparse)["indices"], where + ".sparse.indices",
         {{"bufferView", Kind::index}, {"byteOffset", Kind::index}, {"componentType", Kind::index}},
         {"bufferView", "componentType"});
    keep((*sparse)["values"], where + ".sparse.values", {{"bufferView", Kind::index}, {"byteOffset", Kind::index}},
         {"bufferView"});
  }

  void bufferView(Json& o, const std::string& where) {
    keep(o, where,
         {{"buffer", Kind::index},
          {"byteOffset", Kind::count},
          {"byteLength", Kind::count},
          {"byteStride", Kind::count},
          {"extensions", Kind::object}},
         {"buffer", "byteLength"});
    extension(o, where, "EXT_meshopt_compression", [&](Json& e, const std::string& at) {
      keep(e, at,
           {{"buffer", Kind::index},
            {"byteOffset", Kind::index},
            {"byteLength", Kind::index},
            {"byteStride", Kind::index},
            {"count", Kind::index},
            {"mode", Kind::text},
            {"filter", Kind::text}},
           {"buffer", "byteLength", "byteStride", "count", "mode"});
    });
  }

  void material(Json& o, const std::string& where) {
    const Json retro = extraOf(o, "retro");
    classOf(o);
    if (retro.is_number() && retro >= 0 && retro <= Material::kMostRetro)
      o["extras"]["retro"] = retro;
    else if (!retro.is_null())
      leftOut_.add("retro-reflections of materials that are no numbers from 0 to 1000000");
    keep(o, where,
         {{"extras", Kind::object},
          {"name", Kind::text},
          {"pbrMetallicRoughness", Kind::object},
          {"alphaMode", Kind::text},
          {"alphaCutoff", Kind::number},
          {"doubleSided", Kind::boolean},
          {"extensions", Kind::object}});
    if (o.contains("pbrMetallicRoughness")) surface(o["pbrMetallicRoughness"], where, o.value("alphaMode", ""));
    if (o.contains("extensions")) leaveOutProperties(o["extensions"]);
    extension(o, where, "KHR_materials_transmission", [&](Json& e, const std::string& at) {
      const bool isTextured = e.contains("transmissionTexture");
      keep(e, at, {{"transmissionFactor", Kind::number}});
      if (!isTextured || e.value("transmissionFactor", 0.0) == 0) return;
      // The texture says where the surface is glass, so the factor alone would make glass of a whole car.
      leftOut_.add(kTextureTransmissions);
      e["transmissionFactor"] = 0;
    });
  }

  /// Counts the extensions of the file that are not read.
  void leaveOutExtensions(const Json& json) {
    std::set<std::string> names;
    if (const auto used = json.find("extensionsUsed"); used != json.end() && used->is_array())
      for (const Json& name : *used)
        if (name.is_string()) names.insert(name.get<std::string>());
    if (const auto ofFile = json.find("extensions"); ofFile != json.end() && ofFile->is_object())
      for (const auto& item : ofFile->items()) names.insert(item.key());
    for (const std::string& name : names)
      if (!isGltfExtensionKnown(name)) leftOut_.add("extensions of the file that are not read: " + inQuotes(name));
  }

  /// Counts the attributes of a file's own, such as the numbers of features. Their names begin with an underscore.
  void leaveOutNumbers(const Json& attributes, const char* owners) {
    if (!attributes.is_object()) return;
    for (const auto& item : attributes.items())
      if (item.key().starts_with('_'))
        leftOut_.add(std::string("sets of numbers of ") + owners + ": " + inQuotes(item.key()));
  }

  /// Whether a volume takes light away: one without thickness, or without a distance, does not.
  static bool attenuates(const Json& volume) {
    return volume.contains("attenuationDistance") && volume.contains("thicknessFactor") &&
           volume["thicknessFactor"] != 0;
  }

  /// Counts each extension of a material of which a property that is not read has an effect.
  void leaveOutProperties(const Json& extensions) {
    std::set<std::string> found;
    for (const auto& [extension, name, neutral] : unreadProperties())
      if (const auto stated = extensions.find(extension); stated != extensions.end())
        if (name == nullptr || (stated->contains(name) && (*stated)[name] != neutral)) found.insert(extension);
    if (found.contains("KHR_materials_volume") && !attenuates(extensions["KHR_materials_volume"]))
      found.erase("KHR_materials_volume");
    for (const std::string& extension : found) leftOut_.add("materials' properties of " + extension);
  }

  /// Keeps the properties of a surface; of its textures, only those that cut holes.
  void surface(Json& o, const std::string& where, const std::string& alphaMode) {
    keep(o, where + ".pbrMetallicRoughness",
         {{"baseColorFactor", Kind::numbers, 4},
          {"metallicFactor", Kind::number},
          {"roughnessFactor", Kind::number},
          {"metallicRoughnessTexture", Kind::object},
          {"baseColorTexture", Kind::object}});
    if (o.contains("metallicRoughnessTexture")) {
      // The texture multiplies the metallic factor, whose default is 1: that factor alone would make metals of most
      // surfaces.
      leftOut_.add(kTextureMetals);
      o.erase("metallicRoughnessTexture");
      o["metallicFactor"] = 0;
    }
    if (!o.contains("baseColorTexture")) return;
    if (alphaMode != "MASK") {
      leftOut_.add(kTextureColours);
      if (alphaMode == "BLEND") leftOut_.add(kTextureAlphas);
      o.erase("baseColorTexture");
      return;
    }
    hasHoles_ = true;
    Json& texture = o["baseColorTexture"];
    const std::string at = where + ".baseColorTexture";
    keep(texture, at, {{"index", Kind::index}, {"texCoord", Kind::index}, {"extensions", Kind::object}}, {"index"});
    extension(texture, at, "KHR_texture_transform", [&](Json& e, const std::string& inside) {
      keep(e, inside,
           {{"offset", Kind::numbers, 2},
            {"rotation", Kind::number},
            {"scale", Kind::numbers, 2},
            {"texCoord", Kind::index}});
    });
  }

  const Source& source_;
  LeftOut& leftOut_;
  bool hasHoles_ = false;
};

void checkVersion(const Json& json, const Source& source) {
  const auto asset = json.find("asset");
  if (!json.is_object() || asset == json.end() || !asset->is_object() || !asset->contains("version"))
    source.fail("it is not glTF: its JSON has no asset.version");
  const Json& version = (*asset)["version"];
  if (!version.is_string() || !version.get_ref<const std::string&>().starts_with("2."))
    source.fail("it is glTF version " + inQuotes(jsonText(version)) + "; convert it to version 2.0");
}

}  // namespace

bool isGltfExtensionKnown(const std::string& name) {
  static constexpr const char* kRead[] = {"KHR_mesh_quantization", "KHR_draco_mesh_compression",
                                          "EXT_meshopt_compression", "EXT_mesh_gpu_instancing", "KHR_node_visibility"};
  static constexpr const char* kHarmless[] = {"KHR_materials_", "KHR_texture_",  "EXT_texture_", "KHR_lights_",
                                              "EXT_lights_",    "MSFT_texture_", "KHR_xmp",      "KHR_animation_"};
  return std::any_of(std::begin(kRead), std::end(kRead), [&](const char* read) { return name == read; }) ||
         std::any_of(std::begin(kHarmless), std::end(kHarmless),
                     [&](const char* prefix) { return name.starts_with(prefix); });
}

GltfFile parseGltf(Bytes bytes, const Source& source) {
  const bool isGlb = bytes.size() >= 4 && word(bytes, 0) == kGlbMagic;
  const Container container = isGlb ? splitGlb(bytes, source) : Container{textOf(bytes, source), {}};

  GltfFile file;
  std::string stripped;
  {
    Json json;
    try {
      json = parseJson(container.json);
    } catch (const JsonTooDeep&) {
      source.fail("its JSON nests deeper than " + std::to_string(kMaximumJsonDepth) + " levels");
    } catch (const Json::exception& error) {
      source.fail(std::string(isGlb ? "its JSON is invalid" : "it is neither glTF text nor GLB") + ": " + error.what());
    }
    checkVersion(json, source);
    Tidying(source, file.leftOut).root(json);
    json["asset"] = {{"version", "2.0"}};
    if (json.contains("buffers"))
      for (Json& buffer : json["buffers"]) {
        GltfBuffer& added = file.buffers.emplace_back();
        added.byteLength = buffer["byteLength"].get<size_t>();
        if (buffer.contains("uri")) added.uri = std::move(buffer["uri"].get_ref<std::string&>());
      }
    json.erase("buffers");
    if (json.contains("images"))
      for (const Json& image : json["images"])
        file.images.push_back({image.value("uri", std::string()), image.value("bufferView", -1)});
    json.erase("images");
    for (const auto& [name, kept] : {std::pair("animations", &file.animations), std::pair("skins", &file.skins)}) {
      if (json.contains(name)) *kept = std::move(json[name]);
      json.erase(name);
    }
    stripped = jsonText(json);
  }
  if (container.binary && !file.buffers.empty() && file.buffers[0].uri.empty()) {
    file.buffers[0].bytes = *container.binary;
    file.buffers[0].loaded = true;
  }

  tinygltf::TinyGLTF loader;
  std::string problems, warnings;
  if (stripped.size() > std::numeric_limits<unsigned int>::max()) source.fail("its JSON is larger than 4 GiB");
  if (!loader.LoadASCIIFromString(&file.model, &problems, &warnings, stripped.data(),
                                  static_cast<unsigned int>(stripped.size()), ""))
    source.fail(problems.empty() ? "tinygltf refuses it" : problems.substr(0, problems.find('\n')));
  return file;
}

}  // namespace gnosphere
