// SPDX-License-Identifier: Apache-2.0
// Binds gnosphere/animation.hpp, and what clips move in gnosphere/scene.hpp.
#include "arrays.hpp"
#include "rows.hpp"
#include "scene/validate.hpp"

namespace gnosphere::python {
namespace {

void bindNode(nb::module_& m) {
  nb::class_<Node>(m, "Node",
                   "A frame that clips move: its map to the frame of its parent is translation * rotation * scale, or "
                   "`matrix`. It is never changed after it is made.")
      .def(
          "__init__",
          [](Node* self, std::string name, uint32_t parent, Vec3 translation, Quaternion rotation, Vec3 scale,
             std::optional<Transform> matrix, const ArrayLike& morphWeights) {
            new (self) Node{std::move(name),
                            parent,
                            translation,
                            rotation,
                            scale,
                            matrix,
                            arrayOf<float>(morphWeights, "Node: morph_weights").copy()};
          },
          "name"_a = "", "parent"_a = kNoNode, "translation"_a = Vec3(), "rotation"_a = Quaternion(),
          "scale"_a = Vec3{1, 1, 1}, "matrix"_a = nb::none(), "morph_weights"_a = nb::make_tuple())
      .def_ro("name", &Node::name, "Scenes from files have the name that the file states.")
      .def_ro("parent", &Node::parent, "Index into SceneAnimation.nodes, less than its own; NO_NODE for none.")
      .def_ro("translation", &Node::translation, "Metres.")
      .def_ro("rotation", &Node::rotation, "x, y, z, w, of any length but 0; only its direction counts.")
      .def_ro("scale", &Node::scale, "Factors along x, y and z.")
      .def_prop_ro(
          "matrix", [](const Node& self) { return self.matrix; }, "If given, no clip moves the node.")
      .def_prop_ro(
          "morph_weights",
          [](const Node& self) {
            return columnView<const float>(self.morphWeights.data(), self.morphWeights.size(), nb::find(self));
          },
          kOwned,
          "Of the mesh that it places: shape (targets,), or (0,) for all 0, float32: a read-only view, which keeps the "
          "node alive.");

  nb::class_<Skin>(m, "Skin", "The joints of skinned meshes. It is never changed after it is made.")
      .def(
          "__init__",
          [](Skin* self, const ArrayLike& joints, const TransformsLike& inverseBinds, std::string name) {
            new (self) Skin{std::move(name), arrayOf<uint32_t>(joints, "Skin: joints").copy(),
                            transformsOf(inverseBinds, "Skin: inverse_binds")};
          },
          "joints"_a, "inverse_binds"_a, "name"_a = "",
          "joints: shape (joints,), uint32: by joint, an index into SceneAnimation.nodes.\n"
          "inverse_binds: shape (joints, 3, 4), float64, or a sequence of Transform: by joint, maps the mesh frame to "
          "the frame of the joint, as it was bound.\n"
          "Raises Error(invalid_argument) for arrays of another shape or type.")
      .def_ro("name", &Skin::name, "Scenes from files have the name that the file states.")
      .def_prop_ro(
          "joints",
          [](const Skin& self) {
            return columnView<const uint32_t>(self.joints.data(), self.joints.size(), nb::find(self));
          },
          kOwned, "Shape (joints,), uint32: a read-only view, which keeps the skin alive.")
      .def_prop_ro(
          "inverse_binds", [](const Skin& self) { return transformsView(self.inverseBinds, nb::find(self)); }, kOwned,
          "Shape (joints, 3, 4), float64: a read-only view, which keeps the skin alive.");
}

void makeTrack(Track* self, uint32_t node, const Choice<Track::Property>& property, const ArrayLike& times,
               const ArrayLike& values, const Choice<Track::Interpolation>& interpolation) {
  const auto keys = arrayOf<float>(times, "Track: times");
  const auto table = arrayOf<float>(values, "Track: values", kAnyWidth);
  if (keys.rows() == 0 || keys.rows() != table.rows())
    refuse("Track: times and values have " + std::to_string(keys.rows()) + " and " + std::to_string(table.rows()) +
           " rows; both must have one per key, and there must be a key");
  new (self) Track{node, chosen(property, "Track: property"), chosen(interpolation, "Track: interpolation"),
                   keys.copy(), table.copy()};
}

void bindClip(nb::module_& m) {
  nb::class_<Track> track(m, "Track",
                          "How a clip moves one property of one node: values at key times. Before its first and after "
                          "its last key it is constant. It is never changed after it is made.");
  nb::enum_<Track::Property>(track, "Property", "What a track moves.")
      .value("translation", Track::Property::translation)
      .value("rotation", Track::Property::rotation)
      .value("scale", Track::Property::scale)
      .value("morph_weights", Track::Property::morphWeights);
  nb::enum_<Track::Interpolation>(track, "Interpolation", "How values go from key to key; rotations turn by slerp.")
      .value("step", Track::Interpolation::step)
      .value("linear", Track::Interpolation::linear, "Rotations turn by slerp.")
      .value("cubic", Track::Interpolation::cubic);
  track
      .def("__init__", &makeTrack, "node"_a, "property"_a, "times"_a, "values"_a,
           "interpolation"_a = Track::Interpolation::linear,
           "node: index into SceneAnimation.nodes.\n"
           "property, interpolation: their enumerators, or the names of these.\n"
           "times: shape (keys,), float32, seconds from 0 on, ascending; at least one.\n"
           "values: shape (keys, n), float32. n is 3, 4 for a rotation (x, y, z, w), or the number of morph targets. "
           "Cubic: three times as many, the slopes before the key, the values, and the slopes after it (glTF 2.0, "
           "appendix C).\n"
           "Raises Error(invalid_argument) for arrays of another shape or type.")
      .def_ro("node", &Track::node, "Index into SceneAnimation.nodes.")
      .def_ro("property", &Track::property, "What the track moves.")
      .def_ro("interpolation", &Track::interpolation, "How values go from key to key.")
      .def_prop_ro(
          "times",
          [](const Track& self) {
            return columnView<const float>(self.times.data(), self.times.size(), nb::find(self));
          },
          kOwned, "Shape (keys,), float32, seconds: a read-only view, which keeps the track alive.")
      .def_prop_ro(
          "values",
          [](const Track& self) {
            const size_t keys = self.times.size();
            return tableView(self.values.data(), keys, keys > 0 ? self.values.size() / keys : 0, nb::find(self));
          },
          kOwned, "Shape (keys, n), float32: a read-only view, which keeps the track alive.");

  nb::class_<Clip> clip(
      m, "Clip",
      "A named motion of nodes; 'animation' in glTF. At most one track moves a property of a node. It is "
      "never changed after it is made.");
  clip.def(
          "__init__",
          [](Clip* self, std::string name, double duration, std::vector<Track> tracks) {
            new (self) Clip{std::move(name), duration, std::move(tracks)};
          },
          "name"_a = "", "duration"_a = 0.0, "tracks"_a = nb::make_tuple())
      .def_ro("name", &Clip::name, "What clip_named() finds.")
      .def_ro("duration", &Clip::duration, "Seconds.");
  readTuple(clip, "tracks", &Clip::tracks, "A tuple of copies.");
}

void bindSceneAnimation(nb::module_& m) {
  nb::class_<AnimatedInstance>(
      m, "AnimatedInstance",
      "An instance that follows a node or a skin. Its transform is root * node * offset. With a skin it is root * "
      "offset, and the joints of its mesh are at inverse(offset) * node of the joint * inverse bind. It is never "
      "changed after it is made.")
      .def(
          "__init__",
          [](AnimatedInstance* self, uint32_t instance, uint32_t node, uint32_t skin, const Transform& offset) {
            new (self) AnimatedInstance{instance, node, skin, offset};
          },
          "instance"_a, "node"_a, "skin"_a = kNoSkin, "offset"_a = Transform())
      .def_ro("instance", &AnimatedInstance::instance, "Index into Scene.instances.")
      .def_ro("node", &AnimatedInstance::node,
              "Index into SceneAnimation.nodes; its morph weights are those of the mesh.")
      .def_ro("skin", &AnimatedInstance::skin, "Index into SceneAnimation.skins; NO_SKIN for none.")
      .def_ro("offset", &AnimatedInstance::offset, "From the frame of the mesh to that of its node or its skin.");

  nb::class_<SceneAnimation> animation(
      m, "SceneAnimation",
      "What can move by clips; see state_at(). A deformable mesh follows one node and one skin, so instances that "
      "follow others have a mesh of their own. It is never changed after it is made.");
  animation
      .def(
          "__init__",
          [](SceneAnimation* self, std::vector<Node> nodes, std::vector<Clip> clips,
             std::vector<AnimatedInstance> instances, std::vector<Skin> skins, const Transform& root) {
            new (self) SceneAnimation{root, std::move(nodes), std::move(skins), std::move(clips), std::move(instances)};
          },
          "nodes"_a = nb::make_tuple(), "clips"_a = nb::make_tuple(), "instances"_a = nb::make_tuple(),
          "skins"_a = nb::make_tuple(), "root"_a = Transform())
      .def_ro("root", &SceneAnimation::root, "Maps the frame above all nodes to the world.");
  readTuple(animation, "nodes", &SceneAnimation::nodes, "A tuple of copies; parents come before their children.");
  readTuple(animation, "skins", &SceneAnimation::skins, "A tuple of copies.");
  readTuple(animation, "clips", &SceneAnimation::clips, "A tuple of copies.");
  readTuple(animation, "instances", &SceneAnimation::instances, "A tuple of copies.");
}

/// Refuses a clip that does not fit the scene, and an animation that does not. Of the meshes only what an animation
/// refers to is looked at, so the check is cheap enough for every call.
void check(const Scene& scene, const Clip& clip) {
  Scene checked;
  for (const Mesh& mesh : scene.meshes) {
    Mesh& other = checked.meshes.emplace_back();
    other.jointCount = mesh.jointCount;
    other.morphTargets.resize(mesh.morphTargets.size());
  }
  for (size_t i = 0; i < scene.instances.size(); ++i) {
    const uint32_t mesh = scene.instances[i].mesh;
    if (mesh >= scene.meshes.size())
      refuse("instance " + std::to_string(i) + ": mesh " + std::to_string(mesh) + " does not exist, the scene has " +
             std::to_string(scene.meshes.size()));
    checked.instances.emplace_back().mesh = mesh;
  }
  const SceneAnimation& animation = scene.animation;
  checked.animation = {animation.root, animation.nodes, animation.skins, {clip}, animation.instances};
  validateAnimation(checked);
}

}  // namespace

void bindAnimation(nb::module_& m) {
  m.attr("NO_NODE") = kNoNode;
  m.attr("NO_SKIN") = kNoSkin;
  bindNode(m);
  bindClip(m);
  bindSceneAnimation(m);
}

void bindStates(nb::module_& m) {
  nb::class_<SceneState> state(m, "SceneState",
                               "Where the instances and the vertices of a scene are at one moment. It is never changed "
                               "after it is made.");
  readTuple(state, "transforms", &SceneState::transforms, "By instance; for Simulator.set_transform().");
  readTuple(state, "deformations", &SceneState::deformations,
            "By mesh, empty unless it is deformable; for Simulator.set_deformation().");

  nb::enum_<ClipEnd>(m, "ClipEnd", "What happens outside the time of a clip.")
      .value("loop", ClipEnd::loop, "It repeats.")
      .value("hold", ClipEnd::hold, "Its first or last state holds.");
  m.def(
      "state_at",
      [](const Scene& scene, const Clip& clip, double seconds, const Choice<ClipEnd>& end) {
        const ClipEnd way = chosen(end, "state_at: end");
        const ReleasedGil released;
        check(scene, clip);
        return stateAt(scene, clip, seconds, way);
      },
      "scene"_a, "clip"_a, "seconds"_a, "end"_a = ClipEnd::loop,
      "The state of the scene `seconds` after the start of a clip. What the clip does not move is at rest: instances "
      "that follow no node keep their transform, and meshes that none of them places their deformation. An empty "
      "Clip() gives the state at rest. Raises Error(invalid_argument) for a clip or an animation that does not fit the "
      "scene.");
  m.def(
      "clip_named", [](const Scene& scene, const std::string& name) { return clipNamed(scene, name); }, "scene"_a,
      "name"_a,
      "A copy of the clip of this name, or, where none has it, of this number, counted from 0. Raises "
      "Error(invalid_argument) that tells the nearest names, or the numbers of several clips that have the name.");
}

}  // namespace gnosphere::python
