// SPDX-License-Identifier: Apache-2.0
// Small sensor files of every family, for the tests of the readers.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

namespace gnosphere::test {

inline constexpr std::string_view kVelodyneYaml = R"(distance_resolution: 0.002
lasers:
- {laser_id: 0, rot_correction: 0, vert_correction: 0.2, vert_offset_correction: 0, dist_correction: 1.5,
  focal_slope: 0, min_intensity: 40.0}
- {laser_id: 1, rot_correction: 0.05, vert_correction: -0.1, vert_offset_correction: 0.2,
  horiz_offset_correction: 0.026, two_pt_correction_available: true}
num_lasers: 2
)";

inline constexpr std::string_view kVeloViewXml = R"(<?xml version="1.0" encoding="UTF-8" standalone="yes" ?>
<!DOCTYPE boost_serialization>
<boost_serialization signature="serialization::archive" version="4">
<DB class_id="0" tracking_level="1" version="0" object_id="_0">
  <distLSB_>0.2</distLSB_>
  <position_><xyz><count>3</count><item>0</item><item>0</item><item>0</item></xyz></position_>
  <enabled_><count>3</count><item>1</item><item>0</item><item>1</item></enabled_>
  <points_><count>3</count><item_version>1</item_version>
    <item><px><id_>0</id_><rotCorrection_>1</rotCorrection_><vertCorrection_>2</vertCorrection_></px></item>
    <item><px><id_>1</id_><rotCorrection_>0</rotCorrection_><vertCorrection_>5</vertCorrection_></px></item>
    <item><px><id_>2</id_><rotCorrection_>-3</rotCorrection_><vertCorrection_>-7.5</vertCorrection_>
      <distCorrection_>120</distCorrection_><vertOffsetCorrection_>12.5</vertOffsetCorrection_>
      <horizOffsetCorrection_>-2.6</horizOffsetCorrection_></px></item>
  </points_>
</DB></boost_serialization>
)";

inline constexpr std::string_view kOusterFlat = R"({"prod_line": "OS-1-2", "lidar_mode": "512x20",
  "data_format": {"columns_per_frame": 512, "pixels_per_column": 2},
  "beam_altitude_angles": [4, -4], "beam_azimuth_angles": [3, -1.5], "lidar_origin_to_beam_origin_mm": 12.5,
  "lidar_to_sensor_transform": [-1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1, 36.18, 0, 0, 0, 1]})";

inline constexpr std::string_view kOusterNested = R"({"sensor_info": {"prod_line": "OS-1-2", "status": "RUNNING"},
  "config_params": {"lidar_mode": "512x20", "udp_profile_lidar": "RNG19_RFL8_SIG16_NIR16_DUAL"},
  "lidar_data_format": {"columns_per_frame": 512, "pixels_per_column": 2, "column_window": [0, 511],
    "pixel_shift_by_row": [9, -2]},
  "beam_intrinsics": {"beam_altitude_angles": [4, -4], "beam_azimuth_angles": [3, -1.5],
    "beam_to_lidar_transform": [1, 0, 0, 12.5, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]},
  "calibration_status": "error: Command not recognized.", "imu_intrinsics": {},
  "lidar_intrinsics": {"lidar_to_sensor_transform": [-1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1, 36.18, 0, 0, 0, 1]}})";

inline constexpr std::string_view kIsaacRotary = R"({"class": "sensor", "type": "lidar", "name": "two", "profile": {
  "scanType": "rotary", "rotationDirection": "CW", "nearRangeM": 1.0, "farRangeM": 100.0, "comment4": "not a figure",
  "ranges": [{"min": 0.5, "max": 200}, {"min": 2, "max": 50}], "wavelengthNm": 903.0, "azimuthErrorMean": 0.0,
  "maxReturns": 2, "scanRateBaseHz": 10.0, "reportRateBaseHz": 3333, "numberOfEmitters": 2, "emitterStateCount": 1,
  "emitterStates": [{"azimuthDeg": [6.5, -6.5], "elevationDeg": [-11.75, 3.5], "fireTimeNs": [0, 2665],
    "vertOffsetM": [0.066, 0.066], "horOffsetM": [0, 0.01], "rangeId": [0, 1], "bank": [1, 0]}]}})";

