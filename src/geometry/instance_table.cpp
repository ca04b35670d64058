// SPDX-License-Identifier: Apache-2.0
#include "geometry/instance_table.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>

#include "base/room.hpp"
#include "base/threads.hpp"
#include "geometry/pose.hpp"

namespace gnosphere {
namespace {

const MeshSummary kEmpty;

// Fewer instances than this are not worth a thread.
constexpr uint64_t kInstancesPerRun = 2048;

glm::dmat3 linear(const Transform& t) {
  const auto& m = t.rows;
  return glm::dmat3(m[0], m[4], m[8], m[1], m[5], m[9], m[2], m[6], m[10]);
}

// Whether a map takes the mesh into a plane, but for rounding.
bool flattens(const glm::dmat3& map) {
  const double box = glm::length(map[0]) * glm::length(map[1]) * glm::length(map[2]);
  return !(std::abs(glm::determinant(map)) > gpu::kFlatVolume * box);
}

// Returns the inverse of a map. If the map flattens the mesh along an axis of the mesh, as a scale of 0 does, any
// number may be the coordinate along this axis, and the inverse gives 0. A map that flattens the mesh otherwise has no
// inverse, and the result is the zero matrix.
glm::dmat3 inverseOf(glm::dmat3 map) {
  int flat = -1;
  for (int axis = 0; axis < 3; ++axis)
    if (map[axis] == glm::dvec3(0)) flat = axis;
  if (flat >= 0) map[flat] = glm::cross(map[(flat + 1) % 3], map[(flat + 2) % 3]);
  if (flattens(map)) return glm::dmat3(0);
  glm::dmat3 inverse = glm::inverse(map);
  if (flat >= 0) inverse[0][flat] = inverse[1][flat] = inverse[2][flat] = 0;
  return inverse;
}

void compose(const glm::dmat3& toSensor, const glm::dvec3& sensor, const glm::dmat3& toWorld,
             const glm::dmat3& fromWorld, const glm::dvec3& position, uint32_t number, gpu::Instance& out) {
  // World positions are subtracted first, in double: the difference is small wherever in the world the scene lies.
  const glm::dvec3 translation = position - sensor;
  // The pivot is the sensor's position in the mesh frame; in a flattened mesh its coordinate along the flat axis is 0.
  // Without an inverse the pivot is zero.
  const glm::vec3 rounded(-(fromWorld * translation));
  const bool usable = glm::all(glm::lessThanEqual(glm::abs(rounded), glm::vec3(gpu::kCoordinateLimit)));
  const glm::vec3 pivot = usable ? rounded : glm::vec3(0);
  const glm::dmat3 rows = glm::transpose(toSensor * toWorld);
  const glm::vec3 offset(toSensor * (toWorld * glm::dvec3(pivot) + translation));
  const auto row = [&](int r) {
    return gpu::vec4{static_cast<float>(rows[r].x), static_cast<float>(rows[r].y), static_cast<float>(rows[r].z),
                     pivot[r]};
  };
  out.row0 = row(0);
  out.row1 = row(1);
  out.row2 = row(2);
  out.offset = {offset.x, offset.y, offset.z};
  out.firstTriangle = number;
}

glm::dmat3 rotationToSensor(const Pose& pose) {
  return glm::transpose(glm::mat3_cast(rotationOf(pose)));
}

// Divides numbers into sums of two floats. The rounded number is volatile because gcc 12, when it vectorizes, takes the
// double of the float of a double for that double itself.
void divide(const glm::dvec3& numbers, gpu::vec3& high, gpu::vec3& low) {
  for (int axis = 0; axis < 3; ++axis) {
    const volatile float rounded = static_cast<float>(numbers[axis]);
    high[axis] = rounded;
    low[axis] = static_cast<float>(numbers[axis] - double{rounded});
  }
}

// Compares bits, because zeros of different sign make different clouds.
template <typename T>
bool same(const T& a, const T& b) {
  return std::memcmp(&a, &b, sizeof a) == 0;
}

}  // namespace

void WorldContent::add(const MeshSummary& mesh) {
  add(WorldContent{1, mesh.groups, mesh.clusters, mesh.triangles, mesh.nonFinite, mesh.degenerate});
}

void WorldContent::add(const WorldContent& other) {
  instances += other.instances;
  groups += other.groups;
  clusters += other.clusters;
  triangles += other.triangles;
  nonFinite += other.nonFinite;
  degenerate += other.degenerate;
}

const MeshSummary& InstanceTable::meshOf(const Placement& placement) const {
  return placement.mesh == kNoMesh ? kEmpty : meshes_[placement.mesh];
}

void InstanceTable::reserveMeshes(size_t count) {
  const size_t size = meshes_.size() + count;
  makeRoom(meshes_, size);
  makeRoom(reshaped_, size);
  makeRoom(reshapedAt_, size);
}

void InstanceTable::addMesh(MeshSummary mesh) {
  meshes_.push_back(std::move(mesh));
  reshaped_.push_back(0);
  reshapedAt_.push_back(0);
}

InstanceTable::World& InstanceTable::worldWithRoom(uint32_t number) {
  const auto [entry, isNew] = worlds_.try_emplace(number);
  try {
    makeRoom(entry->second.instances, entry->second.instances.size() + 1);
  } catch (...) {
    if (isNew) worlds_.erase(entry);
    throw;
  }
  return entry->second;
}

void InstanceTable::set(size_t index, uint32_t mesh, const Transform& transform, uint32_t world) {
  const bool adds = index == placements_.size();
  const uint32_t meshBefore = adds ? kNoMesh : placements_[index].mesh;
  const bool leaves = meshBefore != kNoMesh && (mesh == kNoMesh || placements_[index].world != world);
  const bool enters = mesh != kNoMesh && (meshBefore == kNoMesh || leaves);
  if (adds) {
    makeRoom(placements_, index + 1);
    makeRoom(spheres_, index + 1);
  }
  World* to = mesh == kNoMesh ? nullptr : &worldWithRoom(world);
  if (adds) {
    placements_.emplace_back();
    placements_.back().mesh = kNoMesh;
    spheres_.emplace_back();
    numbered_ = false;
  }
  Placement& placement = placements_[index];
  const auto number = static_cast<uint32_t>(index);
  if (leaves) {
    World& from = worlds_.find(placement.world)->second;
    from.instances.erase(std::lower_bound(from.instances.begin(), from.instances.end(), number));
    from.summed = false;
    if (from.instances.empty()) worlds_.erase(placement.world);
  }
  if (enters) to->instances.insert(std::lower_bound(to->instances.begin(), to->instances.end(), number), number);
  if (placement.mesh != mesh || enters || leaves) {
    renumberedAt_ = changes_ + 1;
    placement.mesh = mesh;
    placement.world = world;
    if (to) to->summed = false;
    numbered_ = false;
  }
  const bool known = !transformSources_.has(index) && meshBefore == mesh && !enters;
  transformSources_.remove(index);
  if (put(index, transform, known, changes_ + 1)) ++changes_;
}

void InstanceTable::move(std::span<const uint32_t> instances, std::span<const Transform> transforms) {
  // Threads must not meet at one instance, nor change which instances have their transforms in a buffer.
  const bool apart = std::ranges::adjacent_find(instances, std::greater_equal()) == instances.end();
  const uint64_t threads = apart && !transformSources_.any() ? threadCount() : 1;
  std::atomic<bool> changed = false;
  inRuns(instances.size(), kInstancesPerRun, threads, [&](uint64_t first, uint64_t end) {
    bool anyOfRun = false;
    for (uint64_t i = first; i < end; ++i) {
      const bool known = !transformSources_.has(instances[i]);
      if (!known) transformSources_.remove(instances[i]);
      anyOfRun |= put(instances[i], transforms[i], known, changes_ + 1);
    }
    if (anyOfRun) changed = true;
  });
  if (changed) ++changes_;
}

// Places an instance, and notes the number of the change. Returns false, and notes nothing, if the instance was there
// before, which only a `known` one can have been.
bool InstanceTable::put(size_t index, const Transform& transform, bool known, uint64_t change) {
  Placement& placement = placements_[index];
  const Vec3& origin = meshOf(placement).origin;
  const Transform placed = transform * Transform{{1, 0, 0, origin.x, 0, 1, 0, origin.y, 0, 0, 1, origin.z}};
  const glm::dmat3 toWorld = linear(transform);
  const glm::dvec3 position = {placed.rows[3], placed.rows[7], placed.rows[11]};
  if (known && same(placement.toWorld, toWorld) && same(placement.position, position)) return false;
  placement.toWorld = toWorld;
  placement.position = position;
  placement.changedAt = change;
  placement.flat = flattens(toWorld);
  placement.mirrored = !placement.flat && glm::determinant(toWorld) < 0;
  placement.fromWorld = inverseOf(toWorld);
  spheres_[index] = sphereOf(index);
  return true;
}

void InstanceTable::setMesh(size_t mesh, MeshSummary summary) {
  meshes_[mesh] = std::move(summary);
  for (auto& [number, world] : worlds_) world.summed = false;
  reshaped_[mesh] = 1;
  reshapedAt_[mesh] = ++changes_;
  anyReshaped_ = true;
}

uint64_t InstanceTable::changedAt(size_t instance) const {
  const Placement& placement = placements_[instance];
  return placement.mesh == kNoMesh ? placement.changedAt : std::max(placement.changedAt, reshapedAt_[placement.mesh]);
}

uint64_t InstanceTable::usableTriangles(size_t instance) const {
  const MeshSummary& mesh = meshOf(placements_[instance]);
  return mesh.triangles - mesh.nonFinite - mesh.degenerate;
}

void InstanceTable::moveSpheres() {
  if (!anyReshaped_) return;
  for (size_t i = 0; i < placements_.size(); ++i)
    if (placements_[i].mesh != kNoMesh && reshaped_[placements_[i].mesh]) spheres_[i] = sphereOf(i);
  std::fill(reshaped_.begin(), reshaped_.end(), 0);
  anyReshaped_ = false;
}

// Sphere in the world around the transformed box of the mesh; around everything if only the device knows the transform.
InstanceTable::Sphere InstanceTable::sphereOf(size_t instance) const {
  const Placement& placement = placements_[instance];
  if (transformSources_.has(instance)) return {placement.position, std::numeric_limits<double>::infinity()};
  const MeshSummary& mesh = meshOf(placement);
  const glm::dvec3 centre = 0.5 * (mesh.low + mesh.high), half = 0.5 * (mesh.high - mesh.low);
  const glm::dmat3& m = placement.toWorld;
  const glm::dvec3 reach = glm::abs(m[0]) * half.x + glm::abs(m[1]) * half.y + glm::abs(m[2]) * half.z;
  return {placement.position + m * centre, glm::length(reach)};
}

const InstanceTable::World* InstanceTable::find(uint32_t world) const {
  const auto found = worlds_.find(world);
  return found == worlds_.end() ? nullptr : &found->second;
}

std::span<const uint32_t> InstanceTable::instancesOf(uint32_t world) const {
  const World* found = find(world);
  return found ? found->instances : std::span<const uint32_t>();
}

const WorldContent& InstanceTable::sumOf(const World& world) const {
  if (world.summed) return world.content;
  world.content = {};
  for (const uint32_t instance : world.instances) world.content.add(meshOf(placements_[instance]));
  world.summed = true;
  return world.content;
}

WorldContent InstanceTable::contentOf(uint32_t world) const {
  WorldContent content;
  if (const World* common = find(0)) content.add(sumOf(*common));
  if (const World* own = world == 0 ? nullptr : find(world)) content.add(sumOf(*own));
  return content;
}

uint64_t InstanceTable::mostTriangles() const {
  uint64_t most = 0;
  for (const auto& [number, world] : worlds_)
    if (number != 0) most = std::max(most, sumOf(world).triangles);
  return most + contentOf(0).triangles;
}

void InstanceTable::number() {
  if (numbered_) return;
  std::vector<uint32_t> triangles;
  triangles.reserve(placements_.size());
  for (const Placement& placement : placements_) triangles.push_back(meshOf(placement).triangles);
  numbers_.set(triangles);
  numbered_ = true;
}

// The margin exceeds the rounding errors on the device. Spheres that are not finite stay: comparisons with NaN are
// false.
bool InstanceTable::isSeen(uint32_t instance, const glm::dvec3& sensor, double reach) const {
  const Sphere& sphere = spheres_[instance];
  const glm::dvec3 away = sphere.centre - sensor;
  const double limit = (reach + sphere.radius) * 1.00001;
  return !(glm::dot(away, away) > limit * limit) && usableTriangles(instance) > 0;
}

// Marks the instances that a shot ignores. The marks go with the object.
class InstanceTable::Ignoring {
 public:
  Ignoring(InstanceTable& table, std::span<const uint32_t> instances) : marks_(table.ignored_), instances_(instances) {
    if (!instances.empty()) marks_.resize(table.count());
    mark(1);
  }
  ~Ignoring() { mark(0); }
  Ignoring(const Ignoring&) = delete;
  Ignoring& operator=(const Ignoring&) = delete;

