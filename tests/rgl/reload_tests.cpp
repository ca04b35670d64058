// SPDX-License-Identifier: Apache-2.0
// Engines open and close plug-ins again and again: the library's devices and threads are there once all the same. This
// program is not linked with the library.
#include <dlfcn.h>
#include <rgl/api/core.h>
#include <unistd.h>

#include <catch2/catch_test_macros.hpp>
#include <chrono>
#include <filesystem>
#include <iterator>
#include <string>
#include <thread>
#include <vector>

namespace {

/// Finds a function of the library, for a variable of its name without "rgl_".
#define FIND(name) const auto name = reinterpret_cast<decltype(&rgl_##name)>(dlsym(library, "rgl_" #name))

/// Opens the library, finds the distances of a triangle, and closes the library. Returns whether all went well.
bool scanOnce() {
  void* const library = dlopen(GNOSPHERE_RGL_LIBRARY, RTLD_NOW | RTLD_LOCAL);
  if (!library) return false;
  FIND(mesh_create);
  FIND(entity_create);
  FIND(node_rays_from_mat3x4f);
  FIND(node_raytrace);
  FIND(node_points_yield);
  FIND(graph_node_add_child);
  FIND(graph_run);
  FIND(graph_get_result_data);
  FIND(cleanup);
  const rgl_vec3f corners[] = {{{-1, -1, 3}}, {{1, -1, 3}}, {{0, 1, 3}}};
  const rgl_vec3i triangle = {{0, 1, 2}};
  const std::vector<rgl_mat3x4f> matrices(9'000, {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}});  // enough for threads
  const rgl_field_t field = RGL_FIELD_DISTANCE_F32;
  rgl_mesh_t mesh = nullptr;
  rgl_entity_t entity = nullptr;
  rgl_node_t rays = nullptr, raytrace = nullptr, yield = nullptr;
  std::vector<float> distances(matrices.size());
  bool good = mesh_create(&mesh, corners, 3, &triangle, 1) == RGL_SUCCESS &&
              entity_create(&entity, nullptr, mesh) == RGL_SUCCESS &&
              node_rays_from_mat3x4f(&rays, matrices.data(), 9'000) == RGL_SUCCESS &&
              node_raytrace(&raytrace, nullptr) == RGL_SUCCESS && node_points_yield(&yield, &field, 1) == RGL_SUCCESS &&
              graph_node_add_child(rays, raytrace) == RGL_SUCCESS &&
              graph_node_add_child(raytrace, yield) == RGL_SUCCESS && graph_run(rays) == RGL_SUCCESS &&
              graph_get_result_data(yield, field, distances.data()) == RGL_SUCCESS && distances.back() == 3;
  good = cleanup() == RGL_SUCCESS && good;
  return dlclose(library) == 0 && good;
}

ptrdiff_t threads() {
  return std::distance(std::filesystem::directory_iterator("/proc/self/task"), {});
}

/// Opens and closes the library in a thread that ends. A thread that has variables of the library keeps the library
/// until the thread ends; when the library is closed the next time, the loader may take it out.
void scanInThread() {
  bool good = false;
  pid_t task = 0;
  std::thread([&] {
    task = gettid();
    good = scanOnce();
  }).join();
  REQUIRE(good);
  dlclose(dlopen(GNOSPHERE_RGL_LIBRARY, RTLD_NOW | RTLD_LOCAL));
  while (std::filesystem::exists("/proc/self/task/" + std::to_string(task)))  // the system still lists the thread
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
}

}  // namespace

TEST_CASE("RGL: a library that is opened and closed again and again starts its threads once") {
  scanInThread();
  const ptrdiff_t first = threads();
  for (int i = 0; i < 4; ++i) scanInThread();
  CHECK(threads() == first);
}
