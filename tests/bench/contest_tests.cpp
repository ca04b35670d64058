// SPDX-License-Identifier: Apache-2.0
// Parts of the bench: wrong results are detected before anything is timed, and figures are consistent.
#include <catch2/matchers/catch_matchers_exception.hpp>
#include <catch2/matchers/catch_matchers_floating_point.hpp>
#include <catch2/matchers/catch_matchers_string.hpp>
#include <limits>

#include "columns.hpp"
#include "console.hpp"
#include "contest.hpp"
#include "cuda/twin.hpp"
#include "report.hpp"
#include "rivals/cuda.hpp"
#include "rivals/embree.hpp"
#include "rivals/rivals.hpp"
#include "support.hpp"

using namespace gnosphere;
using namespace gnosphere::bench;
using Catch::Matchers::ContainsSubstring;
using Catch::Matchers::MessageMatches;
using Catch::Matchers::WithinRel;

namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

Sensor sensorOf() {
  return test::gridSensor(450, 16, -20, 20, 60);
}

Scene balls() {
  Scene scene = test::sceneOf(test::ball(20, 40, 1.5));
  scene.meshes[0].origin = {0.5, 0.25, -0.125};
  for (int i = 1; i < 12; ++i) scene.instances.push_back({"", 0, test::translation(4.0 * i - 20, 6, 0.5)});
  return scene;
}

/// A rival with correct results, except for a number of spoilt beams.
class Spoiler : public Rival {
 public:
  Spoiler(const Scene& scene, size_t spoilt) : scene_(scene), spoilt_(spoilt) {}
  std::string name() const override { return "spoiler"; }
  double build() override { return 1; }
  double update(std::span<const Moved> moved) override {
    for (const Moved& move : moved) scene_.instances[move.instance].transform = move.transform;
    return 2;
  }
  double trace(const Sensor& sensor, const Pose& pose, Hits& hits) override {
    const Scan scan = test::referenceOf(scene_, sensor, pose, ReflectingFaces::both);
    hits = {scan.points, scan.ranges, scan.triangles, scan.instances};
    for (size_t beam = 0, left = spoilt_; left > 0; ++beam) {
      if (!scan.hit(beam)) continue;
      hits.ranges[beam] *= 1.01f;
      --left;
    }
    return 3;
  }

 private:
  Scene scene_;
  size_t spoilt_;
};

/// The CUDA backend with its kernels on the host. As it has no device clock, the times of its steps are given.
class Cuda : public Contender {
 public:
  Cuda(const Scene& scene, const test::TestOptions& options) : scene_(scene), cuda_(scene, {sensorOf()}, options) {}
  std::string name() const override { return "cuda"; }
  double build() override { return 1; }
  Sample run(const Task& task) override {
    for (const Moved& move : task.moved)
      cuda_.backend().setInstance(move.instance, scene_.instances[move.instance].mesh, move.transform);
    const double start = cli::nowMs();
    cuda_.scanInto(task.shot, scan_);
    return {0, cli::nowMs() - start, 6, {{"project", 1}, {"bin", 2}, {"resolve", 3}}};
  }
  const Scan& answer() const override { return scan_; }
  uint64_t memoryBytes() const override { return 0; }

 private:
  const Scene& scene_;
  test::CudaOnHost cuda_;
  Scan scan_;
};

Outcome holdAgainst(const Scene& scene, size_t spoilt, const std::vector<size_t>& moving) {
  test::TestOptions options = test::vulkanOptions();
  options.faces = ReflectingFaces::both;
  std::vector<std::unique_ptr<Contender>> contenders;
  contenders.push_back(makeOurs(scene, {sensorOf(), Effects::none()}, options));
  contenders.push_back(makeGuest(std::make_unique<Spoiler>(scene, spoilt), sensorOf()));
  const std::vector<Pose> poses = {{{0, 0, 0}, {}}, {{1, 0, 0.5}, {}}};
  return hold({"balls", 7, scene, sensorOf(), shotsFrom(poses), moving, 3}, contenders, {100, 1000});
}

