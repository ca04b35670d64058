// SPDX-License-Identifier: Apache-2.0
// A small engine: it draws a scene with its own Vulkan device and, in the same frame, the live cloud of a moving sensor
// that GnoSphere has just written into its vertex buffer. The points never leave the device.
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include <cstdint>
#include <cstdio>
#include <exception>
#include <optional>
#include <stdexcept>
#include <string>

#include "cloud.hpp"
#include "mesh.hpp"
#include "options.hpp"
#include "picture.hpp"
#include "world.hpp"

namespace viewer {
namespace {

constexpr double kStep = 0.1;  // seconds per frame if their number is given

// Settings that keys and mouse change.
struct Controls {
  Camera camera;
  Colouring colouring = Colouring::range;
  bool paused = false;
  double mouseX = 0, mouseY = 0;
};

Controls& controlsOf(GLFWwindow* window) {
  return *static_cast<Controls*>(glfwGetWindowUserPointer(window));
}

void onKey(GLFWwindow* window, int key, int, int action, int) {
  if (action != GLFW_PRESS) return;
  Controls& controls = controlsOf(window);
  switch (key) {
    case GLFW_KEY_0: controls.colouring = Colouring::none; break;
    case GLFW_KEY_1: controls.colouring = Colouring::range; break;
    case GLFW_KEY_2: controls.colouring = Colouring::intensity; break;
    case GLFW_KEY_3: controls.colouring = Colouring::instance; break;
    case GLFW_KEY_SPACE: controls.paused = !controls.paused; break;
    case GLFW_KEY_ESCAPE: glfwSetWindowShouldClose(window, GLFW_TRUE); break;
    default: break;
  }
}

void onMouse(GLFWwindow* window, double x, double y) {
  Controls& controls = controlsOf(window);
  constexpr double kRadiansPerPixel = 0.005;
  if (glfwGetMouseButton(window, GLFW_MOUSE_BUTTON_LEFT) == GLFW_PRESS)
    controls.camera.orbit(kRadiansPerPixel * (x - controls.mouseX), kRadiansPerPixel * (y - controls.mouseY));
  controls.mouseX = x;
  controls.mouseY = y;
}

void onScroll(GLFWwindow* window, double, double steps) {
  controlsOf(window).camera.zoom(steps);
}

// The library GLFW with one window.
class Window {
 public:
  Window(uint32_t width, uint32_t height, Controls& controls) {
    if (!glfwInit()) fail();
    glfwWindowHint(GLFW_CLIENT_API, GLFW_NO_API);
    window_ = glfwCreateWindow(static_cast<int>(width), static_cast<int>(height), "GnoSphere", nullptr, nullptr);
    if (!window_) fail();
    glfwSetWindowUserPointer(window_, &controls);
    glfwSetKeyCallback(window_, onKey);
    glfwSetCursorPosCallback(window_, onMouse);
    glfwSetScrollCallback(window_, onScroll);
  }
  ~Window() { glfwTerminate(); }
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;

  GLFWwindow* get() const { return window_; }

 private:
  [[noreturn]] static void fail() {
    const char* reason = nullptr;
    glfwGetError(&reason);
    throw std::runtime_error(std::string("cannot open a window: ") + (reason ? reason : "no reason given") +
                             "; without a screen, Xvfb makes a display");
  }

  GLFWwindow* window_ = nullptr;
};

World worldOf(const Options& options) {
  if (options.scene.empty()) return street();
  World world;
  world.scene = gnosphere::loadScene(options.scene);
  world.start = options.start;
  return world;
}

// Moves what moves, in the simulator and in the scene that is drawn.
void move(World& world, gnosphere::Simulator& simulator, double time) {
  for (const World::Mover& mover : world.movers) {
    gnosphere::Transform& place = world.scene.instances[mover.instance].transform;
    place = mover.at(time);
    simulator.setTransform(mover.instance, place);
  }
}

void run(const Options& options) {
  Controls controls;
  controls.colouring = options.colouring;
  World world = worldOf(options);
  const gnosphere::Sensor sensor = gnosphere::builtinSensor(options.sensor);
  const Window window(options.width, options.height, controls);
  const Device device(window.get(), options.validate);
  Frames frames(device, window.get());
  const SceneMesh mesh(device, frames.pass(), world.scene);
  std::optional<Picture> picture;
  Cloud cloud(device, frames.pass(), world.scene, sensor);

  double time = 0, clock = glfwGetTime();
  uint64_t number = 0;
  for (bool last = false; !last; ++number) {
    glfwPollEvents();
    const double now = glfwGetTime();
    if (number > 0 && !controls.paused) time += options.frames ? kStep : now - clock;
    clock = now;
    last = glfwWindowShouldClose(window.get()) || number + 1 == options.frames;
    move(world, cloud.simulator(), time);
    const gnosphere::Pose pose = world.sensorAt(time);

    const Frames::Frame frame = frames.begin();
    cloud.scan(frame, pose, number);
    const VkExtent2D size = frames.size();
    const glm::dmat4 toClip =
        controls.camera.toClip(vectorOf(pose.position), static_cast<double>(size.width) / size.height);
    frames.beginPass(frame);
    mesh.draw(frame.commands, world.scene, toClip);
    cloud.draw(frame.commands, toClip, controls.colouring, 1 + static_cast<float>(size.height) / 600);
    vkCmdEndRenderPass(frame.commands);
    if (last && !options.picture.empty()) picture.emplace(device, frames, frame);
    frames.end(frame);
  }
  require(vkDeviceWaitIdle(device.device), "vkDeviceWaitIdle");
  if (picture) picture->write(options.picture);
  std::printf("%llu frames, %u points in the last\n", static_cast<unsigned long long>(number), cloud.header().rows);
}

}  // namespace
}  // namespace viewer

int main(int count, char** arguments) {
  try {
    const viewer::Options options = viewer::parse(count, arguments);
    if (options.help)
      std::fputs(viewer::kUsage, stdout);
    else
      viewer::run(options);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "viewer: %s\n", error.what());
    return 1;
  }
}
