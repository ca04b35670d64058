// SPDX-License-Identifier: Apache-2.0
// Scene files: GnoSphere, its floor and the rivals from places where much detail is seen, while nothing moves and while
// everything does.
#include <algorithm>
#include <filesystem>
#include <optional>
#include <system_error>

#include "base/text.hpp"
#include "cases.hpp"
#include "poses.hpp"
#include "seen.hpp"

namespace gnosphere::bench {
namespace {

using cli::formatted;

struct File {
  std::filesystem::path path;
  std::string name;  ///< from the folder that was given, without its extension
};

bool isScene(const std::filesystem::path& path) {
  const std::string extension = lower(path.extension().string());
  constexpr const char* kExtensions[] = {".glb", ".gltf", ".obj", ".ply", ".stl"};
  return std::find(std::begin(kExtensions), std::end(kExtensions), extension) != std::end(kExtensions);
}

/// The given files, and all scene files of the given folders in order of their names.
std::vector<File> filesOf(const std::vector<std::string>& given) {
  namespace fs = std::filesystem;
  std::vector<File> files;
  for (const std::string& one : given) {
    std::error_code problem;
    if (!fs::is_directory(one, problem)) {
      if (!fs::exists(one, problem)) throw Error(ErrorCode::file, one + ": there is no such file or folder");
      files.push_back({one, fs::path(one).stem().string()});
      continue;
    }
    const size_t first = files.size();
    for (const auto& entry : fs::recursive_directory_iterator(one))
      if (entry.is_regular_file() && isScene(entry.path()))
        files.push_back({entry.path(), fs::relative(entry.path(), one).replace_extension().generic_string()});
    std::sort(files.begin() + static_cast<ptrdiff_t>(first), files.end(),
              [](const File& a, const File& b) { return a.path < b.path; });
  }
  return files;
}

std::string joined(const std::vector<std::string>& texts, const char* separator) {
  std::string all;
  for (const std::string& text : texts) all += (all.empty() ? "" : separator) + text;
  return all;
}

/// One scene and one sensor. An outcome is missing if the scene did not fit the device, or if a result was wrong.
struct SceneRow {
  std::string scene;
  uint64_t triangles = 0;
  std::string sensor;
  std::optional<Outcome> still, moving;
};
using Part = std::optional<Outcome> SceneRow::*;

const Standing* standingOf(const SceneRow& row, Part part, const std::string& name) {
  if (!(row.*part)) return nullptr;
  for (const Standing& standing : (row.*part)->standings)
    if (standing.name == name) return &standing;
  return nullptr;
}

/// Names of all that GnoSphere was compared with, in the order in which they first occur.
std::vector<std::string> othersOf(const std::vector<SceneRow>& rows, Part part) {
  std::vector<std::string> names;
  for (const SceneRow& row : rows) {
    if (!(row.*part)) continue;
    for (size_t i = 1; i < (row.*part)->standings.size(); ++i) {
      const std::string& name = (row.*part)->standings[i].name;
      if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
    }
  }
  return names;
}

/// Ratios over all scenes, each by its median.
struct Summary {
  std::string sensor, motion, name;
  size_t scenes = 0;
  double median = 0, least = 0;
  std::string leastScene;
  double leastFrame = 0;  ///< of any scene
};

Table tableOf(const std::vector<Summary>& summaries) {
  Table table = {"How many times as fast ours is, over the scenes", {}};
  table.rows = {{"sensor", "what moves", "beside", "scenes", "median", "least", "where", "least frame"}};
  for (const Summary& s : summaries)
    table.rows.push_back({s.sensor, s.motion, s.name, std::to_string(s.scenes), formatted("%.2f", s.median),
                          formatted("%.2f", s.least), s.leastScene, formatted("%.2f", s.leastFrame)});
  return table;
}

cli::Json toJson(const std::vector<Summary>& summaries) {
  cli::Json json = cli::Json::array();
  for (const Summary& s : summaries)
    json.push_back({{"sensor", s.sensor},
                    {"moving", s.motion},
                    {"name", s.name},
                    {"scenes", s.scenes},
                    {"median", rounded(s.median)},
                    {"least", rounded(s.least)},
                    {"least_scene", s.leastScene},
                    {"least_frame", rounded(s.leastFrame)}});
  return json;
}

class Measurement {
 public:
  explicit Measurement(Session& session) : session_(session) {}