Scan scanWith(std::vector<float> ranges) {
  Scan scan;
  scan.ranges = std::move(ranges);
  return scan;
}

}  // namespace

TEST_CASE("a contest times contenders whose results are right") {
  test::needVulkan();
  const Outcome outcome = holdAgainst(balls(), 0, {0, 3});
  REQUIRE(outcome.standings.size() == 2);
  const Standing &ours = outcome.standings[0], &rival = outcome.standings[1];
  CHECK(ours.ratio == 1);
  REQUIRE(ours.error);
  CHECK(ours.error->hits > 100);
  CHECK(rival.samples == 6);
  CHECK(rival.buildMs == 1);
  CHECK(rival.totalMs.median == 5);
  CHECK(rival.meanMs == 5);
  CHECK(rival.frameVariance == 0);
  CHECK(rival.runVariance == 0);
  // The ratio is a median of ratios, so it lies between the ratios of the extremes.
  CHECK(rival.ratio <= 5 / ours.totalMs.min);
  CHECK(rival.ratio >= 5 / (2 * ours.totalMs.p90 + 1000));
  CHECK(rival.leastFrameRatio <= rival.ratio);
  CHECK(rival.mostFrameRatio >= rival.ratio);
  CHECK(rival.leastFrameRatio > 0);
  CHECK(rival.agreement.differ() == 0);
  CHECK(outcome.floor.ms > 0);
}

TEST_CASE("a contest refuses a rival whose result is wrong") {
  test::needVulkan();
  // Of 7,200 beams, none may differ by more than rounding.
  CHECK_THROWS_MATCHES(holdAgainst(balls(), 1, {}), Error,
                       MessageMatches(ContainsSubstring("balls: the result of spoiler is wrong: 1 of 7,200 beams")));
}

TEST_CASE("a contest compares CUDA with Vulkan step by step") {
  test::needVulkan();
  const Scene scene = balls();
  test::TestOptions options = test::vulkanOptions();
  options.faces = ReflectingFaces::both;
  options.accuracy = Accuracy::exact;
  std::vector<std::unique_ptr<Contender>> contenders;
  contenders.push_back(makeOurs(scene, {sensorOf(), Effects::none()}, options));
  contenders.push_back(std::make_unique<Cuda>(scene, options));
  const std::vector<Pose> poses = {{{0, 0, 0}, {}}, {{1, 0, 0.5}, {}}};
  const Outcome outcome = hold({"balls", 7, scene, sensorOf(), shotsFrom(poses), {0, 3}, 2}, contenders, {});
  CHECK(outcome.hits > 100);
  CHECK(simulatorOf(*contenders[0]).device().uuid != decltype(DeviceInfo::uuid){});
  CHECK(test::sameBytes(contenders[0]->answer(), contenders[1]->answer()));  // results of the last frame
  const Table table = cudaTable({outcome});
  REQUIRE(table.rows.size() == 1 + 5);
  for (const cli::TableRow& row : table.rows) CHECK(row.size() == 5);
  const char* stages[] = {"project", "bin", "resolve", "device", "total"};
  for (size_t i = 0; i < 5; ++i) CHECK(table.rows[i + 1][1] == stages[i]);
  CHECK(table.rows[4][3] == cli::bareMs(6));
}

TEST_CASE("a contest with effects compares CUDA's labels and intensities with Vulkan's") {
  test::needVulkan();
  const Scene scene = balls();
  test::TestOptions options = test::vulkanOptions();
  options.faces = ReflectingFaces::both;
  options.effects = Effects::none();
  for (const char* assignment : {"intensity=on", "fog.visibility=80", "range-noise.sigma=0.02"})
    assign(options.effects, assignment);
  options.fields = {Field::intensity, Field::label};
  std::vector<Shot> shots = shotsFrom({{{0, 0, 0}, {}}, {{1, 0, 0.5}, {}}});
  shots[1].frame = 7;
  const auto contestWith = [&](uint64_t seed) {
    std::vector<std::unique_ptr<Contender>> contenders;
    contenders.push_back(makeOurs(scene, {sensorOf(), options.effects, options.fields}, options));
    test::TestOptions other = options;
    other.effects.seed = seed;
    contenders.push_back(std::make_unique<Cuda>(scene, other));
    return hold({"balls", 7, scene, sensorOf(), shots, {}, 1, false}, contenders, {});
  };
  const Outcome outcome = contestWith(options.effects.seed);
  CHECK(outcome.hits > 100);
  CHECK(outcome.standings[1].agreement.differ() == 0);
  CHECK_THROWS_MATCHES(contestWith(options.effects.seed + 1), Error,
                       MessageMatches(ContainsSubstring("balls: the result of cuda is wrong")));
}

