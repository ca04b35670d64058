// SPDX-License-Identifier: Apache-2.0
// How boxes are divided into clusters and groups.
#include <algorithm>
#include <catch2/catch_test_macros.hpp>
#include <cmath>
#include <numeric>
#include <random>
#include <span>
#include <utility>

#include "geometry/partition.hpp"

using gnosphere::BoundingBox;
using gnosphere::Boxed;
using gnosphere::Partition;

namespace {

BoundingBox boxAt(float x, float y, float z, float size) {
  BoundingBox box;
  const float low[3] = {x, y, z}, high[3] = {x + size, y + size, z + size};
  box.add(low);
  box.add(high);
  return box;
}

Partition partition(const std::vector<BoundingBox>& boxes, size_t most, float runCost) {
  std::vector<Boxed> items;
  for (const BoundingBox& box : boxes) items.push_back({box, static_cast<uint32_t>(items.size())});
  return gnosphere::partition(std::move(items), most, runCost);
}

// Every box is in one run, and no run is empty or has more than `most`.
void checkRuns(const Partition& result, size_t count, size_t most) {
  std::vector<uint32_t> all, expected(count);
  for (const Boxed& item : result.items) all.push_back(item.index);
  std::sort(all.begin(), all.end());
  std::iota(expected.begin(), expected.end(), 0);
  CHECK(all == expected);
  size_t first = 0;
  bool fits = true;
  for (const size_t end : result.ends) {
    fits = fits && end > first && end - first <= most;
    first = end;
  }
  CHECK(fits);
  CHECK(first == count);
}

}  // namespace

TEST_CASE("every box is in one run, whatever the boxes are") {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> place(-10, 10), size(0, 2);
  std::vector<BoundingBox> boxes;
  for (const size_t count : {0, 1, 2, 32, 33, 64, 65, 1000, 5000}) {
    while (boxes.size() < count) boxes.push_back(boxAt(place(random), place(random), place(random), size(random)));
    checkRuns(partition(boxes, 32, 16), count, 32);
  }
  // All at one place, empty, and each ten times as large as the one before, which makes uneven halves.
  checkRuns(partition(std::vector(1000, boxAt(1, 2, 3, 0)), 32, 16), 1000, 32);
  checkRuns(partition(std::vector(1000, BoundingBox()), 32, 16), 1000, 32);
  // Centres that differ by a denormal number, whose quotients are not finite.
  boxes.clear();
  for (int i = 0; i < 1000; ++i) boxes.push_back(boxAt(static_cast<float>(i) * 1e-42f, 0, 0, 0));
  checkRuns(partition(boxes, 32, 16), boxes.size(), 32);
  boxes.clear();
  for (int i = 0; i < 100000; ++i) boxes.push_back(boxAt(std::pow(10.0f, static_cast<float>(i % 18) - 9), 0, 0, 0));
  checkRuns(partition(boxes, 1, 16), boxes.size(), 1);
}

TEST_CASE("objects that lie apart share no run") {
  std::mt19937 random(2);
  std::uniform_real_distribution<float> place(0, 1);
  std::vector<BoundingBox> boxes;
  for (int i = 0; i < 3 * 100; ++i)
    boxes.push_back(boxAt(50.0f * static_cast<float>(i % 3) + place(random), place(random), place(random), 0.05f));
  const Partition result = partition(boxes, 32, 16);
  size_t first = 0;
  for (const size_t end : result.ends) {
    const uint32_t object = result.items[first].index % 3;
    for (; first < end; ++first) CHECK(result.items[first].index % 3 == object);
  }
}

TEST_CASE("a large box beside many small ones has a run of its own") {
  std::vector<BoundingBox> boxes = {boxAt(-500, -500, -1000, 1000)};
  for (int i = 0; i < 400; ++i) boxes.push_back(boxAt(static_cast<float>(i % 20), static_cast<float>(i / 20), 0, 0.5f));
  const Partition result = partition(boxes, 32, 16);
  size_t first = 0;
  for (const size_t end : result.ends) {
    const auto isLarge = [](const Boxed& item) { return item.index == 0; };
    const std::span run = std::span(result.items).subspan(first, end - first);
    if (std::any_of(run.begin(), run.end(), isLarge)) CHECK(run.size() == 1);
    first = end;
  }
}

TEST_CASE("runs of a grid are nearly full and nearly square") {
  std::vector<BoundingBox> boxes;
  for (int i = 0; i < 128 * 128; ++i)
    boxes.push_back(boxAt(static_cast<float>(i % 128), static_cast<float>(i / 128), 0, 1));
  std::shuffle(boxes.begin(), boxes.end(), std::mt19937(3));
  const Partition result = partition(boxes, 32, 16);
  checkRuns(result, boxes.size(), 32);
  CHECK(result.ends.size() <= 128 * 128 / 32 * 5 / 4);
  double area = 0;
  size_t first = 0;
  for (const size_t end : result.ends) {
    BoundingBox box;
    for (; first < end; ++first) box.add(result.items[first].box);
    area += box.halfArea();
  }
  // Runs of 8 by 4 boxes have 8 * 4 + 8 + 4 each.
  CHECK(area <= 1.1 * 44 * 128 * 128 / 32);
}