inline constexpr std::string_view kCarla = R"({"objects": [{"type": "vehicle.tesla.model3", "sensors": [
  {"type": "sensor.camera.rgb", "id": "rgb"},
  {"type": "sensor.lidar.ray_cast", "id": "top", "spawn_point": {"x": 0}, "range": 50, "channels": "4",
   "points_per_second": "4000", "upper_fov": 2.0, "lower_fov": -28.0, "rotation_frequency": 20, "horizontal_fov": 120,
   "noise_stddev": 0.0, "dropoff_general_rate": 0.45},
  {"type": "sensor.lidar.ray_cast_semantic", "id": "second"}]}]})";

/// An .npy file of numbers of that type.
inline std::string npy(const std::string& type, bool fortran, const std::vector<uint64_t>& shape,
                       const std::vector<double>& numbers) {
  std::string extents;
  for (const uint64_t extent : shape) extents += std::to_string(extent) + ", ";
  std::string header =
      "{'descr': '" + type + "', 'fortran_order': " + (fortran ? "True" : "False") + ", 'shape': (" + extents + "), }";
  header.append(63 - (9 + header.size()) % 64, ' ').append("\n");
  std::string bytes = std::string("\x93NUMPY\x01\x00", 8) + static_cast<char>(header.size()) + '\0' + header;
  const auto add = [&](auto value) {
    char item[sizeof(value)];
    std::memcpy(item, &value, sizeof(value));
    if (type[0] == '>') std::reverse(item, item + sizeof(value));
    bytes.append(item, sizeof(value));
  };
  // In Fortran's order the first index runs fastest; the tests only use it for two indices.
  for (size_t i = 0; i < numbers.size(); ++i) {
    const size_t place = fortran ? i % shape[0] * shape[1] + i / shape[0] : i;
    const double number = numbers[place];
    if (type == "<f2")
      add(static_cast<uint16_t>(number == 0 ? 0 : number < 0 ? 0xbc00 : 0x3c00));  // of 0, -1 and 1
    else if (type[1] == 'i' || type[2] == 'i')
      type.back() == '1' ? add(static_cast<int8_t>(number)) : add(static_cast<int32_t>(number));
    else if (type[2] == '4')
      add(static_cast<float>(number));
    else
      add(number);
  }
  return bytes;
}

/// Appends a number as little-endian bytes.
template <typename T>
void put(std::string& bytes, T value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof(value));
}

/// The bytes that hexadecimal digits stand for.
inline std::string bytesOfHex(std::string_view digits) {
  std::string bytes;
  for (size_t i = 0; i < digits.size(); i += 2)
    bytes += static_cast<char>(std::stoi(std::string(digits.substr(i, 2)), nullptr, 16));
  return bytes;
}

/// An angle correction of an AT128, version 1.5, with two channels and two faces, and the SHA-256 that Python computes.
inline std::string hesaiMirrors() {
  std::string bytes("\xee\xff\x01\x05\x02\x02\x02\x00\x00\x00\x00\x00\x00\x00\x00\x02", 16);
  constexpr int kUnit = 12800;  // per degree, as the resolution is 2
  for (const int degrees : {20, 140}) put<uint32_t>(bytes, static_cast<uint32_t>(kUnit * degrees));
  for (const int degrees : {140, 20}) put<uint32_t>(bytes, static_cast<uint32_t>(kUnit * degrees));
  for (const double degrees : {-2.4, 0.65}) put<int32_t>(bytes, static_cast<int32_t>(kUnit * degrees));
  for (const double degrees : {1.5, -1.5}) put<int32_t>(bytes, static_cast<int32_t>(kUnit * degrees));
  // Corrections every 2 degrees of the head; channel 0 has some at 34 and 36 degrees.
  for (const int sign : {1, -1})
    for (int i = 0; i < 2 * 180; ++i) put<int8_t>(bytes, static_cast<int8_t>(sign * (i == 17 ? 2 : i == 18 ? 4 : 0)));
  return bytes + bytesOfHex("2ea63281db7c3d5e28c8d40cdb81ed57a19b1778d035924cb76dc505452caaf6");
}

/// An angle correction of an ATX, version 4.2, with two channels.
inline std::string hesaiParity() {
  std::string bytes("\xee\xff\x04\x02\x00\x00\x02\x00\x01", 9);  // the division is 256
  for (const double degrees : {4.0, 1.0, -2.0, 1.0, 2.5, -7.5})
    put<int16_t>(bytes, static_cast<int16_t>(256 * degrees));
  return bytes + bytesOfHex("ff8a3b77bc2f411ca628fbe923a7ef0240c5561913eba481f237d65000d75075");
}

