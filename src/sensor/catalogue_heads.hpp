// SPDX-License-Identifier: Apache-2.0
// The figures of real heads, each from the documents that it names.
#pragma once

#include <cstdint>

namespace gnosphere {

/// A real head. Texts of numbers are separated by spaces; "a..b/n" stands for n evenly spaced numbers from a to b. A
/// list that is shorter than that of the elevations is repeated, and an empty one means 0.
struct HeadFigures {
  const char *name, *product, *source, *remarks;
  const char* modes;                            ///< "10Hz ..." or "COLUMNSxRATE ...", the default first
  double cycle;                                 ///< microseconds between columns; 0 if they fill the time of a scan
  double startDeg, spanDeg;                     ///< Sensor::azimuthStartDeg, azimuthSpanDeg
  double rangeMin, rangeMax, rangeAt10Percent;  ///< metres
  const char* divergence;                       ///< horizontal and vertical, milliradians
  uint32_t returns;
  bool fromBelow;  ///< whether the channels are sorted by elevation; else they are in the order of the lists
  const char *elevations, *azimuthOffsets;  ///< degrees, counter-clockwise
  const char* times;                        ///< microseconds after the column's
  double radius;          ///< millimetres from the axis to the beams' origin, towards the column's azimuth
  const char *left, *up;  ///< millimetres
};

// clang-format off
inline constexpr HeadFigures kHeads[] = {
  {"Puck", "Velodyne VLP-16",
   "VLP-16 User Manual 63-9243: angles, vertical corrections, 2.304 us per laser, 55.296 us per sequence, 100 m, "
   "3.0 x 1.5 mrad, 2 returns",
   "Range at 10 %: not stated.",
   "10Hz 5Hz 15Hz 20Hz", 55.296, 0, -360, 0, 100, 0, "3 1.5", 2, true,
   "-15 1 -13 3 -11 5 -9 7 -7 9 -5 11 -3 13 -1 15",
   "",
   "0..34.56/16",
   0, "",
   "11.2 -0.7 9.7 -2.2 8.1 -3.7 6.6 -5.1 5.1 -6.6 3.7 -8.1 2.2 -9.7 0.7 -11.2"},
  {"Puck-Hi-Res", "Velodyne VLP-16 Hi-Res (Puck Hi-Res)",
   "VLP-16 User Manual 63-9243, Table 9-1: angles and vertical corrections; timing of the VLP-16; Puck Hi-Res data "
   "sheet 63-9318: 100 m",
   "Range at 10 %: not stated. Divergence as VLP-16.",
   "10Hz 5Hz 15Hz 20Hz", 55.296, 0, -360, 0, 100, 0, "3 1.5", 2, true,
   "-10 0.667 -8.667 2 -7.333 3.333 -6 4.667 -4.667 6 -3.333 7.333 -2 8.667 -0.667 10",
   "",
   "0..34.56/16",
   0, "",
   "7.4 -0.9 6.5 -1.8 5.5 -2.7 4.6 -3.7 3.7 -4.6 2.7 -5.5 1.8 -6.5 0.9 -7.4"},
  {"VLP-32C", "Velodyne VLP-32C (Ultra Puck)",
   "ros-drivers/velodyne, params/VeloView-VLP-32C.yaml: angles; VLP-32C User Manual 63-9325: two lasers every "
   "2.304 us, 55.296 us per sequence, 200 m, 2 returns",
   "Range at 10 %: not stated. Divergence and vertical offsets: not stated there.",
   "10Hz 5Hz 15Hz 20Hz", 55.296, 0, -360, 0, 200, 0, "", 2, true,
   "-25 -1 -1.667 -15.639 -11.31 0 -0.667 -8.843 -7.254 0.333 -0.333 -6.148 -5.333 1.333 0.667 -4 -4.667 1.667 1 "
   "-3.667 -3.333 3.333 2.333 -2.667 -3 7 4.667 -2.333 -2 15 10.333 -1.333",
   "-1.4 4.2 -1.4 1.4 -1.4 1.4 -4.2 1.4 -1.4 4.2 -1.4 1.4 -4.2 1.4 -4.2 1.4 -1.4 4.2 -1.4 4.2 -4.2 1.4 -1.4 1.4 "
   "-1.4 1.4 -1.4 4.2 -4.2 1.4 -1.4 1.4",
   "0 0 2.304 2.304 4.608 4.608 6.912 6.912 9.216 9.216 11.52 11.52 13.824 13.824 16.128 16.128 18.432 18.432 "
   "20.736 20.736 23.04 23.04 25.344 25.344 27.648 27.648 29.952 29.952 32.256 32.256 34.56 34.56",
   0, "",
   ""},
  {"HDL-32E", "Velodyne HDL-32E",
   "ros-drivers/velodyne, params/32db.yaml: angles; HDL-32E User Manual 63-9113: 1.152 us per laser, 46.08 us per "
   "sequence, 100 m, 2 returns",
   "Range at 10 %: not stated. Divergence and vertical offsets: not stated there.",
   "10Hz 5Hz 15Hz 20Hz", 46.08, 0, -360, 0, 100, 0, "", 2, true,
   "-30.67 -9.33 -29.33 -8 -28 -6.67 -26.67 -5.33 -25.33 -4 -24 -2.67 -22.67 -1.33 -21.33 0 -20 1.33 -18.67 2.67 "
   "-17.33 4 -16 5.33 -14.67 6.67 -13.33 8 -12 9.33 -10.67 10.67",
   "",
   "0 1.152 2.304 3.456 4.608 5.76 6.912 8.064 9.216 10.368 11.52 12.672 13.824 14.976 16.128 17.28 18.432 19.584 "
   "20.736 21.888 23.04 24.192 25.344 26.496 27.648 28.8 29.952 31.104 32.256 33.408 34.56 35.712",
   0, "",
   ""},
  {"HDL-64E-S2", "Velodyne HDL-64E S2.1",
   "ros-drivers/velodyne, params/64e_s2.1-sztaki.yaml: the calibration of one head; HDL-64E S2 data sheet: 1.333 "
   "million points per second, 120 m",
   "Range at 10 %: not stated. Firing order and divergence: not stated there, the lasers of a column fire at "
   "once.",
   "10Hz 5Hz 15Hz 20Hz", 48, 0, -360, 0, 120, 0, "", 1, true,
   "-8.7686 -8.3563 2.4863 2.9771 -7.7823 -7.2643 -10.8608 -10.3629 -6.8605 -6.2595 -9.818 -9.3397 -2.5934 "
   "-2.0555 -5.6686 -5.1927 -1.5875 -1.1544 -4.7045 -4.1689 -0.5689 -0.2176 -3.7143 -3.1892 3.5025 4.004 0.5085 "
   "0.9769 4.4932 4.9701 1.4452 1.9718 -22.7272 -22.3575 -11.5203 -10.9457 -21.8851 -21.308 -24.8451 -24.4193 "
   "-20.8593 -20.1194 -23.8536 -23.184 -16.554 -16.1118 -19.5702 -19.1845 -15.6893 -15.1778 -18.7236 -18.2178 "
   "-14.5981 -14.0814 -17.7622 -17.112 -10.5387 -9.9943 -13.4073 -12.9743 -9.6191 -9.0717 -12.417 -12.0702",
   "-7.1559 -3.9674 4.7213 7.8958 -0.6417 2.6239 -1.8132 1.3412 5.7673 9.1653 4.7632 7.9427 -7.1952 -3.8483 "
   "-8.3531 -5.0953 -0.7452 2.6337 -1.8548 1.393 5.7464 9.0916 4.6092 7.9456 -7.165 -3.9046 -8.326 -5.1018 "
   "-0.6911 2.5149 -1.8947 1.4631 -7.626 -4.1489 4.7514 8.0251 -0.6878 2.7686 -2.053 1.5403 6.1668 9.6216 4.9341 "
   "8.6081 -7.4476 -4.016 -8.7875 -5.3164 -0.6878 2.7199 -1.9355 1.4516 6.0057 9.3459 4.8042 8.236 -7.3006 "
   "-3.9266 -8.579 -5.1415 -0.6733 2.5722 -1.9504 1.4243",
   "",
   0, "26 -26 26 -26 26 -26 26 -26 26 -26 26 -26 26 -26 26 -26 26 -26 26 -26 26 -26 26 -26 26 -26 26 -26 26 -26 26 "
   "-26 26 -26 26 -26 26 -26 26 -26 26 -26 26 -26 26 -26 26 -26 26 -26 26 -26 26 -26 26 -26 26 -26 26 -26 26 -26 "
   "26 -26",
   "195.48 196.01 209.7 210.31 196.75 197.41 192.78 193.42 197.92 198.69 194.13 194.75 203.32 203.99 199.44 "
   "200.04 204.58 205.12 200.66 201.33 205.86 206.3 201.91 202.57 210.97 211.61 207.21 207.8 212.22 212.83 208.39 "
   "209.05 108.12 108.59 121.48 122.13 109.19 109.91 105.38 105.94 110.47 111.39 106.67 107.54 115.68 116.2 "
   "112.06 112.53 116.7 117.29 113.09 113.7 117.97 118.56 114.24 115.02 122.59 123.2 119.34 119.83 123.62 124.23 "
   "120.47 120.86"},
  {"HDL-64E-S3", "Velodyne HDL-64E S3",
   "HDL-64E S3 User Manual 63-HDL64ES3: upper block in steps of 1/3 degree, lower block of 1/2, 1.3 million "
   "points per second, 120 m, 2 returns",
   "Range at 10 %: not stated. Nominal angles; rotation corrections, offsets and firing order differ from head to "
   "head: read the calibration file.",
   "10Hz 5Hz 15Hz 20Hz", 48, 0, -360, 0, 120, 0, "", 2, true,
   "2..-8.3333/32 -8.8333..-24.3333/32",
   "",
   "",
   0, "",
   ""},
  {"Alpha-Prime", "Velodyne VLS-128 (Alpha Prime)",
   "ros-drivers/velodyne, params/VLS128.yaml: angles, and 53.3 us per sequence; Isaac Sim profile "
   "Velodyne_VLS128.json: firing times and height; VLS-128 User Manual, Table F-1: 3.0 x 1.5 mrad; data sheet: 300 m, "
   "2 returns",
   "Range at 10 %: not stated. The Isaac Sim profile has azimuth offsets of the opposite sign.",
   "10Hz 5Hz 15Hz 20Hz", 53.3, 0, -360, 0, 300, 0, "3 1.5", 2, true,
   "-11.742 -1.99 3.4 -5.29 -0.78 4.61 -4.08 1.31 -6.5 -1.11 4.28 -4.41 0.1 6.48 -3.2 2.19 -3.86 1.53 -9.244 "
   "-1.77 2.74 -5.95 -0.56 4.83 -2.98 2.41 -6.28 -0.89 3.62 -5.07 0.32 7.58 -0.34 5.18 -3.64 1.75 -25 -2.43 2.96 "
   "-5.73 0.54 9.7 -2.76 2.63 -7.65 -1.55 3.84 -4.85 3.18 -5.51 -0.12 5.73 -4.3 1.09 -16.042 -2.21 4.06 -4.63 "
   "0.76 15 -3.42 1.97 -6.85 -1.33 -5.62 -0.23 5.43 -3.53 0.98 -19.582 -2.32 3.07 -4.74 0.65 11.75 -2.65 1.86 "
   "-7.15 -1.44 3.95 -2.1 3.29 -5.4 -0.01 4.5 -4.19 1.2 -13.565 -1.22 4.17 -4.52 0.87 6.08 -3.31 2.08 -6.65 1.42 "
   "-10.346 -1.88 3.51 -6.06 -0.67 4.72 -3.97 2.3 -6.39 -1 4.39 -5.18 0.21 6.98 -3.09 4.98 -3.75 1.64 -8.352 "
   "-2.54 2.85 -5.84 -0.45 8.43 -2.87 2.52 -6.17 -1.66 3.73 -4.96 0.43",
   "-6.354 -4.548 -2.732 -0.911 0.911 2.732 4.548 6.354",
   "0 0 0 0 0 0 0 0 2.665 2.665 2.665 2.665 2.665 2.665 2.665 2.665 5.33 5.33 5.33 5.33 5.33 5.33 5.33 5.33 7.995 "
   "7.995 7.995 7.995 7.995 7.995 7.995 7.995 10.66 10.66 10.66 10.66 10.66 10.66 10.66 10.66 13.325 13.325 "
   "13.325 13.325 13.325 13.325 13.325 13.325 15.99 15.99 15.99 15.99 15.99 15.99 15.99 15.99 18.655 18.655 "
   "18.655 18.655 18.655 18.655 18.655 18.655 23.985 23.985 23.985 23.985 23.985 23.985 23.985 23.985 26.65 26.65 "
   "26.65 26.65 26.65 26.65 26.65 26.65 29.315 29.315 29.315 29.315 29.315 29.315 29.315 29.315 31.98 31.98 31.98 "
   "31.98 31.98 31.98 31.98 31.98 34.645 34.645 34.645 34.645 34.645 34.645 34.645 34.645 37.31 37.31 37.31 37.31 "
   "37.31 37.31 37.31 37.31 39.975 39.975 39.975 39.975 39.975 39.975 39.975 39.975 42.64 42.64 42.64 42.64 42.64 "
   "42.64 42.64 42.64",
   0, "",
   "66.11"},
  {"OS0-32", "Ouster OS0, 32 channels",
   "OS0 data sheet, revision 7: 90 degrees, 75 m (35 m at 10 %), 0.35 degrees FWHM, 2 returns; ouster-sdk: "
   "origins 27.67 mm off the axis",
   "Beams spread evenly over the field of view; azimuth offsets differ from head to head: read the metadata of "
   "the head. Firing order in a column: not stated.",
   "1024x10 512x10 512x20 1024x20 2048x10", 0, 180, -360, 0.5, 75, 35, "10.4 10.4", 2, false,
   "45..-45/32",
   "",
   "",
   27.67, "",
   "36.18"},
  {"OS0-64", "Ouster OS0, 64 channels",
   "OS0 data sheet, revision 7: 90 degrees, 75 m (35 m at 10 %), 0.35 degrees FWHM, 2 returns; ouster-sdk: "
   "origins 27.67 mm off the axis",
   "Beams spread evenly over the field of view; azimuth offsets differ from head to head: read the metadata of "
   "the head. Firing order in a column: not stated.",
   "1024x10 512x10 512x20 1024x20 2048x10", 0, 180, -360, 0.5, 75, 35, "10.4 10.4", 2, false,
   "45..-45/64",
   "",
   "",
   27.67, "",
   "36.18"},
  {"OS0-128", "Ouster OS0, 128 channels",
   "OS0 data sheet, revision 7: 90 degrees, 75 m (35 m at 10 %), 0.35 degrees FWHM, 2 returns; ouster-sdk: "
   "origins 27.67 mm off the axis",
   "Beams spread evenly over the field of view; azimuth offsets differ from head to head: read the metadata of "
   "the head. Firing order in a column: not stated.",
   "1024x10 512x10 512x20 1024x20 2048x10", 0, 180, -360, 0.5, 75, 35, "10.4 10.4", 2, false,
   "45..-45/128",
   "",
   "",
   27.67, "",
   "36.18"},
  {"OS1-32", "Ouster OS1, 32 channels",
   "OS1 data sheet, revision 7: 45 degrees, 170 m (90 m at 10 %), 0.18 degrees FWHM, 2 returns; ouster-sdk: "
   "origins 15.806 mm off the axis",
   "Beams spread evenly over the field of view; azimuth offsets differ from head to head: read the metadata of "
   "the head. Firing order in a column: not stated.",
   "1024x10 512x10 512x20 1024x20 2048x10", 0, 180, -360, 0.5, 170, 90, "5.34 5.34", 2, false,
   "22.5..-22.5/32",
   "",
   "",
   15.806, "",
   "36.18"},
  {"OS1-64", "Ouster OS1, 64 channels",
   "OS1 data sheet, revision 7: 45 degrees, 170 m (90 m at 10 %), 0.18 degrees FWHM, 2 returns; ouster-sdk: "
   "origins 15.806 mm off the axis",
   "Beams spread evenly over the field of view; azimuth offsets differ from head to head: read the metadata of "
   "the head. Firing order in a column: not stated.",
   "1024x10 512x10 512x20 1024x20 2048x10", 0, 180, -360, 0.5, 170, 90, "5.34 5.34", 2, false,
   "22.5..-22.5/64",
   "",
   "",
   15.806, "",
   "36.18"},
  {"OS1-128", "Ouster OS1, 128 channels",
   "OS1 data sheet, revision 7: 45 degrees, 170 m (90 m at 10 %), 0.18 degrees FWHM, 2 returns; ouster-sdk: "
   "origins 15.806 mm off the axis; Isaac Sim profile OS1_REV7_128ch10hz1024res.json: angles",
   "Azimuth offsets rounded to 0.1 degrees. Firing order in a column: not stated.",
   "1024x10 512x10 512x20 1024x20 2048x10", 0, 180, -360, 0.5, 170, 90, "5.34 5.34", 2, false,
   "20.93 20.67 20.36 20 19.72 19.45 19.12 18.77 18.47 18.19 17.87 17.51 17.2 16.92 16.6 16.24 15.92 15.64 15.31 "
   "14.94 14.63 14.32 14 13.63 13.31 13 12.67 12.3 11.96 11.66 11.33 10.96 10.62 10.3 9.97 9.61 9.26 8.95 8.6 "
   "8.24 7.89 7.57 7.23 6.87 6.53 6.2 5.85 5.48 5.14 4.8 4.46 4.09 3.75 3.41 3.05 2.7 2.36 2.02 1.65 1.3 0.96 "
   "0.62 0.25 -0.09 -0.44 -0.79 -1.15 -1.49 -1.84 -2.18 -2.54 -2.88 -3.23 -3.58 -3.94 -4.28 -4.63 -4.99 -5.33 "
   "-5.67 -6.02 -6.38 -6.72 -7.07 -7.4 -7.76 -8.1 -8.44 -8.78 -9.14 -9.48 -9.8 -10.13 -10.51 -10.84 -11.17 -11.49 "
   "-11.86 -12.19 -12.51 -12.83 -13.2 -13.53 -13.84 -14.16 -14.54 -14.85 -15.15 -15.48 -15.85 -16.16 -16.46 "
   "-16.77 -17.15 -17.45 -17.75 -18.06 -18.42 -18.73 -19.01 -19.31 -19.67 -19.98 -20.25 -20.55 -20.92 -21.22 "
   "-21.48",
   "-4.2 -1.4 1.4 4.2",
   "",
   15.806, "",
   "36.18"},
  {"OS2-32", "Ouster OS2, 32 channels",
   "OS2 data sheet, revision 7: 22.5 degrees, 350 m (200 m at 10 %), 0.09 degrees FWHM, 2 returns; ouster-sdk: "
   "origins 13.762 mm off the axis",
   "Beams spread evenly over the field of view; azimuth offsets differ from head to head: read the metadata of "
   "the head. Firing order in a column: not stated.",
   "1024x10 512x10 512x20 1024x20 2048x10", 0, 180, -360, 0.8, 350, 200, "2.67 2.67", 2, false,
   "11.25..-11.25/32",
   "",
   "",
   13.762, "",
   "78.296"},
  {"OS2-64", "Ouster OS2, 64 channels",
   "OS2 data sheet, revision 7: 22.5 degrees, 350 m (200 m at 10 %), 0.09 degrees FWHM, 2 returns; ouster-sdk: "
   "origins 13.762 mm off the axis",
   "Beams spread evenly over the field of view; azimuth offsets differ from head to head: read the metadata of "
   "the head. Firing order in a column: not stated.",
   "1024x10 512x10 512x20 1024x20 2048x10", 0, 180, -360, 0.8, 350, 200, "2.67 2.67", 2, false,
   "11.25..-11.25/64",
   "",
   "",
   13.762, "",
   "78.296"},
  {"OS2-128", "Ouster OS2, 128 channels",
   "OS2 data sheet, revision 7: 22.5 degrees, 350 m (200 m at 10 %), 0.09 degrees FWHM, 2 returns; ouster-sdk: "
   "origins 13.762 mm off the axis; metadata of an OS-2-128 of firmware 2.3: azimuth offsets",
   "Beams spread evenly over the field of view; azimuth offsets differ from head to head: read the metadata of "
   "the head. Firing order in a column: not stated.",
   "1024x10 512x10 512x20 1024x20 2048x10", 0, 180, -360, 0.8, 350, 200, "2.67 2.67", 2, false,
   "11.25..-11.25/128",
   "-2.07 -0.67 0.71 2.08",
   "",
   13.762, "",
   "78.296"},
  {"PandarXT-32", "Hesai PandarXT-32",
   "HesaiLidar_SDK_2.0: PandarXT angle and firing time corrections; PandarXT user manual: 0.18 degrees at 10 Hz, "
   "0.05 to 120 m (80 m at 10 %), 2 returns",
   "Divergence: not stated there.",
   "10Hz 5Hz 20Hz", 50, 0, -360, 0.05, 120, 80, "", 2, false,
   "15..-16/32",
   "",
   "6..52.872/32",
   0, "",
   ""},
  {"Pandar64", "Hesai Pandar64",
   "tier4/nebula, calibration/Pandar64.csv: angles of one head; HesaiLidar_SDK_2.0: firing times; user manual: "
   "0.2 degrees at 10 Hz, 0.3 to 200 m at 10 %, 2 returns",
   "Divergence: not stated there.",
   "10Hz 20Hz", 55.55555556, 0, -360, 0.3, 200, 200, "", 2, false,
   "14.9 11.05 8.077 5.075 3.058 2.046 1.878 1.706 1.54 1.369 1.202 1.031 0.864 0.693 0.526 0.355 0.187 0.018 "
   "-0.151 -0.319 -0.49 -0.657 -0.827 -0.995 -1.166 -1.333 -1.504 -1.67 -1.842 -2.01 -2.18 -2.347 -2.518 -2.682 "
   "-2.855 -3.022 -3.192 -3.357 -3.53 -3.694 -3.866 -4.032 -4.203 -4.367 -4.54 -4.702 -4.874 -5.039 -5.211 -5.373 "
   "-5.547 -5.708 -5.88 -6.043 -7.045 -8.041 -9.042 -10.027 -11.014 -11.988 -12.956 -13.912 -18.871 -24.879",
   "1.042 1.042 1.042 1.042 1.042 1.042 -1.042 -3.125 -5.208 5.208 3.125 1.042 -1.042 -3.125 -5.208 5.208 3.125 "
   "1.042 -1.042 -3.125 -5.208 5.208 3.125 1.042 -1.042 -3.125 -5.208 5.208 3.125 1.042 -1.042 -3.125 -5.208 "
   "5.208 3.125 1.042 -1.042 -3.125 -5.208 5.208 3.125 1.042 -1.042 -3.125 -5.208 5.208 3.125 1.042 -1.042 -3.125 "
   "-5.208 5.208 3.125 1.042 1.042 1.042 1.042 1.042 1.042 1.042 1.042 1.042 1.042 1.042",
   "-23.18 -21.876 -20.572 -19.268 -17.964 -16.66 -11.444 -46.796 -7.532 -36.956 -50.732 -54.668 -40.892 -44.828 "
   "-31.052 -34.988 -48.764 -52.7 -38.924 -42.86 -29.084 -33.02 -46.796 -25.148 -36.956 -50.732 -27.116 -40.892 "
   "-44.828 -31.052 -34.988 -48.764 -25.148 -38.924 -42.86 -29.084 -33.02 -52.7 -6.228 -54.668 -15.356 -27.116 "
   "-10.14 -23.18 -4.924 -21.876 -14.052 -17.964 -8.836 -19.268 -3.62 -20.572 -12.748 -16.66 -7.532 -11.444 "
   "-6.228 -15.356 -10.14 -4.924 -3.62 -14.052 -8.836 -12.748",
   0, "",
   ""},
  {"Pandar128", "Hesai Pandar128E4X",
   "tier4/nebula, calibration/Pandar128E4X.csv: angles of one head; user manual: 0.2 degrees at 10 Hz, 0.3 to 200 "
   "m at 10 %, 2 returns",
   "Firing times differ from column to column and are not stated there. Divergence: not stated there.",
   "10Hz 20Hz", 55.55555556, 0, -360, 0.3, 200, 200, "", 2, false,
   "15.139 13.432 11.919 10.634 9.967 9.3 8.621 7.945 7.595 7.244 6.905 6.55 6.193 5.843 5.482 5.116 4.768 4.402 "
   "4.04 3.68 3.314 2.94 2.58 2.203 2.081 1.967 1.844 1.71 1.596 1.474 1.333 1.23 1.109 0.97 0.856 0.734 0.597 "
   "0.477 0.361 0.217 0.102 -0.012 -0.146 -0.272 -0.387 -0.522 -0.649 -0.757 -0.899 -1.018 -1.135 -1.272 -1.397 "
   "-1.512 -1.648 -1.777 -1.884 -2.028 -2.146 -2.261 -2.397 -2.526 -2.639 -2.775 -2.894 -3.016 -3.154 -3.271 "
   "-3.394 -3.534 -3.644 -3.768 -3.913 -4.022 -4.149 -4.285 -4.405 -4.52 -4.662 -4.777 -4.896 -5.043 -5.155 "
   "-5.272 -5.419 -5.539 -5.654 -5.806 -5.907 -6.288 -6.669 -7.039 -7.416 -7.794 -8.173 -8.546 -8.915 -9.295 "
   "-9.666 -10.041 -10.414 -10.785 -11.15 -11.521 -11.895 -12.26 -12.638 -12.992 -13.368 -13.727 -14.096 -14.451 "
   "-14.806 -15.167 -15.517 -15.881 -16.233 -16.585 -16.934 -17.288 -17.642 -18.332 -19.005 -19.665 -20.318 "
   "-21.598 -22.989 -24.71",
   "-0.157 -0.129 -1.258 -1.247 -0.145 -0.123 -0.1 -0.078 -1.338 -1.316 -1.298 -1.28 -1.282 -1.334 -1.314 -1.363 "
   "-0.141 -0.099 -0.171 -0.15 -0.115 -0.097 -0.166 -0.123 3.092 -1.374 -4.55 3.071 -1.362 -4.542 3.033 -1.385 "
   "-4.535 3.053 -1.33 -4.609 3.085 -1.314 -4.528 3.064 -0.15 -2.981 1.431 -0.173 -2.954 1.445 -0.139 -2.941 "
   "1.478 -0.161 -3.027 1.455 -0.131 -3.015 1.495 -0.115 -2.985 1.47 -0.202 -3.012 1.505 -0.188 -2.975 1.521 "
   "-1.399 -4.636 3.055 -1.374 -4.623 3.068 -1.382 -4.595 3.078 -1.336 -4.621 3.093 -1.351 -4.587 3.104 -1.358 "
   "-4.613 3.119 -1.407 -4.677 3.126 -1.421 -4.665 3.147 -0.198 -0.194 -0.171 -0.178 -0.148 -0.149 -0.123 -0.126 "
   "-1.427 -1.408 -1.433 -1.386 -1.411 -1.385 -1.363 -1.362 -0.2 -0.179 -0.154 -0.133 -0.217 -0.194 -0.169 -0.147 "
   "-1.568 -1.59 -1.516 -1.536 -1.584 -1.557 -1.509 -1.533 -0.361 -0.336 -0.313 -0.285 -1.59 -1.551 -0.312 -0.302",
   "",
   0, "",
   ""},
  {"OT128", "Hesai OT128",
   "HesaiLidar_SDK_2.0, OT128 angle correction: angles; user manual: 0.2 degrees at 10 Hz, 0.3 to 200 m at 10 %, "
   "2 returns",
   "Firing times alternate with the columns: read the angle correction with the file of firing times. Divergence: "
   "not stated there.",
   "10Hz 20Hz", 55.55555556, 0, -360, 0.3, 200, 200, "", 2, false,
   "14.985 13.283 11.758 10.483 9.836 9.171 8.496 7.812 7.462 7.115 6.767 6.416 6.064 5.71 5.355 4.998 4.643 "
   "4.282 3.921 3.558 3.194 2.829 2.463 2.095 1.974 1.854 1.729 1.609 1.487 1.362 1.242 1.12 0.995 0.875 0.75 "
   "0.625 0.5 0.375 0.25 0.125 0 -0.125 -0.25 -0.375 -0.5 -0.626 -0.751 -0.876 -1.001 -1.126 -1.251 -1.377 -1.502 "
   "-1.627 -1.751 -1.876 -2.001 -2.126 -2.251 -2.376 -2.501 -2.626 -2.751 -2.876 -3.001 -3.126 -3.251 -3.376 "
   "-3.501 -3.626 -3.751 -3.876 -4.001 -4.126 -4.25 -4.375 -4.501 -4.626 -4.751 -4.876 -5.001 -5.126 -5.252 "
   "-5.377 -5.502 -5.626 -5.752 -5.877 -6.002 -6.378 -6.754 -7.13 -7.507 -7.882 -8.257 -8.632 -9.003 -9.376 "
   "-9.749 -10.121 -10.493 -10.864 -11.234 -11.603 -11.975 -12.343 -12.709 -13.075 -13.439 -13.803 -14.164 "
   "-14.525 -14.879 -15.237 -15.593 -15.948 -16.299 -16.651 -17 -17.347 -17.701 -18.386 -19.063 -19.73 -20.376 "
   "-21.653 -23.044 -24.765",
   "-0.186 -0.185 -1.335 -1.343 -0.148 -0.147 -0.146 -0.146 -1.335 -1.336 -1.337 -1.338 -1.339 -1.34 -1.341 "
   "-1.342 -0.128 -0.128 -0.127 -0.127 -0.107 -0.106 -0.105 -0.105 3.118 -1.315 -4.529 3.121 -1.316 -4.532 3.124 "
   "-1.317 -4.536 3.127 -1.317 -4.539 3.13 -1.318 -4.542 3.133 -0.103 -2.935 1.517 -0.103 -2.937 1.519 -0.103 "
   "-2.939 1.52 -0.103 -2.941 1.521 -0.102 -2.943 1.523 -0.102 -2.945 1.524 -0.102 -2.946 1.526 -0.102 -2.948 "
   "1.526 -1.324 -4.57 3.155 -1.325 -4.573 3.157 -1.326 -4.575 3.159 -1.326 -4.578 3.161 -1.327 -4.581 3.163 "
   "-1.328 -4.583 3.165 -1.329 -4.586 3.167 -1.329 -4.588 3.168 -0.102 -0.103 -0.103 -0.103 -0.104 -0.104 -0.104 "
   "-0.104 -1.337 -1.337 -1.338 -1.339 -1.34 -1.341 -1.341 -1.342 -0.108 -0.108 -0.109 -0.109 -0.13 -0.131 -0.131 "
   "-0.132 -1.384 -1.384 -1.385 -1.385 -1.386 -1.386 -1.387 -1.387 -0.151 -0.153 -0.154 -0.156 -1.388 -1.408 "
   "-0.196 -0.286",
   "",
   0, "",
   ""},
  {"QT64", "Hesai PandarQT64",
   "tier4/nebula, calibration/PandarQT64.csv: angles; user manual: 0.6 degrees at 10 Hz, 0.1 to 60 m (20 m at 10 "
   "%), 2 returns; AWSIM: origins 29.8 mm off the axis and 50.4 mm up",
   "The direction of the horizontal offset is not stated; it is left out. Divergence and firing times: not stated "
   "there.",
   "10Hz 20Hz", 166.6666667, 0, -360, 0.1, 60, 20, "", 2, false,
   "-52.121 -49.785 -47.577 -45.477 -43.465 -41.528 -39.653 -37.831 -36.055 -34.32 -32.619 -30.95 -29.308 -27.69 "
   "-26.094 -24.517 -22.964 -21.42 -19.889 -18.372 -16.865 -15.368 -13.88 -12.399 -10.925 -9.457 -7.994 -6.535 "
   "-5.079 -3.626 -2.175 -0.725 0.725 2.175 3.626 5.079 6.534 7.993 9.456 10.923 12.397 13.877 15.365 16.861 "
   "18.368 19.885 21.415 22.959 24.524 26.101 27.697 29.315 30.957 32.627 34.328 36.064 37.84 39.662 41.537 "
   "43.475 45.487 47.587 49.795 52.133",
   "-8.736 -8.314 -7.964 -7.669 -7.417 -7.198 -7.007 -6.838 -6.688 -6.554 -6.434 -6.326 -6.228 -6.14 -6.059 "
   "-5.987 5.27 5.216 5.167 5.123 5.083 5.047 5.016 4.988 4.963 4.942 4.924 4.91 4.898 4.889 4.884 4.881 -5.493 "
   "-5.496 -5.502 -5.512 -5.525 -5.541 -5.561 -5.584 -5.611 -5.642 -5.676 -5.716 -5.759 -5.808 -5.862 -5.921 5.33 "
   "5.396 5.469 5.55 5.64 5.74 5.85 5.974 6.113 6.269 6.447 6.651 6.887 7.163 7.493 7.892",
   "",
   0, "",
   "50.4"},
  {"QT128", "Hesai QT128",
   "QT128 user manual: 105.2 degrees, 0.4 degrees at 10 Hz, 0.05 to 50 m (20 m at 10 %), 2 returns",
   "Beams spread evenly over the field of view; the angles of a head are in its angle correction. Divergence and "
   "firing times: not stated here.",
   "10Hz 20Hz", 111.1111111, 0, -360, 0.05, 50, 20, "", 2, false,
   "52.6..-52.6/128",
   "",
   "",
   0, "",
   ""},
  {"AT128", "Hesai AT128",
   "tier4/nebula, calibration/PandarAT128.csv: angles; user manual: 120 degrees in steps of 0.1 at 10 Hz, 0.5 to "
   "200 m at 10 %, 2 returns",
   "Nominal angles; the mirrors of a head that turns 200 times a minute double its angle, so the columns take "
   "half the time of a scan. The correction of each mirror face is in the head's .dat file.",
   "1200x10", 41.66666667, 60, -120, 0.5, 200, 200, "", 2, false,
   "12.93..-12.47/128",
   "-2.4 0.65 -2.4 0.65 -2.4 0.65 -2.4 0.65 -2.4 0.65 -2.4 0.65 -2.4 0.65 -2.4 0.65 2.4 -0.65 2.4 -0.65 2.4 -0.65 "
   "2.4 -0.65 2.4 -0.65 2.4 -0.65 2.4 -0.65 2.4 -0.65",
   "",
   0, "",
   ""},
  {"RS-LiDAR-16", "RoboSense RS-LiDAR-16",
   "RS-LiDAR-16 user manual: 30 degrees in steps of 2, 0.2 degrees at 10 Hz, 0.4 to 150 m",
   "Range at 10 %, divergence, vertical offsets: not stated there. Firing times are left out.",
   "10Hz 5Hz 20Hz", 55.55555556, 0, -360, 0.4, 150, 0, "", 1, false,
   "-15..15/16",
   "",
   "",
   0, "",
   ""},
  {"RS-Bpearl", "RoboSense RS-Bpearl",
   "RS-Bpearl user manual: 360 x 90 degrees, 32 channels in steps of 2.81 degrees, 0.2 degrees at 10 Hz, 0.1 to "
   "30 m (10 %)",
   "Spread evenly over the hemisphere above. Divergence and firing times: not stated here.",
   "10Hz 20Hz", 55.55555556, 0, -360, 0.1, 30, 30, "", 1, false,
   "2.3125..89.5/32",
   "",
   "",
   0, "",
   ""},
  {"RS-Helios-32", "RoboSense RS-Helios-32 (5515)",
   "RS-Helios-5515 User Guide V3.0.1, Table 5 and section 7.2: vertical angles and firing times, 55.56 us per "
   "sequence, 0.2 degrees at 10 Hz, 2 returns; MRPT/mvsim, helios-32-FOV-70: angles to 0.001 degrees, 0.2 to 110 m",
   "Range at 10 %, divergence, origins: not stated there. Horizontal corrections differ from head to head.",
   "10Hz 5Hz 20Hz", 55.55555556, 0, -360, 0.2, 110, 0, "", 2, true,
   "15 12.929 10.841 8.754 6.667 5.333 4 2.667 1.333 0 -1.333 -2.667 -4 -5.333 -6.667 -8 -10.939 -13.877 -16.816 "
   "-19.755 -22.694 -25.632 -28.571 -31.51 -34.449 -37.387 -40.326 -43.265 -46.204 -49.142 -52.081 -55.02",
   "",
   "0 1.57 3.15 4.72 6.3 7.87 9.45 11.36 13.26 15.17 17.08 18.99 20.56 22.14 23.71 25.29 26.53 27.77 29.01 30.25 "
   "31.49 32.73 33.98 35.22 36.46 37.7 38.94 40.18 41.42 42.67 43.91 45.15",
   0, "",
   ""},
  {"RS-Helios-1615", "RoboSense RS-Helios-32 (1615)",
   "MRPT/mvsim, helios-32-FOV-31: angles from 15 to -16 degrees in steps of 1, 0.2 to 110 m; RS-Helios-5515 User Guide "
   "V3.0.1: firing times, 55.56 us per sequence, 0.2 degrees at 10 Hz, 2 returns",
   "The firing times are those of the 5515. Range at 10 %, divergence, origins: not stated there. Horizontal "
   "corrections differ from head to head.",
   "10Hz 5Hz 20Hz", 55.55555556, 0, -360, 0.2, 110, 0, "", 2, true,
   "15..-16/32",
   "",
   "0 1.57 3.15 4.72 6.3 7.87 9.45 11.36 13.26 15.17 17.08 18.99 20.56 22.14 23.71 25.29 26.53 27.77 29.01 30.25 "
   "31.49 32.73 33.98 35.22 36.46 37.7 38.94 40.18 41.42 42.67 43.91 45.15",
   0, "",
   ""},
  {"RS-Ruby-Plus", "RoboSense RS-Ruby Plus",
   "RS-Ruby Plus User Manual 1.0.4, section 6: 128 lasers from -25 to 15 degrees, 55.56 us per sequence; rs_driver, "
   "decoder_RSP128.hpp: 1 to 250 m, 2 returns, origins 28.92 mm off the axis",
   "Evenly spread, where the lasers of a head are denser about the horizon; the head states its angles when it runs. "
   "Firing times belong to these angles and are left out. Range at 10 %, divergence: not stated there.",
   "10Hz 20Hz", 55.55555556, 0, -360, 1, 250, 0, "", 2, true,
   "15..-25/128",
   "",
   "",
   28.92, "",
   ""},
  {"TiM781", "SICK TiM781",
   "Isaac Sim profile SICK_tim781.json: 270 degrees in 811 beams, 82.203 us apart, 15 Hz, 0.05 to 25 m",
   "One layer; it turns counter-clockwise, as SICK's drivers count. Range at 10 %: not stated (5 m at 5 %). "
   "Divergence: not stated there.",
   "811x15", 82.203, -135, 270.333333333333, 0.05, 25, 0, "", 1, false,
   "0",
   "",
   "",
   0, "",
   ""},
  {"Waymo-Top", "Waymo Open Dataset, the lidar on the roof",
   "Sun et al., Scalability in Perception for Autonomous Driving, 2020, Table 2: 64 beams, -17.6 to 2.4 degrees, "
   "75 m, 2 returns; range images of 64 x 2650",
   "Like the head of the data set: evenly spread, where the real inclinations differ from vehicle to vehicle.",
   "2650x10", 0, 0, -360, 0, 75, 0, "", 2, false,
   "2.4..-17.6/64",
   "",
   "",
   0, "",
   ""},
  {"nuScenes", "nuScenes, the lidar on the roof (HDL-32E)",
   "Caesar et al., nuScenes, 2020, Table 2: 32 beams, 20 Hz, 1.4 million points per second at most, usable to 70 "
   "m; angles of the HDL-32E",
   "Like the head of the data set. Firing order as HDL-32E.",
   "20Hz", 46.08, 0, -360, 0, 70, 0, "", 1, false,
   "-30.67..10.67/32",
   "",
   "",
   0, "",
   ""},
};
// clang-format on

}  // namespace gnosphere
