// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gnosphere/scene.hpp>
#include <string>

#include "cloud.hpp"

namespace viewer {

/// The options of the command line.
struct Options {
  std::string scene;  ///< file; if empty, a street that is built in
  gnosphere::Vec3 start = {0, 0, 1.8};
  std::string sensor = "OS1-64";
  Colouring colouring = Colouring::range;
  uint64_t frames = 0;  ///< 0 for no end
  std::string picture;  ///< file; empty for none
  uint32_t width = 1280, height = 720;
  bool validate = false;
  bool help = false;
};

inline constexpr const char* kUsage =
    "Usage: example_viewer [SCENE] [OPTION]...\n"
    "\n"
    "Draws a scene (.gltf, .glb, .obj, .ply, .stl), or a street that is built in, and the live cloud of a sensor that\n"
    "moves in it. 1, 2 and 3 colour the points by range, intensity and instance, 0 hides them; the space bar pauses, "
    "the\n"
    "mouse turns the camera, the wheel zooms, Esc ends.\n"
    "\n"
    "  --sensor NAME      a built-in sensor (OS1-64)\n"
    "  --start X,Y,Z      where the sensor starts in SCENE, in metres (0,0,1.8); it moves along x and back\n"
    "  --colour NAME      range, intensity, instance or none (range)\n"
    "  --frames N         end after N frames, 0.1 s of the scene apart\n"
    "  --picture FILE     write the last frame, as .png or .ppm\n"
    "  --size WxH         of the window, in pixels (1280x720)\n"
    "  --validate         turn Vulkan's validation layer on, if it is installed\n";

/// Throws std::runtime_error that names a wrong argument.
Options parse(int count, char** arguments);

}  // namespace viewer
