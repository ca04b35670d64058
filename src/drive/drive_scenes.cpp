// SPDX-License-Identifier: Apache-2.0
// Reads the scenes and models of a drive from its file, and the classes of their instances and materials.
#include "base/os.hpp"
#include "drive/drive_reader.hpp"
#include "geometry/dropped_triangles.hpp"
#include "scene/coarse_positions.hpp"

namespace gnosphere::drive {

using nlohmann::json;

void DriveReader::classes() {
  for (const auto& [name, object] : memberOf(root_, "classes").items()) {
    const uint16_t id = object["id"].get<uint16_t>();
    drive_.classes.push_back({name, id, object.value("moving_id", id)});
    classNames_.push_back(name);
  }
}

/// Gives each instance or material the class of the longest pattern in `table` that its name matches. Others have the
/// class that their file states by number or name, and otherwise `usual`. Adds stated classes that the drive does not
/// name to `unknown`.
template <typename Named>
void DriveReader::classify(const json& object, const std::string& path, const std::string& table, uint16_t usual,
                           std::vector<Named>& all, std::set<std::string>& unknown) {
  std::vector<std::optional<std::pair<size_t, uint16_t>>> matches(all.size());  // length of the pattern, class
  for (const auto& [pattern, name] : memberOf(object, table.c_str()).items()) {
    const uint16_t id = classNamed(name, memberPath(path + "." + table, pattern));
    bool any = false;
    for (size_t i = 0; i < all.size(); ++i) {
      if (!os::fits(pattern, all[i].name)) continue;
      any = true;
      if (!matches[i] || pattern.size() >= matches[i]->first) matches[i] = {pattern.size(), id};
    }
    if (!any) warn(path + "." + table, inQuotes(pattern) + " matches no " + table.substr(0, table.size() - 1));
  }
  for (size_t i = 0; i < all.size(); ++i) {
    Named& named = all[i];
    if (matches[i]) {
      named.classId = matches[i]->second;
      continue;
    }
    if (named.classId == 0 && !named.className.empty()) {
      const auto known = std::ranges::find(drive_.classes, named.className, &Class::name);
      if (known != drive_.classes.end())
        named.classId = known->id;
      else
        unknown.insert(inQuotes(named.className));
    } else if (named.classId != 0 &&
               std::ranges::find(drive_.classes, named.classId, &Class::id) == drive_.classes.end()) {
      unknown.insert(std::to_string(named.classId));
    }
    if (named.classId == 0) named.classId = usual;
  }
}

uint16_t DriveReader::classNamed(const json& name, const std::string& path) {
  const size_t found = find(classNames_, name, path);
  return found < drive_.classes.size() ? drive_.classes[found].id : uint16_t{0};
}

void DriveReader::warnOfClasses(const std::set<std::string>& unknown, const std::string& path) {
  if (unknown.empty()) return;
  std::string all;
  for (const std::string& stated : unknown) all += (all.empty() ? "" : ", ") + stated;
  warn(path + ".file", std::string("states the ") + (unknown.size() > 1 ? "classes " : "class ") + all +
                           ", which classes does not name");
}

/// Warns of a file whose positions have steps or are nowhere, and once only of one that several scenes and models name.
void DriveReader::warnOfPositions(const json& object, const std::string& path, const Scene& scene) {
  const std::string name = object.value("file", "");
  const auto tell = [&](const std::string& text) {
    const auto isTold = [&](const std::string& warning) { return warning.ends_with(text); };
    if (std::ranges::none_of(drive_.warnings, isTold)) warn(path + ".file", text);
  };
  if (const std::string steps = scene.meshes.empty() ? "" : coarsePositions(place(name), scene); !steps.empty())
    tell(inQuotes(name) + ": " + steps);
  if (const uint64_t dropped = droppedTriangles(scene).nonFinite; dropped > 0)
    tell(droppedText(dropped, inQuotes(name)));
}

void DriveReader::scenes() {
  for (size_t i = 0; i < root_["scenes"].size(); ++i) {
    const std::string path = entryPath("scenes", i);
    const json& object = root_["scenes"][i];
    Scene scene = this->scene(object, path);
    warnOfPositions(object, path, scene);
    const uint16_t usual = object.contains("class") ? classNamed(object["class"], path + ".class") : uint16_t{0};
    std::set<std::string> unknown;
    classify(object, path, "instances", usual, scene.instances, unknown);
    classify(object, path, "materials", 0, scene.materials, unknown);
    warnOfClasses(unknown, path);
    if (object.contains("boxes")) takeBoxed(object, path, scene);
    drive_.sceneAnimations.push_back(animation(root_["scenes"][i], path, scene));
    drive_.scenes.push_back(std::move(scene));
  }
}

/// Makes actors of the instances of a scene that have boxes.
void DriveReader::takeBoxed(const json& object, const std::string& path, Scene& scene) {
  if (object.contains("animation"))
    refuse(path + ".boxes", "cannot be with an animation; make actors of what it moves");
  std::map<uint16_t, size_t> categories;  // by the number of the class
  for (size_t i = 0; i < object["boxes"].size(); ++i) {
    const size_t category = find(classNames_, object["boxes"][i], entryPath(path + ".boxes", i));
    if (category < drive_.classes.size()) categories.try_emplace(drive_.classes[category].id, category);
  }
  const size_t before = standing_.actors.size();
  takeStanding(
      scene,
      [&](const Instance& instance) -> std::optional<size_t> {
        const auto found = categories.find(instance.classId);
        return found == categories.end() ? std::optional<size_t>() : found->second;
      },
      standing_);
  if (standing_.actors.size() == before) warn(path + ".boxes", "no instance has any of these classes");
}

/// Appends the actors that were instances of scenes, each with a name of its own.
void DriveReader::addStanding() {
  std::set<std::string> names;
  std::map<std::string, size_t> numbers;  // the last that was tried for a name
  for (const Actor& actor : drive_.actors) names.insert(actor.name);
  for (Actor& actor : standing_.actors) {
    const std::string stated = actor.name;
    size_t& number = numbers.try_emplace(stated, 1).first->second;
    while (!names.insert(actor.name).second) actor.name = stated + " (" + std::to_string(++number) + ")";
    actor.model += drive_.models.size();
    drive_.actors.push_back(std::move(actor));
  }
  for (Scene& model : standing_.models) drive_.models.push_back(std::move(model));
}

void DriveReader::models() {
  for (const auto& [name, object] : memberOf(root_, "models").items()) {
    drive_.modelNames.push_back(name);
    const std::string path = memberPath("models", name);
    Scene model = scene(object, path);
    warnOfPositions(object, path, model);
    std::set<std::string> unknown;
    classify(object, path, "materials", 0, model.materials, unknown);
    warnOfClasses(unknown, path);
    if (model.instances.empty() && mistakes_.empty()) refuse(path, "has no triangles");
    drive_.models.push_back(std::move(model));
  }
}

void DriveReader::materialTable() {
  const json& name = memberOf(root_, "material_table");
  if (name.is_null()) return;
  Scene all;
  for (const std::vector<Scene>* scenes : {&drive_.scenes, &drive_.models})
    for (const Scene& scene : *scenes)
      all.materials.insert(all.materials.end(), scene.materials.begin(), scene.materials.end());
  attempt("material_table", [&] {
    drive_.materials = loadMaterialTable(file(name));
    std::vector<std::string> unused;
    opticsOf(all, drive_.materials, 905, &unused);
    for (const std::string& row : unused) warn("material_table", "no scene or model has the material " + inQuotes(row));
  });
}

}  // namespace gnosphere::drive
