// SPDX-License-Identifier: Apache-2.0
// Binds the declarations of gnosphere/scan.hpp.
#include "scan.hpp"

#include <nanobind/stl/array.h>
#include <nanobind/stl/pair.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <locale>
#include <optional>
#include <sstream>

#include "arrays.hpp"
#include "fields.hpp"
#include "scan/coarse_points.hpp"
#include "state.hpp"
#include "whole.hpp"

namespace gnosphere::python {
namespace {

template <typename T>
nb::object columnOf(const SharedScan& self, Field field, size_t components) {
  const ColumnView<T> view = self.value->column<T>(field, 0);
  const size_t shape[] = {view.size(), components};
  const int64_t strides[] = {static_cast<int64_t>(view.stride()), 1};
  return nb::cast(
      nb::ndarray<nb::numpy, const T>(view.data(), components == 1 ? 1 : 2, shape, keeperOf(self), strides));
}

nb::object columnOfScan(const SharedScan& self, Field field) {
  const FieldInfo info = fieldInfo(field);
  return arrayOfType(info.type, [&]<typename T>() { return columnOf<T>(self, field, info.components); });
}

bool scanHasField(const SharedScan& self, Field field) {
  return self.value->has(field);
}

std::string textOf(const Scan& scan) {
  if (!scan.beamCount()) return "<Scan without beams>";
  size_t returned = 0;
  float nearest = std::numeric_limits<float>::infinity(), farthest = 0;
  for (const float range : scan.ranges) {
    if (std::isnan(range)) continue;
    ++returned;
    nearest = std::min(nearest, range);
    farthest = std::max(farthest, range);
  }
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text << "<Scan of " << (scan.sensor.empty() ? "a sensor" : scan.sensor) << ": " << scan.channels << " x "
       << scan.columns << " beams, " << returned << " returns";
  if (returned) text << " from " << nearest << " to " << farthest << " m";
  text << '>';
  return text.str();
}

/// The scan in the world frame, with a warning if its points have steps there.
SharedScan inWorldTold(const SharedScan& self) {
  SharedScan world = {std::make_shared<Scan>(inWorld(*self.value))};
  if (const std::string steps = coarsePoints(*world.value); !steps.empty())
    warnUser(steps + "; the scan's own points keep millimetres, so map them by its pose in float64");
  return world;
}

/// Calls a function of the module gnosphere.pictures.
template <typename... Arguments>
nb::object callPictures(const char* function, Arguments&&... arguments) {
  return nb::module_::import_("gnosphere.pictures").attr(function)(std::forward<Arguments>(arguments)...);
}

size_t entryOf(const Scan& scan, const Whole& given) {
  const auto entry = given.of<size_t>("entry");
  if (entry >= scan.ranges.size())
    refuse("the scan has no entry " + std::to_string(entry) + "; it has " + std::to_string(scan.ranges.size()));
  return entry;
}

void bindFields(nb::module_& m) {
  nb::enum_<Field> field(
      m, "Field",
      "The fields that a scan or a cloud file may have per return. A scan always has x, y, z, range, "
      "triangle and instance; the device 'reference' adds tie and tolerance. A scan has the other "
      "fields if SensorRequest.fields names them.");
  field.value("x", Field::x, "float32, m, sensor frame")
      .value("y", Field::y, "float32, m, sensor frame")
      .value("z", Field::z, "float32, m, sensor frame")
      .value("range", Field::range, "float32, m along the beam")
      .value("ring", Field::ring, "uint16, the beam's channel")
      .value("beam", Field::beam, "uint32, channel * columns + column")
      .value("triangle", Field::triangle, "uint32, index within the instance's mesh, NO_TRIANGLE for none")
      .value("instance", Field::instance, "uint32, index into Scene.instances, NO_TRIANGLE for none")
      .value("tie", Field::tie, "uint8, 1 if a rounding error could change the owner or the hit of the beam")
      .value("tolerance", Field::tolerance, "float32, m, the range error that single precision may show on this beam")
      .value("intensity", Field::intensity, "float32, in the units of Effects.Intensity.scale")
      .value("true_range", Field::trueRange,
             "float32, m, range without noise of what returned: a surface, or with the label scatter a particle")
      .value("cause", Field::cause, "uint8, see Cause")
      .value("label", Field::label, "uint8, see Label")
      .value("return_number", Field::returnNumber,
             "uint8, 1 for the first return of its beam, 0 for an entry without a return")
      .value("return_count", Field::returnCount, "uint8, number of returns of the beam")
      .value("width", Field::width, "float32, m, width of the echo: full width at half maximum (s) times c / 2")
      .value("normal", Field::normal, "3 float32, unit vector in the sensor frame, pointing towards the sensor")
      .value("incidence", Field::incidence,
             "float32, rad, angle between the nominal beam and the normal; 0 for a surface square to the beam")
      .value("material", Field::material, "uint32, index into Scene.materials")
      .value("barycentrics", Field::barycentrics,
             "2 float32, weights of the triangle's second and third corner; on a device NaN with a footprint, and for "
             "beams that meet a pane: their echoes are sums over several places")
      .value("class_id", Field::classId,
             "uint16, the surface's Material.class_id, else Instance.class_id, when the scan was made; 0 for none")
      .value("velocity", Field::velocity, "3 float32, m/s: the surface relative to the world, in sensor axes")
      .value("radial_speed", Field::radialSpeed,
             "float32, m/s along the beam, positive if the surface moves away from the sensor")
      .value("time", Field::time, "float32, s after the start of the scan")
      .value("azimuth", Field::azimuth, "float32, rad, azimuth of the beam, counter-clockwise from the x axis")
      .value("elevation", Field::elevation, "float32, rad, elevation of the beam above the horizon");
  static_assert(kFieldCount == 27, "every field is bound");

  nb::enum_<ValueType>(m, "ValueType", "The type of a number in memory, in the byte order of the machine.")
      .value("f32", ValueType::f32)
      .value("f64", ValueType::f64)
      .value("u8", ValueType::u8)
      .value("u16", ValueType::u16)
      .value("u32", ValueType::u32);
  nb::class_<FieldInfo>(m, "FieldInfo", "Name, type and number of components of a field.")
      .def_prop_ro(
          "name", [](const FieldInfo& self) { return std::string(self.name); }, "The name that parse_fields() takes.")
      .def_ro("type", &FieldInfo::type, "Type of the field's columns.")
      .def_ro("components", &FieldInfo::components, "3 for a vector, 2 for barycentrics, otherwise 1.");
  m.def("field_info", &fieldInfo, "field"_a.noconvert(),
        "Describes a field: the name and the type of its columns, and its number of components.");

  nb::enum_<Cause>(
      m, "Cause", nb::is_arithmetic(),
      "Why a beam has a return or none. Every beam has exactly one cause, so the counts add up to the number "
      "of beams.")
      .value("returned", Cause::returned, "The beam has at least one return.")
      .value("no_surface", Cause::noSurface, "There is no surface in range.")
      .value("weak", Cause::weak, "All echoes are below the detection threshold.")
      .value("attenuated", Cause::attenuated,
             "Below the threshold, but without fog, rain, snow and dust an echo would have been above it.")
      .value("dropped_out", Cause::droppedOut, "The return was lost at random (Effects.DropOut).")
      .value("dead", Cause::dead, "The beam is one of Effects.DropOut.dead_beams or Sensor.masked_beams.")
      .value("too_near", Cause::tooNear, "A surface nearer than the least range blocks the beam (NearHits.hide).")
      .value("not_chosen", Cause::notChosen,
             "Its echoes are detected, but Effects.Returns.mode names none that there is, such as a second one.");
  nb::enum_<Label>(m, "Label", nb::is_arithmetic(), "The origin of a return.")
      .value("none", Label::none, "No return.")
      .value("solid", Label::solid, "A surface.")
      .value("scatter", Label::scatter, "Particles of the medium: fog, rain, snow or dust.");
}

struct Count {
  const char* name;
  uint64_t Counters::*member;
  const char* doc;
};

constexpr Count kCounts[] = {
    {"beams", &Counters::beams, "Beams of the sensor."},
    {"hits", &Counters::hits, "Beams with a return."},
    {"misses", &Counters::misses, "beams - hits"},
    {"triangles", &Counters::triangles, "Triangles placed in the scene, summed over instances."},
    {"non_finite", &Counters::nonFinite, "Dropped because a vertex is NaN, infinite or beyond 1e9 m."},
    {"degenerate", &Counters::degenerate, "Dropped because two corners are the same point."},
    {"culled_by_cluster", &Counters::culledByCluster,
     "In a cluster that is out of range, between the beams or hidden."},
    {"reused", &Counters::reused,
     "Not computed again: of instances that have not moved since a scan from the same pose."},
    {"culled_by_range", &Counters::culledByRange, "The nearest point is beyond range_max."},
    {"culled_by_face", &Counters::culledByFace, "Back faces of one-sided materials."},
    {"culled_between_beams", &Counters::culledBetweenBeams, "No beam lies within the triangle's angular bounds."},
    {"culled_hidden", &Counters::culledHidden,
     "Behind the hits that all beams within the triangle's bounds already have."},
    {"projected", &Counters::projected, "Triangles that went on to binning."},
    {"candidates", &Counters::candidates, "(beam, triangle) pairs listed: with Binning.lists, footprints or panes."},
    {"integer_sides", &Counters::integerSides, "Exact inside tests that needed integer arithmetic."},
    {"integer_ranges", &Counters::integerRanges, "Exact ranges that needed integer arithmetic."},
    {"lost_echoes", &Counters::lostEchoes,
     "Echoes of beams that met more echoes, or more panes in a row, than are kept."},
    {"retries", &Counters::retries, "Runs repeated because a list had to grow."},
};
static_assert(std::size(kCounts) * sizeof(uint64_t) + sizeof(Counters::causes) == sizeof(Counters),
              "every count is bound");

using CountersState = std::pair<std::vector<uint64_t>, std::vector<uint64_t>>;  // in the order of kCounts, by Cause

CountersState stateOf(const Counters& counters) {
  CountersState state;
  for (const Count& count : kCounts) state.first.push_back(counters.*count.member);
  state.second.assign(counters.causes.begin(), counters.causes.end());
  return state;
}

void setState(Counters& counters, const CountersState& state) {
  new (&counters) Counters();
  if (state.first.size() != std::size(kCounts) || state.second.size() != counters.causes.size())
    refuse("Counters: they were pickled by another version of gnosphere");
  for (size_t i = 0; i < std::size(kCounts); ++i) counters.*kCounts[i].member = state.first[i];
  std::ranges::copy(state.second, counters.causes.begin());
}

void bindCounters(nb::module_& m) {
  nb::class_<Counters> counters(
      m, "Counters",
      "Counts of what happened to the scene's triangles and to the sensor's beams. Whatever is dropped is "
      "counted here. They are compared, copied and pickled by value.");
  for (const Count& count : kCounts) counters.def_ro(count.name, count.member, count.doc);
  counters
      .def_prop_ro(
          "causes",
          [](const Counters& self) { return tupleOf(std::vector<uint64_t>(self.causes.begin(), self.causes.end())); },
          "Beams by Cause; all zero if no effect can lose a beam.")
      .def(
          "__eq__", [](const Counters& a, const Counters& b) { return stateOf(a) == stateOf(b); }, nb::is_operator())
      .def("__getstate__", &stateOf)
      .def("__setstate__", &setState);
  counters.attr("__hash__") = nb::none();

  nb::class_<StageTime> stage(m, "StageTime", "The time of one stage of a scan.");
  bindState<&StageTime::name, &StageTime::ms>(stage);
  stage.def_ro("name", &StageTime::name, "'project', 'bin', 'resolve', 'effects' or 'records'.")
      .def_ro("ms", &StageTime::ms, "Milliseconds.");
  auto timings =
      nb::class_<Timings>(m, "Timings",
                          "Times of one scan. gpu_ms and stages come from device timestamps; without these, and on a "
                          "CPU device unless Tuning.stage_times asks for them, they are zero and empty.");
  timings
      .def_ro(
          "wall_ms", &Timings::wallMs,
          "From the submission until the results can be read on the host, without compiling kernels and without what "
          "the function given to scan_all() takes meanwhile.")
      .def_ro("gpu_ms", &Timings::gpuMs, "Milliseconds by the timestamps of the device.");
  bindState<&Timings::wallMs, &Timings::gpuMs, &Timings::stages>(timings);
  readTuple(timings, "stages", &Timings::stages, "The stage 'resolve' runs on the host if only geometry is planned.");
}

/// Defines a property that views an array of the Scan.
template <typename T>
void readArray(nb::class_<SharedScan>& type, const char* name, std::vector<T> Scan::*array, const char* doc) {
  type.def_prop_ro(
      name,
      [array](const SharedScan& self) {
        std::vector<T>& values = (*self.value).*array;
        return columnView(values.data(), values.size(), keeperOf(self));
      },
      kOwned, doc);
}

}  // namespace

void bindScan(nb::module_& m) {
  m.attr("NO_TRIANGLE") = kNoTriangle;
  nb::class_<Pose>(
      m, "Pose",
      "Position (metres) and orientation of the sensor in the world: maps the sensor frame to the world frame. "
      "It is never changed after it is made.")
      .def(
          "__init__",
          [](Pose* self, Vec3 position, Quaternion orientation) {
            new (self) Pose{position, orientation};
          },
          "position"_a = Vec3(), "orientation"_a = Quaternion(),
          "position: x, y, z in metres.\norientation: x, y, z, w of a quaternion of any length but 0, Hamilton "
          "convention.")
      .def_ro("position", &Pose::position, "x, y, z in metres.")
      .def_ro("orientation", &Pose::orientation, "x, y, z, w")
      .def("__repr__", [](const Pose& self) {
        return nb::str("Pose({}, {})").format(nb::cast(self.position), nb::cast(self.orientation));
      });
  bindFields(m);
  bindCounters(m);

  nb::class_<SharedScan> scan(
      m, "Scan", nb::is_weak_referenceable(),
      "The result of a scan. Every array and column has `returns` entries per beam: entry beam * returns + k is the "
      "beam's k-th return in order of range (k from 0), where beam = channel * columns + column. In an entry without a "
      "return `points` and `ranges` are NaN, and `triangles` and `instances` are NO_TRIANGLE.\n\nThe arrays are NumPy "
      "views of the library's memory, which each view keeps alive: also after the Scan is deleted, and after "
      "scan_into() or scan_all() has gone on, which take new memory while a view is held. So the values of a view "
      "change only if you write to them.");
  scan.def(
      nb::init<>(),
      "An empty scan, for Simulator.scan_into(). Of the fields it has those that every scan has, without entries.");
  readMember(scan, "sensor", &Scan::sensor, "The sensor's name.");
  readMember(scan, "columns", &Scan::columns, "Columns of the organised cloud.");
  readMember(scan, "channels", &Scan::channels, "Rows of the organised cloud.");
  readMember(scan, "returns", &Scan::returns, "Entries per beam.");
  readMember(scan, "pose", &Scan::pose, "The pose of the shot.");
  readMember(scan, "skewed", &Scan::skewed,
             "True if the sensor moved during the scan, and points, normals and velocities are in the frames of their "
             "columns: they are not deskewed.");
  readMember(scan, "pose_known", &Scan::poseKnown,
             "False for a cloud of a file that does not state the sensor's pose, of which only PCD does: `pose` is the "
             "identity.");
  readMember(scan, "grid_known", &Scan::gridKnown,
             "False for a list of beams in one row, which may be those of any grid, and for a cloud of a file that "
             "states one row or no grid: `columns` and `channels` are those that its rows suggest.");
  readMember(scan, "first_row_on_top", &Scan::firstRowOnTop,
             "Whether the first row (channel 0) is on top in an image of what the sensor sees. The directions of all "
             "beams decide, whatever they hit. For a cloud of a file, which does not state all its beams, the points "
             "decide.");
  readMember(scan, "first_column_on_left", &Scan::firstColumnOnLeft,
             "Whether the first column is on the left in an image of what the sensor sees. The directions of all beams "
             "decide, or for a cloud of a file the points.");
  readMember(scan, "counters", &Scan::counters, "What became of every triangle and every beam.");
  readMember(scan, "timings", &Scan::timings, "How long the scan took.");
  scan.def_prop_ro(
      "points",
      [](const SharedScan& self) {
        return rowsView<3>(self.value->points.data(), self.value->points.size() / 3, keeperOf(self));
      },
      kOwned,
      "Shape (entries, 3), float32: x, y, z in metres in the sensor frame. A view that keeps its memory alive.");
  readArray(scan, "ranges", &Scan::ranges,
            "Shape (entries,), float32: metres along the beam. A view that keeps its memory alive.");
  readArray(scan, "triangles", &Scan::triangles,
            "Shape (entries,), uint32: index within the instance's mesh. A view that keeps its memory alive.");
  readArray(scan, "instances", &Scan::instances,
            "Shape (entries,), uint32: index into Scene.instances. A view that keeps its memory alive.");
  scan.def(
          "column", [](const SharedScan& self, const FieldLike& given) { return columnOfScan(self, given.field); },
          "field"_a, nb::sig("def column(self, field: Field | str) -> numpy.typing.NDArray[typing.Any]"),
          "Returns the values of a field, shape (entries,), or (entries, components) of a vector, in the type of "
          "field_info(): a read-only view that keeps its memory alive. An entry without a value has NaN in floats "
          "other than velocities, NO_TRIANGLE in indices, and 0 in velocities and other integers. Raises "
          "Error(invalid_argument) if the scan does not have the field.")
      .def_prop_ro(
          "shape",
          [](const SharedScan& self) {
            const Scan& of = *self.value;
            return of.returns == 1 ? nb::make_tuple(of.channels, of.columns)
                                   : nb::make_tuple(of.channels, of.columns, of.returns);
          },
          nb::for_getter(nb::sig("def shape(self, /) -> tuple[int, ...]")),
          "(channels, columns), or (channels, columns, returns) if beams have several: "
          "scan[\"range\"].reshape(scan.shape) "
          "is a range image.")
      .def("__repr__", [](const SharedScan& self) { return textOf(*self.value); })
      .def(
          "_repr_html_",
          [](nb::handle_t<SharedScan> self) { return nb::cast<std::string>(callPictures("html_of", self)); },
          "What a notebook shows: a line about the scan, and its range image.")
      .def(
          "show",
          [](nb::handle_t<SharedScan> self, const nb::object& field) { return callPictures("show", self, field); },
          "field"_a = "range", nb::sig("def show(self, field: str | Field = 'range') -> typing.Any"),
          "Opens a window, or fills the cell of a notebook, with the beams and the points from above, coloured by a "
          "field. Returns the figure of Matplotlib, which is needed; see gnosphere.pictures.show(). Raises ValueError "
          "for a scan without beams.")
      .def("in_world", &inWorldTold,
           "Returns a copy with points, normals and velocities in the world frame, to which `pose` maps them; its pose "
           "is the identity. If the sensor moves during the scan, the scan must be deskewed "
           "(Effects.SensorMotion.deskew). A scan of a file that does not state the pose (pose_known) is refused. "
           "Coordinates stay float32: 1 mm apart at 8 km from the world's origin. Warns "
           "(UserWarning) if they have steps of 2 mm or more.")
      .def(
          "has", [](const SharedScan& self, const FieldLike& given) { return scanHasField(self, given.field); },
          "field"_a, "Whether column() has the field. A scan may have more fields than were requested.")
      .def(
          "beam_count", [](const SharedScan& self) { return self.value->beamCount(); },
          "Number of beams, with and without a return.")
      .def(
          "hit",
          [](const SharedScan& self, const Whole& entry) { return self.value->hit(entryOf(*self.value, entry)); },
          "entry"_a, "Whether the entry is a return from a surface; of all entries: scan.triangles != NO_TRIANGLE.")
      .def(
          "returned",
          [](const SharedScan& self, const Whole& entry) { return self.value->returned(entryOf(*self.value, entry)); },
          "entry"_a,
          "Whether the entry is a return, from a surface or from the medium; of all entries: "
          "~numpy.isnan(scan.ranges).");
  bindNames<&scanHasField, &columnOfScan>(scan, "the scan", "SensorRequest.fields asks for more");
}

}  // namespace gnosphere::python
