// SPDX-License-Identifier: Apache-2.0
// The figures of real heads, each from the documents that it names.
#pragma once

#include <cstdint>

namespace gnosphere {

/// Figures of a real head. Texts of numbers are separated by spaces; "a..b/n" stands for n evenly spaced numbers from a
/// to b. A list that is shorter than that of the elevations is repeated, and an empty one means 0.
struct HeadFigures {
  const char *name, *product, *source, *remarks;
  const char* modes;                            ///< "10Hz ..." or "COLUMNSxRATE ...", the default first
  double cycle;                                 ///< microseconds between columns; 0 if they fill the time of a scan
  double startDeg, spanDeg;                     ///< Sensor::azimuthStartDeg, azimuthSpanDeg of the default mode
  double rangeMin, rangeMax, rangeAt10Percent;  ///< metres
  const char* divergence;                       ///< horizontal and vertical, milliradians
  uint32_t returns;
  bool fromBelow;  ///< whether the channels are sorted by elevation; else they are in the order of the lists
  const char *elevations, *azimuthOffsets;  ///< degrees, counter-clockwise
  const char* times;                        ///< microseconds after the column's
  double radius;          ///< millimetres from the axis to the beams' origin, towards the column's azimuth
  const char *left, *up;  ///< millimetres; a head of Velodyne with `tilted` has `up` at right angles to the beam
  /// 1 for a laser that rests in columns 0, 2, 4 ..., 2 for one that rests in the others, 0 for one that always fires.
  const char* rests = "";
  bool tilted = false;
};

// clang-format off
/// Angles of one Pandar128E3X in degrees, which are the same in each of its resolutions.
inline constexpr char kPandar128E3XElevations[] =
   "14.436 13.535 13.0818 12.624 12.1652 11.702 11.2385 10.771 10.305 9.83 9.3561 8.88 8.4013 7.921 7.4381 6.9526 "
   "6.4669 5.9778 5.487 4.9958 4.501 4.0073 3.509 3.0128 2.512 2.013 1.885 1.761 1.637 1.511 1.3859 1.2582 1.13 "
   "1.0085 0.88 0.756 0.63 0.505 0.3786 0.251 0.124 -0.0001 -0.129 -0.2541 -0.38 -0.5061 -0.6323 -0.7598 -0.8872 "
   "-1.0122 -1.141 -1.2662 -1.393 -1.5193 -1.6463 -1.7733 -1.9006 -2.0269 -2.155 -2.2815 -2.409 -2.5349 -2.6625 "
   "-2.789 -2.9161 -3.0437 -3.172 -3.299 -3.425 -3.5522 -3.6803 -3.8063 -3.933 -4.0618 -4.19 -4.318 -4.444 -4.5705 "
   "-4.6991 -4.8243 -4.9506 -5.0806 -5.209 -5.336 -5.463 -5.5891 -5.718 -5.8425 -5.9682 -6.0997 -6.6073 -7.1173 "
   "-7.6243 -8.1338 -8.6396 -9.149 -9.6524 -10.16 -10.6654 -11.17 -11.6716 -12.174 -12.6732 -13.173 -13.6697 -14.166 "
   "-14.6604 -15.154 -15.6448 -16.135 -16.6222 -17.1061 -17.5922 -18.072 -18.5477 -19.0296 -19.5007 -19.9785 "
   "-20.4448 -20.9181 -21.3794 -21.8481 -22.3042 -22.7681 -23.2188 -23.6776 -24.1227 -25.0158";
inline constexpr char kPandar128E3XAzimuths[] =
   "-3.257 -3.263 -1.0914 -3.268 -1.0925 -3.273 -1.0936 -3.278 -1.0948 -3.283 -1.0959 -3.288 -1.0971 -3.291 -1.0984 "
   "1.1011 -1.0997 1.1036 3.306 1.1061 3.311 1.1085 3.318 1.1109 3.324 1.1131 -7.72 -5.535 -3.325 3.33 -1.1067 5.538 "
   "7.7261 1.1153 -7.731 -5.543 -3.329 3.336 -1.1082 5.5468 7.7382 1.1174 -7.743 -5.5508 -3.335 3.3418 -1.1098 "
   "5.5554 7.75 1.1195 -7.757 -5.5599 -3.34 3.3473 -1.1113 5.5644 7.7625 1.1215 -7.768 -5.5689 -3.345 3.3528 -1.113 "
   "5.5733 7.7748 1.1234 -7.78 -5.5777 -3.351 3.3582 -1.1146 5.5821 7.7869 1.1252 -7.792 -5.5864 -3.356 3.3634 "
   "-1.1163 5.5908 7.7988 1.127 -7.804 -5.595 -3.36 3.3686 -1.118 5.5993 7.8106 1.1286 3.3736 1.1303 3.3786 1.1318 "
   "3.3834 -3.381 3.3881 -3.386 -1.1271 -3.39 -1.129 -3.395 -1.131 -3.401 -1.1331 -3.406 -1.1352 -3.41 -1.1373 "
   "-3.416 -1.1394 1.1423 -1.1416 1.1431 3.4257 1.1439 3.4293 1.1445 3.4328 1.1451 3.4362 1.1457 3.4395 1.1461 "
   "3.4427 1.1465 3.4458 3.4487";

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
   "120.47 120.86",
   "", true},
  {"HDL-64E-S3", "Velodyne HDL-64E S3",
   "HDL-64E S3 User Manual 63-HDL64ES3: upper block in steps of 1/3 degree, lower block of 1/2, 120 m, 2 returns; "
   "ros-drivers/velodyne, driver.cc: 2,222,220 points per second of both returns, 57.6 us per sequence",
   "Range at 10 %: not stated. Nominal angles; rotation corrections, offsets and firing order differ from head to "
   "head: read the calibration file.",
   "10Hz 5Hz 15Hz 20Hz", 57.6, 0, -360, 0, 120, 0, "", 2, true,
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
  {"Pandar128E4X", "Hesai Pandar128E4X",
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
  {"Pandar128E3X", "Hesai Pandar128E3X, standard resolution",
   "HesaiLidar_Swift_ROS, params: correction.csv, angles of one head, and laser-ts.csv, firing times of operation "
   "mode 2; Pandar128 user manual: 0.2 degrees at 10 Hz, 0.3 to 200 m at 10 %, 2 returns",
   "Firing times for far surfaces in angle state 0; those of state 1 differ by up to 0.84 us. Divergence: not stated "
   "there.",
   "10Hz 20Hz", 55.55555556, 0, -360, 0.3, 200, 200, "", 2, false,
   kPandar128E3XElevations,
   kPandar128E3XAzimuths,
   "4.558 29.082 0.776 2.459 4.558 31.357 6.833 33.456 34.973 0.776 2.459 6.833 29.082 34.973 31.357 29.082 33.456 "
   "6.833 33.456 0.776 2.459 31.357 34.973 33.456 4.558 39.255 41.604 9.044 41.604 13.41 13.41 37.072 9.044 9.044 "
   "39.255 43.787 11.227 43.787 41.604 41.604 13.41 11.227 9.044 15.593 37.072 15.593 39.255 39.255 15.593 37.072 "
   "37.072 13.41 9.044 9.044 43.787 43.787 11.227 15.593 11.227 41.604 39.255 41.604 11.227 11.227 37.072 13.41 "
   "13.41 39.255 43.787 39.255 15.593 9.044 39.255 41.604 15.593 37.072 13.41 11.227 37.072 13.41 43.787 43.787 "
   "43.787 11.227 15.593 37.072 9.044 15.593 41.604 2.459 0.776 4.558 6.833 34.973 31.357 0.776 29.082 2.459 2.459 "
   "4.558 33.456 29.082 31.357 6.833 4.558 31.357 29.082 33.456 6.833 34.973 34.973 33.456 0.776 4.558 33.456 2.459 "
   "31.357 34.973 0.776 29.082 4.558 6.833 34.973 31.357 2.459 0.776 6.833 29.082",
   0, "",
   ""},
  {"Pandar128E3X-HR", "Hesai Pandar128E3X, high resolution",
   "HesaiLidar_Swift_ROS, params: correction.csv, angles of one head, and laser-ts.csv, firing times of operation "
   "mode 0; Pandar128 user manual: 0.1 degrees at 10 Hz for lasers 26 to 89 and 0.2 for the others, 0.3 to 200 m at "
   "10 %, 2 returns",
   "Lasers 1 to 25 and 90 to 128 rest in every second column. Firing times for far surfaces in the first angle state "
   "in which a laser fires; those of the others differ by up to 0.84 us. Divergence: not stated there.",
   "10Hz 20Hz", 27.77777778, 0, -360, 0.3, 200, 200, "", 2, false,
   kPandar128E3XElevations,
   kPandar128E3XAzimuths,
   "4.558 1.304 0.776 2.459 4.558 3.579 6.833 5.678 7.195 0.776 2.459 6.833 1.304 7.195 3.579 1.304 5.678 6.833 "
   "5.678 0.776 2.459 3.579 7.195 5.678 4.558 11.227 15.593 13.41 15.593 19.959 19.959 9.044 13.41 13.41 11.227 "
   "24.491 17.776 24.491 15.593 15.593 19.959 17.776 13.41 22.142 9.044 22.142 11.227 11.227 22.142 9.044 9.044 "
   "19.959 13.41 13.41 24.491 24.491 17.776 22.142 17.776 15.593 11.227 15.593 17.776 17.776 9.044 19.959 19.959 "
   "11.227 24.491 11.227 22.142 13.41 11.227 15.593 22.142 9.044 19.959 17.776 9.044 19.959 24.491 24.491 24.491 "
   "17.776 22.142 9.044 13.41 22.142 15.593 2.459 0.776 4.558 6.833 7.195 3.579 0.776 1.304 2.459 2.459 4.558 5.678 "
   "1.304 3.579 6.833 4.558 3.579 1.304 5.678 6.833 7.195 7.195 5.678 0.776 4.558 5.678 2.459 3.579 7.195 0.776 "
   "1.304 4.558 6.833 7.195 3.579 2.459 0.776 6.833 1.304",
   0, "",
   "",
   "2 1 2 2 2 1 2 1 1 2 2 2 1 1 1 1 1 2 1 2 2 1 1 1 2 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 "
   "0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 2 2 2 2 1 1 2 1 2 2 2 1 1 1 2 2 1 1 1 2 1 1 1 "
   "2 2 1 2 1 1 2 1 2 2 1 1 2 2 2 1"},
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
   "HesaiLidar_Swift_ROS, params: PandarQT128_Correction.csv, angles, and PandarQT128_Firetimes.csv, firing times; "
   "AWSIM: lasers 1 to 32 and 33 to 64 take turns; QT128 user manual: 0.4 degrees at 10 Hz, 0.05 to 50 m (20 m at "
   "10 %), 2 returns",
   "Lasers 33 to 64 rest in columns 1, 3, 5 ..., lasers 1 to 32 in the others: 96 fire in a column. The angles of a "
   "head are in its angle correction. Divergence and origins: not stated here.",
   "10Hz 20Hz", 111.1111111, 0, -360, 0.05, 50, 20, "", 2, false,
   "-52.6268 -51.0281 -49.515 -48.0739 -46.6947 -45.3688 -44.0897 -42.8519 -41.6507 -40.4823 -39.3433 -38.2309 "
   "-37.1426 -36.0764 -35.0302 -34.0024 -32.9916 -31.9963 -31.0154 -30.0479 -29.0926 -28.1488 -27.2157 -26.2924 "
   "-25.3784 -24.4729 -23.5754 -22.6854 -21.8024 -20.9259 -20.0555 -19.1908 -18.3314 -17.4769 -16.6271 -15.7815 "
   "-14.9399 -14.1021 -13.2677 -12.4365 -11.6082 -10.7826 -9.9595 -9.1387 -8.3199 -7.503 -6.6878 -5.8739 -5.0614 "
   "-4.2499 -3.4394 -2.6296 -1.8204 -1.0115 -0.2029 0.6057 1.4144 2.2235 3.033 3.8431 4.6541 5.466 6.2792 7.0937 "
   "7.9098 8.7276 9.5474 10.3693 11.1936 12.0205 12.8502 13.6829 14.519 15.3587 16.2022 17.0499 17.902 18.7589 "
   "19.6209 20.4884 21.3618 22.2415 23.1279 24.0216 24.9229 25.8326 26.7512 27.6793 28.6176 29.567 30.5283 31.5024 "
   "32.4903 33.4931 34.5122 35.549 19.1908 20.0555 20.9259 21.8024 22.6854 23.5754 24.4729 25.3784 26.2924 27.2157 "
   "28.1488 29.0926 30.0479 31.0154 31.9963 32.9916 34.0024 35.0302 36.0764 37.1426 38.2309 39.3433 40.4823 41.6507 "
   "42.8519 44.0897 45.3688 46.6947 48.0739 49.515 51.0281 52.6268",
   "-10.1083 -9.7195 -9.3843 -9.0914 -8.8329 -8.6026 -8.3959 -8.2092 -8.0396 -7.8848 -7.7429 -7.6123 -7.4918 -7.3802 "
   "-7.2766 -7.1802 -7.0903 -7.0064 -6.9278 -6.8543 -6.7853 -6.7205 -6.6597 -6.6024 -6.5486 -6.4979 -6.4501 -6.4052 "
   "-6.3628 -6.323 -6.2855 -6.2502 6.217 6.1858 6.1566 6.1292 6.1036 6.0797 6.0574 6.0367 6.0175 5.9998 5.9836 "
   "5.9688 5.9553 5.9432 5.9267 5.9229 5.9146 5.9076 5.9019 5.8974 5.894 5.8919 5.891 5.8913 5.8928 5.8955 5.8995 "
   "5.9046 5.911 5.9186 5.9275 5.9376 -5.9491 -5.9618 -5.976 -5.9915 -6.0085 -6.0269 -6.0468 -6.0683 -6.0914 -6.1161 "
   "-6.1426 -6.1709 -6.2011 -6.2333 -6.2675 -6.3039 -6.3425 -6.3836 -6.4272 -6.4736 -6.5227 -6.575 -6.6305 -6.6895 "
   "-6.7523 -6.8191 -6.8903 -6.9663 -7.0475 -7.1343 -7.2273 -7.3272 6.2502 6.2855 6.323 6.3628 6.4052 6.4501 6.4979 "
   "6.5486 6.6024 6.6597 6.7205 6.7853 6.8543 6.9278 7.0064 7.0903 7.1802 7.2766 7.3802 7.4918 7.6123 7.7429 7.8848 "
   "8.0396 8.2092 8.3959 8.6026 8.8329 9.0914 9.3843 9.7195 10.1083",
   "92.574 67.422 42.27 17.118 43.318 18.166 93.622 68.47 94.67 69.518 44.366 19.214 45.414 20.262 95.718 70.566 "
   "96.766 71.614 46.462 21.31 47.51 22.358 97.814 72.662 98.862 73.71 48.558 23.406 49.606 24.454 99.91 74.758 "
   "17.118 42.27 67.422 92.574 68.47 93.622 18.166 43.318 19.214 44.366 69.518 94.67 70.566 95.718 20.262 45.414 "
   "21.31 46.462 71.614 96.766 72.662 97.814 22.358 47.51 23.406 48.558 73.71 98.862 74.758 99.91 24.454 49.606 "
   "76.854 51.702 26.55 1.398 25.502 0.35 75.806 50.654 77.902 52.75 27.598 2.446 28.646 3.494 78.95 53.798 79.998 "
   "54.846 29.694 4.542 30.742 5.59 81.046 55.894 82.094 56.942 31.79 6.638 32.838 7.686 83.142 57.99 8.734 33.886 "
   "59.038 84.19 60.086 85.238 9.782 34.934 10.83 35.982 61.134 86.286 62.182 87.334 11.878 37.03 12.926 38.078 "
   "63.23 88.382 64.278 89.43 13.974 39.126 15.022 40.174 65.326 90.478 66.374 91.526 16.07 41.222",
   0, "",
   "",
   "1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 2 2 2 2 2 2 2 2 2 2 2 2 2 2 2 2 2 2 2 2 2 2 2 2 "
   "2 2 2 2 2 2 2 2 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 "
   "0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0"},
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
   "RS-LiDAR-16 user manual: 30 degrees in steps of 2, 0.2 degrees at 10 Hz, 0.4 to 150 m; rs_driver, "
   "decoder_RS16.hpp: 2.8 us per laser, 55.5 us per sequence, lens centre 38.25 mm off the axis",
   "Range at 10 %, divergence, vertical offsets: not stated there.",
   "10Hz 5Hz 20Hz", 55.5, 0, -360, 0.4, 150, 0, "", 1, true,
   "-15 -13 -11 -9 -7 -5 -3 -1 15 13 11 9 7 5 3 1",
   "",
   "0..42/16",
   38.25, "",
   ""},
  {"RS-Bpearl", "RoboSense RS-Bpearl",
   "RS-Bpearl user manual: 360 x 90 degrees, 32 channels in steps of 2.81 degrees, 0.2 degrees at 10 Hz, 0.1 to 30 m "
   "(10 %); rs_driver, decoder_RSBP.hpp: firing times, 55.52 us per sequence, lens centre 14.73 mm off the axis and "
   "94.27 mm up; tier4/nebula, RobosenseBpearl.csv: order of the lasers",
   "Spread evenly over the hemisphere above. Horizontal corrections differ from head to head. Divergence: not stated "
   "here.",
   "10Hz 20Hz", 55.52, 0, -360, 0.1, 30, 30, "", 1, true,
   "2.3125 47.3125 5.125 50.125 7.9375 52.9375 10.75 55.75 13.5625 58.5625 16.375 61.375 19.1875 64.1875 22 67 "
   "24.8125 69.8125 27.625 72.625 30.4375 75.4375 33.25 78.25 36.0625 81.0625 38.875 83.875 41.6875 86.6875 44.5 "
   "89.5",
   "",
   "0 2.56 5.12 7.68 10.24 12.8 15.36 17.92 25.68 28.24 30.8 33.36 35.92 38.48 41.04 43.6 1.28 3.84 6.4 8.96 11.52 "
   "14.08 16.64 19.2 26.96 29.52 32.08 34.64 37.2 39.76 42.32 44.88",
   14.73, "",
   "94.27"},
  {"RS-Helios-32", "RoboSense RS-Helios-32 (5515)",
   "RS-Helios-5515 User Guide V3.0.1, Table 5 and section 7.2: vertical angles and firing times, 55.56 us per "
   "sequence, 0.2 degrees at 10 Hz, 2 returns; MRPT/mvsim, helios-32-FOV-70: angles to 0.001 degrees, 0.2 to 110 m; "
   "rs_driver, decoder_RSHELIOS.hpp: lens centre 34.98 mm off the axis",
   "Range at 10 %, divergence: not stated there. Horizontal corrections differ from head to head.",
   "10Hz 5Hz 20Hz", 55.55555556, 0, -360, 0.2, 110, 0, "", 2, true,
   "15 12.929 10.841 8.754 6.667 5.333 4 2.667 1.333 0 -1.333 -2.667 -4 -5.333 -6.667 -8 -10.939 -13.877 -16.816 "
   "-19.755 -22.694 -25.632 -28.571 -31.51 -34.449 -37.387 -40.326 -43.265 -46.204 -49.142 -52.081 -55.02",
   "",
   "0 1.57 3.15 4.72 6.3 7.87 9.45 11.36 13.26 15.17 17.08 18.99 20.56 22.14 23.71 25.29 26.53 27.77 29.01 30.25 "
   "31.49 32.73 33.98 35.22 36.46 37.7 38.94 40.18 41.42 42.67 43.91 45.15",
   34.98, "",
   ""},
  {"RS-Helios-1615", "RoboSense RS-Helios-32 (1615)",
   "MRPT/mvsim, helios-32-FOV-31: angles from 15 to -16 degrees in steps of 1, 0.2 to 110 m; RS-Helios-5515 User "
   "Guide V3.0.1: firing times, 55.56 us per sequence, 0.2 degrees at 10 Hz, 2 returns; rs_driver, "
   "decoder_RSHELIOS.hpp: lens centre 34.98 mm off the axis",
   "The firing times are those of the 5515. Range at 10 %, divergence: not stated there. Horizontal "
   "corrections differ from head to head.",
   "10Hz 5Hz 20Hz", 55.55555556, 0, -360, 0.2, 110, 0, "", 2, true,
   "15..-16/32",
   "",
   "0 1.57 3.15 4.72 6.3 7.87 9.45 11.36 13.26 15.17 17.08 18.99 20.56 22.14 23.71 25.29 26.53 27.77 29.01 30.25 "
   "31.49 32.73 33.98 35.22 36.46 37.7 38.94 40.18 41.42 42.67 43.91 45.15",
   34.98, "",
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
   "Isaac Sim profile SICK_tim781.json: 270 degrees in 811 beams, 15 Hz, 0.05 to 25 m; telegrams of the TiM state "
   "16,200 measurements a second, 61.728 us apart, because the mirror goes on for 90 degrees without one",
   "One layer; it turns counter-clockwise, as SICK's drivers count. The Isaac Sim profile spreads the beams over the "
   "whole turn. Range at 10 %: of the 5 m at 5 % that the profile states. Divergence: not stated there.",
   "811x15", 61.7283950617284, -135, 270.333333333333, 0.05, 25, 7.07, "", 1, false,
   "0",
   "",
   "",
   0, "",
   ""},
  {"UST-10LX", "Hokuyo UST-10LX",
   "UST-10LX instruction manual, sections 2-2 and 4: 270 degrees in 1,081 steps of 0.25, 25 ms a scan, 0.06 to 10 m "
   "on white and 4 m at 10 %; a head's answer to SCIP's PP: steps 0 to 1080 of 1,440, 540 ahead, 2,400 turns a "
   "minute; SCIP manual C-42-03320B: counter-clockwise",
   "Ranges that the manual guarantees; the head reports up to 30 m. It rests in the 90 degrees behind it. Divergence: "
   "not stated there.",
   "1081x40", 17.3611111111111, -135, 270.25, 0.06, 10, 4, "", 1, false,
   "0",
   "",
   "",
   0, "",
   ""},
  {"UST-20LX", "Hokuyo UST-20LX",
   "TouchDesigner, Hokuyo CHOP: steps and times as the UST-10LX; presets of drivers: 0.06 to 20 m, 40 Hz",
   "Range at 10 % and divergence: not stated there. It rests in the 90 degrees behind it.",
   "1081x40", 17.3611111111111, -135, 270.25, 0.06, 20, 0, "", 1, false,
   "0",
   "",
   "",
   0, "",
   ""},
  {"UTM-30LX", "Hokuyo UTM-30LX",
   "SCIP manual C-42-03320B, Table 2: steps 0 to 1080 of 1,440, 540 ahead, counter-clockwise; Hokuyo's specification: "
   "0.1 to 30 m, 25 ms a scan",
   "Range on white. Range at 10 % and divergence: not stated there. It rests in the 90 degrees behind it.",
   "1081x40", 17.3611111111111, -135, 270.25, 0.1, 30, 0, "", 1, false,
   "0",
   "",
   "",
   0, "",
   ""},
  {"UTM-30LX-EW", "Hokuyo UTM-30LX-EW",
   "A head's answer to SCIP's PP: steps 0 to 1080 of 1,440, 540 ahead, 2,400 turns a minute; Hokuyo's specification: "
   "0.1 to 30 m on white, 25 ms a scan, several echoes; urg_library, urg_sensor.h: 3 echoes at most",
   "Ranges that are guaranteed; the head reports up to 60 m. Range at 10 % and divergence: not stated there. It rests "
   "in the 90 degrees behind it.",
   "1081x40", 17.3611111111111, -135, 270.25, 0.1, 30, 0, "", 3, false,
   "0",
   "",
   "",
   0, "",
   ""},
  {"LMS111", "SICK LMS111",
   "SICK's page of the LMS111-10100: 270 degrees in steps of 0.5 or 0.25, 50 or 25 Hz, 0.5 to 20 m (18 m at 10 %), 2 "
   "echoes; LMS1xx operating instructions 8012471: beam of 8 mm and 15 mrad; SickToolbox, SickLMS1xx.hh: -45 to 225 "
   "degrees, with 90 ahead",
   "It turns counter-clockwise, as SICK's drivers count, and rests in the 90 degrees behind it. The 8 mm of the beam "
   "at the head are left out.",
   "541x50 1081x25", 27.7777777777778, -135, 270.5, 0.5, 20, 18, "15 15", 2, false,
   "0",
   "",
   "",
   0, "",
   ""},
  {"microScan3", "SICK microScan3 with a protective field of 9 m",
   "sick_safetyscanners, issue 94: 0.51306 degrees and 43 us from beam to beam, 30 ms a scan; Isaac Sim profile "
   "SICK_microscan3_ABAZ90ZA1P01.json: 275 degrees, 0.05 to 64 m, 9 m at 2 %",
   "537 beams: the azimuths of the issue are whole steps of 275 / 536 degrees from -137.5 on. It turns "
   "counter-clockwise, as SICK's drivers count. Range at 10 %: of the 9 m at 2 % that the profile states. The Isaac "
   "Sim profile has 2,750 beams. Divergence: not stated there.",
   "537x33.3333333", 42.7549751243781, -137.5, 275.513059701493, 0.05, 64, 20.1, "", 1, false,
   "0",
   "",
   "",
   0, "",
   ""},
  {"nanoScan3", "SICK nanoScan3",
   "sick_safetyscanners2, issue 2: 1/6 degree and 14 us from beam to beam, 30 ms a scan, 0.1 to 40 m; issue 50: 275 "
   "degrees, 40 m",
   "1,651 beams, both ends of the 275 degrees. It turns counter-clockwise, as SICK's drivers count. Range at 10 % and "
   "divergence: not stated there.",
   "1651x33.3333333", 13.8888888888889, -137.5, 275.166666666667, 0.1, 40, 0, "", 1, false,
   "0",
   "",
   "",
   0, "",
   ""},
  {"RPLIDAR-A1", "Slamtec RPLIDAR A1M8",
   "RPLIDAR A1M8 data sheet, Measurement Performance: 0.15 to 12 m on white, up to 8,000 samples a second, 5.5 turns "
   "a second and at most 10; interface protocol: clockwise",
   "At the most samples a second; at 4,000 it has half the columns. Range at 10 % and divergence: not stated there. A "
   "triangulating head, whose errors grow with the range.",
   "5.5Hz 10Hz", 125, 0, -360, 0.15, 12, 0, "", 1, false,
   "0",
   "",
   "",
   0, "",
   ""},
  {"RPLIDAR-A2", "Slamtec RPLIDAR A2M8",
   "RPLIDAR A2M8 data sheet, revision 2.5: up to 12 m, 8,000 samples a second, 0.45 degrees at 10 turns a second, "
   "which may be 5 to 15; rplidar_ros, node.cpp: from 0.15 m; interface protocol: clockwise",
   "Range at 10 % and divergence: not stated there. A triangulating head, whose errors grow with the range.",
   "10Hz 5Hz 15Hz", 125, 0, -360, 0.15, 12, 0, "", 1, false,
   "0",
   "",
   "",
   0, "",
   ""},
  {"RPLIDAR-S2E", "Slamtec RPLIDAR S2E",
   "Isaac Sim profile RPLIDAR_S2E.json, of the data sheet 1.3: 32,000 samples and 10 turns a second, clockwise, 0.05 "
   "to 30 m (10 m at 10 %)",
   "Divergence: not stated there.",
   "10Hz", 31.25, 0, -360, 0.05, 30, 10, "", 1, false,
   "0",
   "",
   "",
   0, "",
   ""},
  {"Waymo-Top", "Waymo Open Dataset, the lidar on the roof",
   "Sun et al., Scalability in Perception for Autonomous Driving, 2020, Table 2: 64 beams, -17.6 to 2.4 degrees, "
   "75 m, 2 returns; range images of 64 x 2650",
   "Like the head of the data set: evenly spread, where the real inclinations differ from vehicle to vehicle; column "
   "0 is the rear's, as in the range images.",
   "2650x10", 0, 180 - 180.0 / 2650, -360, 0, 75, 0, "", 2, false,
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
   "0..34.56/16 1.152..35.712/16",
   0, "",
   ""},
};
// clang-format on

}  // namespace gnosphere