/// A file of each family, by name.
struct Sample {
  std::string name, bytes;
};

inline std::vector<Sample> samples() {
  const float pose[12] = {1, 0, 0, 0.5f, 0, 1, 0, 0.25f, 0, 0, 1, -1};
  return {{"velodyne.yaml", std::string(kVelodyneYaml)},
          {"veloview.xml", std::string(kVeloViewXml)},
          {"ouster-flat.json", std::string(kOusterFlat)},
          {"ouster-nested.json", std::string(kOusterNested)},
          {"isaac.json", std::string(kIsaacRotary)},
          {"carla.json", std::string(kCarla)},
          {"hesai.csv", "Channel,Elevation,Azimuth\n1,14.5,-1.042\n2,-3.5,1.042\n"},
          {"lidar.sdf",
           "<sdf><sensor name='a'><lidar><scan><horizontal><samples>4</samples><min_angle>-1</min_angle>"
           "<max_angle>1</max_angle></horizontal></scan><range><min>1</min><max>9</max></range></lidar>"
           "</sensor></sdf>"},
          {"helios.xml",
           "<document><scanner id='a' optics='rotating' pulseFreqs_Hz='100' headRotatePerSecMax_deg='3600'>"
           "<channels><channel><beamOrigin x='0' y='0' z='0.1'><rot axis='x' angle_deg='5'/></beamOrigin>"
           "</channel></channels></scanner></document>"},
          {"helios-lines.xml",
           "<document><scanner id='a' optics='rotating' pulseFreqs_Hz='100' scanAngleMax_deg='45' scanFreqMax_Hz='10'"
           " scanAngleEffectiveMax_deg='30' maxNOR='4'><beamOrigin z='0.1'><rot axis='x' angle_deg='5'/></beamOrigin>"
           "</scanner></document>"},
          {"helios-tripod.xml",
           "<document><scanner id='a' optics='oscillating' pulseFreqs_Hz='100' scanAngleMax_deg='45' scanFreqMin_Hz='1'"
           " scanFreqMax_Hz='10' headRotatePerSecMax_deg='60'/></document>"},
          {"lidar.usda",
           "#usda 1.0\ndef OmniLidar \"a\"\n{\n uint omni:sensor:Core:scanRateBaseHz = 10\n"
           " uint omni:sensor:Core:patternFiringRateHz = 100\n"
           " token omni:sensor:Core:scanType = \"ROTARY\"\n"
           " float[] omni:sensor:Core:emitterState:s001:azimuthDeg = [1, 2]\n"
           " float[] omni:sensor:Core:emitterState:s001:elevationDeg = [3, 4]\n}\n"},
          {"pixels.csv", "Channel,Column_id,Elevation,Azimuth\n1,1,5,80\n2,1,-5,80\n1,2,5,100\n2,2,-5,100\n"},
          {"robosense.csv", "2.31,-0.03\n47.32,-0.67\n"},
          {"halves.npy", npy("<f2", false, {2, 3}, {1, 0, 0, 0, 1, 0})},
          {"integers.npy", npy("<i4", false, {1, 3}, {1, 2, 3})},
          {"at128.dat", hesaiMirrors()},
          {"atx.dat", hesaiParity()},
          {"livox.csv", "Time/s,Azimuth/deg,Zenith/deg\n0,10,90\n0.00001,350,60\n"},
          {"poses.npy", npy("<f4", false, {1, 3, 4}, {1, 0, 0, 1, 0, 1, 0, 2, 0, 0, 1, 3})},
          {"angles.npy", npy("<f8", false, {2, 2}, {0.5, 0.25, -0.5, 0.125})},
          {"rays.mat3x4f", std::string(reinterpret_cast<const char*>(pose), sizeof(pose))},
          {"list.json", R"({"name": "list", "range": {"min": 0, "max": 50}, "patterns": [{"width": 1, "height": 2,
            "directions": [[1, 0, 0], [0, 1, 0]], "times": [0, 1e-5], "rings": [0, 7], "range_max": [10, 20]}]})"},
          {"grid.json", R"({"name": "grid", "columns": 8, "range": {"max": 5}, "elevation_deg": [-1, 1],
            "azimuth_start_deg": 60, "azimuth_span_deg": -120, "near_hits": "hide", "masked_beams": [3]})"}};
}

}  // namespace gnosphere::test