  /// A scene that cannot be loaded, or that is too large for the device, is left out.
  void run(const File& file) {
    try {
      measure(file);
    } catch (const Error& error) {
      if (error.code() == ErrorCode::device) throw;
      session_.addNote(file.name + ": " + error.what());
    }
  }

  Report report() {
    const uint64_t least = session_.options().leastTriangles;
    if (!small_.empty())
      session_.addNote(
          formatted("with fewer than %s triangles, %zu in all: ", cli::grouped(least).c_str(), small_.size()) +
          joined(small_, ", "));
    if (rows_.empty())
      throw Error(ErrorCode::file, "--scene: no scene was measured: " + joined(session_.notes(), "; "));
    Report report;
    for (const SceneRow& row : rows_)
      for (const auto* outcome : {&row.still, &row.moving})
        if (*outcome) report.outcomes.push_back(**outcome);
    const std::vector<Summary> all = summaries();
    report.more = {{"seed", session_.options().seed}, {"scenes", scenes_}, {"summary", toJson(all)}};
    report.tables = {sceneTable(), tableOf(all)};
    report.bars = bars();
    report.wrong = wrong_;
    return report;
  }

 private:
  void measure(const File& file) {
    Scene scene = loadScene(file.path);
    if (scene.placedTriangleCount() < session_.options().leastTriangles) {
      small_.push_back(file.name + " (" + cli::grouped(scene.placedTriangleCount()) + ")");
      return;
    }
    // Rivals see both faces of every triangle, and real scenes show the backs of one-sided ones.
    for (Material& material : scene.materials) material.doubleSided = true;
    const std::vector<Pose> poses =
        detailedPoses(scene, session_.options().frames, session_.options().seed, session_.simulatorOptions().device);
    if (poses.empty()) {
      session_.addNote(file.name + ": there is no place for a sensor");
      return;
    }
    for (const Sensor& sensor : session_.sensors({"HDL-64E", "Hypothetical-256"}))
      measure(file.name, scene, sensor, poses);
    cli::Json places = cli::Json::array();
    for (const Pose& pose : poses) places.push_back(cli::toJson(pose));
    scenes_.push_back({{"name", file.name}, {"poses", places}});
  }

  void measure(const std::string& name, const Scene& scene, const Sensor& sensor, const std::vector<Pose>& poses) {
    SceneRow row = {name, scene.placedTriangleCount(), sensor.name};
    Round round = {name + ", " + sensor.name, static_cast<double>(row.triangles), scene, sensor};
    round.poses = poses;
    round.beside = Beside::seen;
    row.still = outcomeOf(round);
    round.label += ", everything may move";
    round.motion = Motion::everything;
    round.moving = scene.instances.size();
    round.step *= standingHeight(scene) / kFullHeight;  // in a small scene, 0.1 m would be out of sight
    row.moving = outcomeOf(round);
    if (row.still || row.moving) rows_.push_back(row);
  }

  /// A wrong result ends this contest alone, because the contests before it took long. The exit status is 1 in the
  /// end.
  std::optional<Outcome> outcomeOf(const Round& round) {
    std::vector<Outcome> outcomes;
    try {
      session_.hold(round, outcomes);
    } catch (const Error& error) {
      if (error.code() != ErrorCode::device) throw;
      session_.addNote(error.what());
      wrong_ = true;
    }
    if (outcomes.empty()) return {};
    return outcomes[0];
  }