TEST_CASE("the table of Vulkan and CUDA has speed ratios, and no rows without CUDA") {
  Outcome outcome;
  outcome.label = "HDL-64E";
  Standing vulkan, cuda, fast, rival;
  vulkan.name = "standard";
  vulkan.stages = {{"project", 2}, {"bin", 4}, {"effects", 1}};
  vulkan.deviceMs.median = 7;
  vulkan.totalMs.median = 8;
  rival.name = "embree";
  cuda.name = "cuda";
  cuda.stages = {{"project", 3}, {"bin", 2}};
  cuda.deviceMs.median = 5;
  cuda.totalMs.median = 10;
  cuda.ratio = 1.25;
  cuda.deviceRatio = 0.71;
  fast = cuda;
  fast.name = "cuda-fast";
  fast.stages = {{"scan", 0.5}};
  fast.totalMs.median = 9;
  fast.ratio = 1.125;
  outcome.standings = {vulkan, rival};
  CHECK(cudaTable({outcome}).rows.empty());
  outcome.standings = {vulkan, rival, cuda, fast};
  const std::string dash = "-", two = cli::bareMs(2), seven = cli::bareMs(7), eight = cli::bareMs(8);
  const std::vector<cli::TableRow> expected = {
      {"case", "stage", "Vulkan ms", "cuda ms", "Vulkan is times as fast", "cuda-fast ms", "Vulkan is times as fast"},
      {"HDL-64E", "project", two, cli::bareMs(3), "1.50", dash, dash},
      {"HDL-64E", "bin", cli::bareMs(4), two, "0.50", dash, dash},
      {"HDL-64E", "effects", cli::bareMs(1), dash, dash, dash, dash},
      {"HDL-64E", "scan", dash, dash, dash, cli::bareMs(0.5), dash},
      {"HDL-64E", "device", seven, cli::bareMs(5), "0.71", cli::bareMs(5), "0.71"},
      {"HDL-64E", "total", eight, cli::bareMs(10), "1.25", cli::bareMs(9), "1.12"}};
  CHECK(cudaTable({outcome}).rows == expected);
  Outcome small = outcome;
  small.standings = {vulkan, cuda};
  CHECK(cudaTable({outcome, small}).rows.back() ==
        cli::TableRow{"HDL-64E", "total", eight, cli::bareMs(10), "1.25", dash, dash});
}

TEST_CASE("the same card by CUDA has the same UUID, or else the same name") {
  const auto card = [](const std::string& name, uint8_t uuid) {
    DeviceInfo info;
    info.name = name;
    info.usable = true;
    info.uuid[15] = uuid;
    return info;
  };
  const std::vector<DeviceInfo> cuda = {card("cuda:0 NVIDIA A", 1), card("cuda:1 NVIDIA B", 2),
                                        card("cuda:2 NVIDIA B", 3)};
  CHECK(sameCard(card("NVIDIA B", 3), cuda, "") == 2);
  CHECK(sameCard(card("NVIDIA B", 0), cuda, "") == 1);
  CHECK(sameCard(card("NVIDIA A", 9), {card("cuda:0 NVIDIA A", 0)}, "") == 0);
  CHECK_THROWS_WITH(sameCard(card("NVIDIA B", 4), cuda, ""), "cuda: no CUDA device is the card 'NVIDIA B'");
  CHECK_THROWS_WITH(sameCard(card("AMD C", 0), cuda, ""), "cuda: no CUDA device is the card 'AMD C'");
  CHECK_THROWS_WITH(sameCard(card("NVIDIA B", 3), {}, "CUDA is not built in"), "cuda: CUDA is not built in");
  std::vector<DeviceInfo> old = {card("cuda:0 NVIDIA A", 1)};
  old[0].usable = false;
  old[0].reason = "it is old";
  CHECK_THROWS_WITH(sameCard(card("NVIDIA A", 1), old, ""), "cuda: cuda:0 NVIDIA A cannot be used: it is old");
}