 private:
  void mark(uint8_t as) {
    for (const uint32_t instance : instances_) marks_[instance] = as;
  }

  std::vector<uint8_t>& marks_;
  std::span<const uint32_t> instances_;
};

bool InstanceTable::isIgnored(uint32_t instance, std::span<const uint8_t> ofSensor) const {
  return (instance < ofSensor.size() && ofSensor[instance]) || (instance < ignored_.size() && ignored_[instance]);
}

void InstanceTable::findVisible(const glm::dvec3& sensor, double reach, const Selection& selection) {
  visibleStill_.clear();
  visibleMoving_.clear();
  const Ignoring ignoring(*this, selection.ignored.ofShot);
  const auto choose = [&](uint32_t world) {
    for (const uint32_t i : instancesOf(world)) {
      const bool moving = !selection.moving.empty() && selection.moving[i];
      if (!moving && !selection.still) continue;
      if (isIgnored(i, selection.ignored.ofSensor)) continue;
      if (isSeen(i, sensor, reach)) (moving ? visibleMoving_ : visibleStill_).push_back(i);
    }
  };
  choose(0);
  if (selection.world != 0) choose(selection.world);
}

PlacedGroups::Run InstanceTable::runOf(const std::vector<uint32_t>& visible, uint32_t first) const {
  PlacedGroups::Run run = {first};
  for (uint32_t i : visible) {
    const MeshSummary& mesh = meshOf(placements_[i]);
    run.groups += mesh.groups;
    run.clusters += mesh.clusters;
  }
  return run;
}

void InstanceTable::writeNumbers(gpu::Instance* instances) const {
  for (size_t i = 0; i < placements_.size(); ++i) instances[i].firstTriangle = numberOf(i);
}

void InstanceTable::writeMeshes(uint32_t* meshes) const {
  for (const Placement& placement : placements_)
    *meshes++ = std::min(placement.mesh, static_cast<uint32_t>(meshes_.size()));
}

void InstanceTable::writePairs(uint32_t* pairs) const {
  for (const std::vector<uint32_t>* visible : {&visibleStill_, &visibleMoving_})
    for (uint32_t i : *visible) {
      const MeshSummary& mesh = meshOf(placements_[i]);
      for (uint32_t group = mesh.firstGroup; group < mesh.firstGroup + mesh.groups; ++group) {
        *pairs++ = i;
        *pairs++ = group;
      }
    }
}

PlacedGroups InstanceTable::choose(const Pose& pose, double reach, const Selection& selection) {
  number();
  moveSpheres();
  findVisible(positionOf(pose), reach, selection);
  const PlacedGroups::Run still = runOf(visibleStill_, 0);
  return {still, runOf(visibleMoving_, still.groups)};
}

void InstanceTable::writeTransforms(const Pose& pose, gpu::Instance* instances) const {
  const glm::dmat3 toSensor = rotationToSensor(pose);
  const glm::dvec3 sensor = positionOf(pose);
  for (const std::vector<uint32_t>* visible : {&visibleStill_, &visibleMoving_})
    inRuns(visible->size(), kInstancesPerRun, threadCount(), [&](uint64_t first, uint64_t end) {
      for (uint64_t k = first; k < end; ++k) {
        const uint32_t i = (*visible)[k];
        if (transformSources_.has(i)) continue;
        const Placement& placement = placements_[i];
        compose(toSensor, sensor, placement.toWorld, placement.fromWorld, placement.position, numberOf(i),
                instances[i]);
      }
    });
}

PlacedGroups InstanceTable::choose(std::span<const ViewPlace> views, double reach,
                                   std::span<const uint8_t> ignoredBySensor, InViews& inViews) {
  number();
  moveSpheres();
  std::vector<InView>& entries = inViews.entries;
  entries.clear();
  inViews.runs.clear();
  PlacedGroups::Run run;
  const auto see = [&](uint32_t view, const glm::dvec3& sensor, std::span<const uint32_t> instances) {
    const auto first = static_cast<uint32_t>(entries.size());
    for (const uint32_t instance : instances) {
      if (isIgnored(instance, ignoredBySensor) || !isSeen(instance, sensor, reach)) continue;
      const MeshSummary& mesh = meshOf(placements_[instance]);
      if (mesh.groups == 0) continue;  // no beam hits it, and the next instance may have the same number
      entries.push_back({view, instance, run.groups});
      run.groups += mesh.groups;
      run.clusters += mesh.clusters;
    }
    inViews.runs.push_back({first, static_cast<uint32_t>(entries.size())});
  };
  for (uint32_t view = 0; view < views.size(); ++view) {
    const glm::dvec3 sensor = positionOf(views[view].pose);
    const Ignoring ignoring(*this, views[view].ignored);
    const uint32_t world = views[view].world;
    see(view, sensor, instancesOf(0));
    see(view, sensor, world == 0 ? std::span<const uint32_t>() : instancesOf(world));
  }
  return {run, {run.groups}};
}

void InstanceTable::writeViews(std::span<const ViewPlace> places, const InViews& inViews, gpu::Instance* instances,
                               uint32_t* views, uint32_t* pairs) const {
  inRuns(inViews.entries.size(), kInstancesPerRun, threadCount(), [&](uint64_t first, uint64_t end) {
    uint32_t view = gpu::kNone;
    glm::dmat3 toSensor;
    glm::dvec3 sensor;
    for (uint64_t k = first; k < end; ++k) {
      const auto& [inView, instance, pair] = inViews.entries[k];
      if (inView != view) {
        view = inView;
        toSensor = rotationToSensor(places[view].pose);
        sensor = positionOf(places[view].pose);
      }
      const Placement& placement = placements_[instance];
      compose(toSensor, sensor, placement.toWorld, placement.fromWorld, placement.position, numberOf(instance),
              instances[k]);
      views[k] = view;
      const MeshSummary& mesh = meshOf(placement);
      uint32_t* to = pairs + 2 * size_t{pair};
      for (uint32_t group = mesh.firstGroup; group < mesh.firstGroup + mesh.groups; ++group) {
        *to++ = static_cast<uint32_t>(k);
        *to++ = group;
      }
    }
  });
}

void InstanceTable::writeMeshes(const InViews& inViews, uint32_t* meshes) const {
  for (const InView& each : inViews.entries) *meshes++ = placements_[each.instance].mesh;
}

void InstanceTable::setTransforms(const CallerTransforms& buffer) {
  transformSources_.set(buffer);
  for (size_t i = buffer.firstInstance; i < buffer.firstInstance + buffer.instances; ++i) {
    placements_[i].changedAt = ++changes_;
    spheres_[i] = sphereOf(i);
  }
}

void InstanceTable::writeTransformSources(const Pose& pose, gpu::TransformSource* sources, gpu::CallerBuffer* buffers,
                                          gpu::TransformedInstance* instances) const {
  const glm::dmat3 rows = glm::transpose(rotationToSensor(pose));
  const glm::dvec3 sensor = positionOf(pose);
  for (const CallerTransforms& buffer : transformSources_.buffers()) {
    gpu::TransformSource source = {};
    divide(rows[0], source.row0, source.row0Low);
    divide(rows[1], source.row1, source.row1Low);
    divide(rows[2], source.row2, source.row2Low);
    divide(glm::dvec3(buffer.origin.x, buffer.origin.y, buffer.origin.z) - sensor, source.shift, source.shiftLow);
    source.stride = buffer.stride;
    source.byColumns = buffer.byColumns;
    *sources++ = source;
    *buffers++ = {buffer.address};
  }
  for (uint32_t i = 0; i < count(); ++i) {
    if (!transformSources_.has(i)) continue;
    const Vec3& origin = meshOf(placements_[i]).origin;
    gpu::TransformedInstance instance = {};
    divide({origin.x, origin.y, origin.z}, instance.origin, instance.originLow);
    instance.instance = i;
    instance.source = transformSources_.bufferOf(i);
    instance.number = transformSources_.numberOf(i);
    *instances++ = instance;
  }
}

// A change of vectors between vertices that nothing bounds: a triangle may face either way.
constexpr float kAnyChange = 1e15f;

double InstanceTable::findMotions(const Pose& pose, std::span<const InstanceMotion> motions,
                                  const std::map<size_t, double>& changes, double period, MovingInstances& to) const {
  const glm::dmat3 toSensor = rotationToSensor(pose);
  double farthest = 0;
  for (const InstanceMotion& motion : motions) {
    const Placement& placement = placements_[motion.instance];
    const MeshSummary& mesh = meshOf(placement);
    const Vec3 end = motion.end * mesh.origin;
    const glm::dmat3 turning = (linear(motion.end) - placement.toWorld) / period;
    const glm::dvec3 shift = (glm::dvec3(end.x, end.y, end.z) - placement.position) / period;
    const glm::dmat3 a = toSensor * turning;
    const glm::dvec3 b = toSensor * shift;
    const auto row = [&](int r) {
      return gpu::vec4{static_cast<float>(a[0][r]), static_cast<float>(a[1][r]), static_cast<float>(a[2][r]),
                       static_cast<float>(b[r])};
    };
    double most = 0;
    for (int corner = 0; corner < 8; ++corner) {
      const glm::dvec3 x((corner & 1) ? mesh.high.x : mesh.low.x, (corner & 2) ? mesh.high.y : mesh.low.y,
                         (corner & 4) ? mesh.high.z : mesh.low.z);
      most = std::max(most, glm::length(turning * x + shift) * period);
    }
    const glm::dmat3 change = turning * placement.fromWorld;
    const double bend =
        std::sqrt(glm::dot(change[0], change[0]) + glm::dot(change[1], change[1]) + glm::dot(change[2], change[2]));
    to[static_cast<uint32_t>(motion.instance)] = {
        row(0),
        row(1),
        row(2),
        {static_cast<float>(most * 1.00001),
         placement.flat ? kAnyChange : std::min(kAnyChange, static_cast<float>(bend * period * 1.00001)), 0, 0}};
    // An instance that may be anywhere is placed in any case, and one without usable triangles, whose box has a
    // negative width, never is.
    const double width = mesh.high.x - mesh.low.x;
    if (width >= 0 && width < 2 * double{gpu::kCoordinateLimit}) farthest = std::max(farthest, most);
  }
  for (uint32_t i = 0; i < (changes.empty() ? 0 : count()); ++i) {
    const auto change = placements_[i].mesh == kNoMesh ? changes.end() : changes.find(placements_[i].mesh);
    if (change == changes.end()) continue;
    // The distance is one of the mesh frame, and the instance's transform at the end of the scan stretches it.
    const auto moved = std::find_if(motions.begin(), motions.end(),
                                    [&](const InstanceMotion& motion) { return motion.instance == i; });
    const glm::dmat3 end = moved == motions.end() ? placements_[i].toWorld : linear(moved->end);
    const double stretch = std::sqrt(glm::dot(end[0], end[0]) + glm::dot(end[1], end[1]) + glm::dot(end[2], end[2]));
    const double most = to[i].bound.x + change->second * stretch * 1.00001;
    to[i].bound = {static_cast<float>(most * 1.00001), kAnyChange, 1, static_cast<float>(1 / period)};
    farthest = std::max(farthest, most);
  }
  return farthest;
}

}  // namespace gnosphere