  Table sceneTable() const {
    std::vector<std::string> still = othersOf(rows_, &SceneRow::still), moving = othersOf(rows_, &SceneRow::moving);
    std::erase(still, kSeen);
    Table table;
    table.rows = {{"scene", "triangles", "sensor", "ours ms", "floor ms", "ours / floor"}};
    cli::TableRow& head = table.rows[0];
    head.insert(head.end(), still.begin(), still.end());
    head.push_back("all moves: ours ms");
    head.insert(head.end(), moving.begin(), moving.end());
    for (const SceneRow& row : rows_) {
      cli::TableRow cells = {row.scene, cli::grouped(row.triangles), row.sensor, oursMs(row.still)};
      const Standing* floor = standingOf(row, &SceneRow::still, kSeen);
      cells.push_back(floor ? cli::bareMs(floor->totalMs.median) : "-");
      cells.push_back(floor ? formatted("%.2f (%.2f)", 1 / floor->ratio, 1 / floor->leastFrameRatio) : "-");
      addRatios(row, &SceneRow::still, still, cells);
      cells.push_back(oursMs(row.moving));
      addRatios(row, &SceneRow::moving, moving, cells);
      table.rows.push_back(cells);
    }
    table.note =
        "Milliseconds are medians of all frames and runs. A rival's column says how many times as fast ours is: the "
        "median of the ratios frame by frame and run by run, in brackets that of the frame where it is least. The "
        "floor is ours in a scene that holds nothing but the triangles that own a hit; in brackets is the frame that "
        "is farthest from it";
    return table;
  }

  static std::string oursMs(const std::optional<Outcome>& outcome) {
    return outcome ? cli::bareMs(outcome->standings[0].totalMs.median) : "-";
  }

  static void addRatios(const SceneRow& row, Part part, const std::vector<std::string>& names, cli::TableRow& cells) {
    for (const std::string& name : names) {
      const Standing* s = standingOf(row, part, name);
      cells.push_back(s ? formatted("%.2f (%.2f)", s->ratio, s->leastFrameRatio) : "-");
    }
  }

  std::vector<Summary> summaries() const {
    std::vector<Summary> all;
    for (const std::string& sensor : sensors())
      for (const auto& [part, motion] :
           {std::pair(&SceneRow::still, "nothing"), std::pair(&SceneRow::moving, "everything")})
        for (const std::string& name : othersOf(rows_, part)) all.push_back(summaryOf(sensor, part, motion, name));
    std::erase_if(all, [](const Summary& summary) { return summary.scenes == 0; });
    return all;
  }

  Summary summaryOf(const std::string& sensor, Part part, const char* motion, const std::string& name) const {
    Summary summary = {sensor, motion, name};
    std::vector<double> ratios;
    for (const SceneRow& row : rows_) {
      const Standing* s = row.sensor == sensor ? standingOf(row, part, name) : nullptr;
      if (!s) continue;
      if (ratios.empty() || s->ratio < summary.least) summary.least = s->ratio, summary.leastScene = row.scene;
      if (ratios.empty() || s->leastFrameRatio < summary.leastFrame) summary.leastFrame = s->leastFrameRatio;
      ratios.push_back(s->ratio);
    }
    summary.scenes = ratios.size();
    summary.median = spreadOf(ratios).median;
    return summary;
  }

  std::vector<std::string> sensors() const {
    std::vector<std::string> names;
    for (const SceneRow& row : rows_)
      if (std::find(names.begin(), names.end(), row.sensor) == names.end()) names.push_back(row.sensor);
    return names;
  }

  /// Ratios to the first rival while nothing moves, sensor by sensor.
  BarChart bars() const {
    BarChart chart;
    std::vector<std::string> rivals = othersOf(rows_, &SceneRow::still);
    std::erase(rivals, kSeen);
    if (rivals.empty()) return chart;
    chart.xLabel = "times as fast as " + rivals[0] + "; line: from the frame with the least to that with the most";
    for (const std::string& sensor : sensors())
      for (const SceneRow& row : rows_)
        if (const Standing* s = row.sensor == sensor ? standingOf(row, &SceneRow::still, rivals[0]) : nullptr)
          chart.bars.push_back({row.scene + ", " + sensor, s->ratio, s->leastFrameRatio, s->mostFrameRatio});
    return chart;
  }

  Session& session_;
  std::vector<SceneRow> rows_;
  std::vector<std::string> small_;  ///< scenes with too few triangles
  cli::Json scenes_ = cli::Json::array();
  bool wrong_ = false;
};

}  // namespace

Report real(Session& session) {
  Measurement measurement(session);
  for (const File& file : filesOf(session.options().scenes)) measurement.run(file);
  return measurement.report();
}

}  // namespace gnosphere::bench
