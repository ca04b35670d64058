// SPDX-License-Identifier: Apache-2.0
// A drive: the content of a drive file and of all files that it names.
#pragma once

#include <algorithm>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "drive/trajectory.hpp"
#include "gnosphere/gnosphere.hpp"
#include "gnosphere/ros2.hpp"

namespace gnosphere::drive {

struct Class {
  std::string name;
  uint16_t id = 0;
  uint16_t movingId = 0;  ///< in SemanticKITTI labels of an actor that moves
};

/// A clip that a scene or an actor shows. Its time is offset + speed * seconds since the start of the drive.
struct Animation {
  size_t clip = 0;  ///< index into SceneAnimation::clips
  double speed = 1, offset = 0;
  ClipEnd end = ClipEnd::loop;
};

struct Actor {
  std::string name;
  size_t model = 0;          ///< index into Drive::models
  size_t category = 0;       ///< index into Drive::classes
  std::optional<Vec3> size;  ///< length, width and height that the model is scaled to
  Vec3 scale = {1, 1, 1};    ///< the factors along the axes of the model that give it this size
  Trajectory trajectory;
  std::optional<Animation> animation;
  bool goneOutside = false;  ///< whether it is absent, rather than still, outside the trajectory's time
};

/// A sensor on the vehicle.
struct RigSensor {
  std::string name;
  Sensor sensor;
  Effects effects;
  Pose mount;                   ///< in the vehicle's frame
  double rate = 10;             ///< scans a second
  double offset = 0;            ///< seconds after the start of the drive at which scan 0 starts
  std::vector<size_t> ignores;  ///< indices into Drive::actors: the actors that it does not see, such as its vehicle
  bool livoxCustom = false;     ///< whether clouds for ROS 2 are Livox's own message
  std::optional<ros2::Driver> driver;  ///< whose point layout clouds for ROS 2 have; none: GnoSphere's own

  bool isIgnored(size_t actor) const { return std::ranges::find(ignores, actor) != ignores.end(); }
};

/// An inertial measurement unit (IMU) on the vehicle.
struct InertialUnit {
  std::string name;
  Pose mount;         ///< in the vehicle's frame
  double rate = 200;  ///< measurements a second
};

struct WeatherStamp {
  double time = 0;            ///< seconds after the start of the drive
  double fog = 0;             ///< 1/m, the inverse of the visibility
  double rain = 0, snow = 0;  ///< mm/h
};

/// The kinds of weather that any entry of the drive's weather states. A sensor's effects decide about the others.
struct WeatherKinds {
  bool fog = false, rain = false, snow = false;
};

struct Output {
  std::string format, folder;
  std::vector<size_t> sensors;  ///< indices into Drive::sensors
  std::vector<Field> fields;
  uint64_t keyframes = 5;
  bool compact = true;               ///< whether clouds have rows of returns alone, rather than of every beam
  std::string version;               ///< of nuScenes: the folder of the tables
  bool lidarseg = false;             ///< of nuScenes: whether the points of key frames have the classes of lidarseg
  std::optional<uint64_t> sequence;  ///< number of KITTI's sequence or drive; none: that of the format
  bool allActors = false;            ///< whether actors have boxes that no beam has hit
  std::string crs;                   ///< WKT of the world's coordinate reference system; empty if the drive states none
  uint16_t flightLine = 0;           ///< that of the first sensor, the others follow; 0 if the drive states none
  bool oneFile = false;              ///< whether a sensor has one file of the whole drive, rather than one per scan
  double scale = 0.001;              ///< metres per unit of a coordinate
  bool sourcePerScan = false;        ///< whether the point source is the number of the scan, from 1
};

struct Drive {
  std::string name;   ///< in data sets; one in which mistakeOfName() finds no mistake
  uint64_t seed = 1;  ///< of the random numbers of all sensors whose effects state none
  double rate = 10, start = 0, duration = 0, epoch = 0;
  std::vector<std::string> simulator;  ///< options of the simulator, as assign() takes them
  std::vector<Class> classes;
  std::vector<Scene> scenes;                              ///< placed in the world; their instances have their classes
  std::vector<std::optional<Animation>> sceneAnimations;  ///< by scene
  std::vector<Scene> models;                              ///< in the actor's frame
  std::vector<std::string> modelNames;                    ///< of the models that the drive file names, which come first
  MaterialTable materials;                                ///< for the materials of all scenes and models
  std::vector<Actor> actors;
  Trajectory ego;
  std::vector<RigSensor> sensors;
  std::optional<InertialUnit> imu;
  std::string worldFrame = "map", vehicleFrame = "base_link";  ///< names of the frames in ROS 2
  std::vector<WeatherStamp> weather;
  WeatherKinds weatherKinds;
  std::vector<Output> outputs;
  std::vector<std::string> warnings;  ///< remarks for the user about probable mistakes
  /// The files that were read, by their paths from the folder of the drive file.
  std::map<std::string, std::filesystem::path> inputs;
  std::string file;         ///< the content of the drive file as JSON, with the name and the seed that count
  std::string fingerprint;  ///< hash of the drive file and of everything that was read for it

  uint64_t frameCount() const;
  /// The pose of a sensor at a time of the trajectories' clock.
  Pose sensorPose(size_t sensor, double time) const;
  /// The weather at a time of the trajectories' clock; none if the drive has no weather.
  std::optional<Weather> weatherAt(double time) const;
};

/// Returns why files of a data set cannot have this name of a drive, a sensor or an inertial unit in theirs, or an
/// empty text. Data sets are exchanged, so a name must suit every system.
std::string mistakeOfName(const std::string& name);

/// Reads a drive file and the files that it names. A `seed` and a `name` replace those of the file, as if the file
/// stated them. Throws Error(format) that lists the mistakes with their JSON paths, or Error(file).
Drive readDrive(const std::filesystem::path& file, std::optional<uint64_t> seed = {},
                const std::optional<std::string>& name = {});

}  // namespace gnosphere::drive