TEST_CASE("CUDA is compared only with Vulkan on the same card, and otherwise left out with a note") {
  const Scene scene = balls();
  const Sensor sensor = sensorOf();
  const auto noteOf = [&](const char* type, const char* apiVersion) {
    DeviceInfo device;
    device.name = "a device of brass";
    device.type = type;
    device.apiVersion = apiVersion;
    std::vector<std::string> notes;
    CHECK(makeRivals({"cuda"}, {scene, sensor, {}, Motion::none, {}, device}, notes).empty());
    REQUIRE(notes.size() == 1);
    return notes[0];
  };
  CHECK(noteOf("cpu", "1.3") ==
        "cuda is compared with Vulkan on the same card, but GnoSphere runs on a device of brass");
  CHECK(noteOf("cuda", "") == "cuda is compared with Vulkan on the same card, but GnoSphere runs on a device of brass");
  std::string problem;
  const bool none = cuda::devices(problem).empty();
  CHECK(noteOf("discrete", "1.3") ==
        (none ? "cuda: " + problem : "cuda: no CUDA device is the card 'a device of brass'"));
}

TEST_CASE("results agree within 1 mm and a ten-thousandth of the range, and hits with hits") {
  const Scan ours = scanWith({10, 10, kNaN, kNaN, 100, 100});
  const Agreement agreement = agreementOf(ours, scanWith({10.0019f, kNaN, kNaN, 1, 100.0109f, 100.0111f}));
  CHECK(agreement.beams == 6);
  CHECK(agreement.hits == 2);
  CHECK(agreement.ranges == 1);
  CHECK_FALSE(agreement.good());
  CHECK(agreement.differ() == 3);
  CHECK(agreementOf(ours, ours).good());
  CHECK_FALSE(agreementOf(ours, scanWith({})).good());
  std::vector<float> many(20'000, 5.0f), other = many;
  other[1] = other[2] = kNaN;
  CHECK(agreementOf(scanWith(many), scanWith(other)).good());
  other[3] = kNaN;
  CHECK_FALSE(agreementOf(scanWith(many), scanWith(other)).good());
  // Beams that the reference marks as ties may go either way.
  Scan reference = scanWith(many);
  std::vector<uint8_t> ties(many.size());
  ties[2] = 1;
  test::setColumn<uint8_t>(reference, Field::tie, ties);
  CHECK(agreementOf(scanWith(many), scanWith(other), &reference).differ() == 2);
  CHECK(agreementOf(scanWith(many), scanWith(other), &reference).good());
}

TEST_CASE("labels and intensities are compared if both contenders have them") {
  Scan ours = scanWith({10, 10, 10, 10, kNaN}), other = ours;
  test::setColumn<uint8_t>(ours, Field::label, {1, 1, 1, 1, 0});
  test::setColumn<float>(ours, Field::intensity, {0.5f, 0.5f, 0.5f, kNaN, kNaN});
  CHECK(agreementOf(ours, other).differ() == 0);  // the other has none
  test::setColumn<uint8_t>(other, Field::label, {1, 2, 1, 1, 0});
  test::setColumn<float>(other, Field::intensity, {0.5014f, 0.5f, 0.5016f, 0, kNaN});
  const Agreement agreement = agreementOf(ours, other);
  CHECK(agreement.signals == 3);
  CHECK(agreement.differ() == 3);
  other.ranges[1] = 11;  // a beam counts only once
  CHECK(agreementOf(ours, other).differ() == 3);
}

TEST_CASE("the floor counts visible geometry once, and beams") {
  Counters counters;
  counters.beams = 10;
  counters.hits = 5;
  counters.triangles = 100;
  counters.culledByCluster = 40;
  const Floor floor = floorOf(counters, {2400, 0, 0}, 50, {100, 1000});
  CHECK_THAT(floor.bytes, WithinRel(50 * 48.0 + 10 * 40, 1e-12));
  CHECK_THAT(floor.operations, WithinRel(60 * 71.0 + 5 * 24, 1e-12));
  CHECK_THAT(floor.ms, WithinRel(28.0, 1e-12));
  CHECK_THAT(floorOf(counters, {2400, 0, 0}, 50, {1e9, 1000}).ms, WithinRel(4.38, 1e-12));
  CHECK_THAT(floorOf(counters, {2400, 0, 0}, 50, {100, 0}).ms, WithinRel(28.0, 1e-12));
  CHECK(floorOf(counters, {2400, 0, 0}, 50, {}).ms == 0);
}

TEST_CASE("rivals are selected by name") {
  CHECK(parseRivals("none").empty());
  CHECK(parseRivals("all").size() == 4);
  CHECK(parseRivals("embree,cuda") == std::vector<std::string>{"embree", "cuda"});
  CHECK_THROWS_MATCHES(parseRivals("embree,optix"), Error, MessageMatches(ContainsSubstring("'optix' is unknown")));
}

TEST_CASE("Embree hits the same triangles as the reference, with every kind of structure") {
  if (!haveEmbree()) SKIP("Embree is not built in");
  const Vec3 far = {5e5, -3e5, 100};
  Scene scene = balls();
  for (Instance& instance : scene.instances)
    instance.transform = test::translation(far.x, far.y, far.z) * instance.transform * test::scaling(1, 1.5, 0.5);
  Sensor sensor = sensorOf();
  sensor.rangeMin = 3;
  sensor.columns = 441;  // leaves the last packet of each row incomplete
  const Pose pose = {{far.x + 1.5, far.y - 0.5, far.z + 0.2}, {0, 0, std::sin(0.2), std::cos(0.2)}};
  for (EmbreeWay way :
       {EmbreeWay::flat, EmbreeWay::instanced, EmbreeWay::rebuilt, EmbreeWay::placed, EmbreeWay::refitted}) {
    const auto rival = makeEmbree(scene, far, way);
    CAPTURE(rival->name());
    CHECK(rival->build() > 0);
    const auto compareNow = [&](const Scene& truth) {
      Hits hits;
      CHECK(rival->trace(sensor, pose, hits) > 0);
      Scan scan;
      scan.ranges = hits.ranges;
      scan.triangles = hits.triangles;
      scan.instances = hits.instances;
      const Scan reference = test::referenceOf(truth, sensor, pose, ReflectingFaces::both);
      CHECK(reference.counters.hits > 300);
      const Comparison c = compare(reference, scan, 1e-4);
      CHECK(c.missed + c.falseHits + c.wrongOwner == 0);
      CHECK(c.rangeErrorMax < 1e-4);
    };
    compareNow(scene);
    Scene moved = scene;
    std::vector<Moved> moves;
    for (size_t i = 0; i < scene.instances.size(); i += 2) {
      moved.instances[i].transform = test::translation(0, -3, 0.1) * scene.instances[i].transform;
      moves.push_back({i, moved.instances[i].transform});
    }
    CHECK(rival->update(moves) > 0);
    compareNow(moved);
  }
}

TEST_CASE("rates are measured on memory and cores") {
  const Rates host = ratesOf({.type = "cpu"}, "auto");
  CHECK(host.bytesPerMs > 1e5);  // 100 MB/s
  CHECK(host.bytesPerMs < 1e10);
  CHECK(host.operationsPerMs > 1e5);
  CHECK(host.operationsPerMs < 1e11);
  test::needVulkan();
  const double copies = ratesOf({.type = "discrete"}, "auto").bytesPerMs;  // 0 without ray tracing
  CHECK((copies == 0 || (copies > 1e5 && copies < 1e11)));
  CHECK(ratesOf({.type = "discrete"}, "no such device").known() == false);
}
