// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <system_error>

#include "base/file.hpp"
#include "base/json_text.hpp"
#include "base/path.hpp"
#include "base/text.hpp"
#include "commands.hpp"
#include "console.hpp"
#include "output/cloud_format.hpp"
#include "scanning.hpp"
#include "view/page.hpp"
#include "view/series.hpp"

namespace gnosphere::cli {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

/// Browsers open pages of this size in a few seconds.
constexpr uint64_t kMostBytes = 64'000'000;

struct ViewCall {
  std::string a, b, output, colour, sensor, frames;
  std::string three = "/usr/share/javascript/three";
  size_t every = 1;
  double distance = 0.01;
};

/// Returns three.js and its controls, with the licence that they are under.
std::string readThree(const std::string& folder) {
  std::string text =
      "/*! three.js and OrbitControls, https://threejs.org\nCopyright (c) 2010-2019 three.js authors. Permission is "
      "hereby granted, free of charge, to any person obtaining a copy of this software and associated documentation "
      "files (the \"Software\"), to deal in the Software without restriction, including without limitation the rights "
      "to use, copy, modify, merge, publish, distribute, sublicense, and/or sell copies of the Software, and to permit "
      "persons to whom the Software is furnished to do so, subject to the following conditions: The above copyright "
      "notice and this permission notice shall be included in all copies or substantial portions of the Software. THE "
      "SOFTWARE IS PROVIDED \"AS IS\", WITHOUT WARRANTY OF ANY KIND, EXPRESS OR IMPLIED, INCLUDING BUT NOT LIMITED TO "
      "THE WARRANTIES OF MERCHANTABILITY, FITNESS FOR A PARTICULAR PURPOSE AND NONINFRINGEMENT. IN NO EVENT SHALL THE "
      "AUTHORS OR COPYRIGHT HOLDERS BE LIABLE FOR ANY CLAIM, DAMAGES OR OTHER LIABILITY, WHETHER IN AN ACTION OF "
      "CONTRACT, TORT OR OTHERWISE, ARISING FROM, OUT OF OR IN CONNECTION WITH THE SOFTWARE OR THE USE OR OTHER "
      "DEALINGS IN THE SOFTWARE. */\n";
  for (const char* name : {"build/three.min.js", "examples/js/controls/OrbitControls.js"}) {
    const fs::path file = pathOf(folder) / name;
    std::error_code absent;
    if (!fs::exists(file, absent))
      throw Error(ErrorCode::file, file.string() +
                                       ": is not there; install three.js, the package libjs-three of Debian and "
                                       "Ubuntu, or say where it is with --three");
    text += readWholeFile(file) + "\n";
  }
  return text;
}

/// The boxes of a file of the drive's format `boxes`, as the page needs them.
Json readBoxes(const fs::path& file) {
  Json boxes = Json::array();
  const std::string text = readWholeFile(file);
  size_t number = 0;
  for (size_t at = 0; at < text.size(); ++number) {
    const size_t end = std::min(text.find('\n', at), text.size());
    try {
      const Json box = parseJson<Json>(text.substr(at, end - at));
      const Json& pose = box.at("sensor_frame");
      boxes.push_back({{"name", box.at("name")},
                       {"class", box.at("class")},
                       {"points", box.at("points")},
                       {"moving", box.at("moving")},
                       {"position", pose.at("position").get<std::array<double, 3>>()},
                       {"orientation", pose.at("orientation").get<std::array<double, 4>>()},
                       {"size", box.at("size").get<std::array<double, 3>>()}});
    } catch (const Json::exception&) {
      throw Error(ErrorCode::format, file.string() + ": line " + std::to_string(number + 1) + " is no box");
    }
    at = end + 1;
  }
  return boxes;
}

/// Refuses a page that is too large, or will be when the rest of its frames are in it.
void checkSize(const ViewCall& call, const Page& page, size_t frames) {
  const uint64_t bytes = page.dataBytes() * frames / page.frameCount();
  if (bytes <= kMostBytes) return;
  const uint64_t every = call.every * ((bytes + kMostBytes - 1) / kMostBytes);
  throw Error(ErrorCode::invalidArgument, call.output + ": would have " + grouped(bytes / 1'000'000) +
                                              " MB, more than the " + grouped(kMostBytes / 1'000'000) +
                                              " MB that browsers open well; show every point in " +
                                              std::to_string(every) + " with --every " + std::to_string(every) +
                                              (frames > 1 ? ", or some of the frames with --frames A:B" : ""));
}

/// Keeps the frames that --frames states.
void keepFrames(const ViewCall& call, Series& series) {
  uint64_t first = 0, end = UINT64_MAX;
  chooseFrames(call.frames, first, end);
  const uint64_t last = series.frames.back().number;
  std::erase_if(series.frames, [&](const SeriesFrame& f) { return f.number < first || f.number >= end; });
  if (series.frames.empty())
    throw Error(ErrorCode::invalidArgument,
                "--frames: the last frame is " + std::to_string(last) + ", so " + call.frames + " is none");
}

Json addSeries(const ViewCall& call, Page& page) {
  Series series = findSeries(pathOf(call.a), call.sensor);
  if (series.frames.empty()) throw Error(ErrorCode::invalidArgument, call.a + ": holds no clouds");
  keepFrames(call, series);
  Progress progress("frame", series.frames.size());
  std::optional<Origin> origin;
  for (const SeriesFrame& frame : series.frames) {
    const ViewCloud cloud = readViewCloud(frame.cloud, origin);
    origin = cloud.origin;
    PageFrame shown{"frame " + std::to_string(frame.number), everyNth(cloud, call.every)};
    for (ViewColumn& column : shown.cloud.columns)
      if (column.isId) column.names.insert(series.names[column.name].begin(), series.names[column.name].end());
    if (!frame.boxes.empty()) shown.boxes = readBoxes(frame.boxes);
    page.add(std::move(shown));
    checkSize(call, page, series.frames.size());
    progress.step(page.frameCount());
  }
  for (const std::string& note : series.notes) complain("warning: " + note);
  return {{"title", series.name}, {"notes", series.notes}};
}

Json addCloud(const ViewCall& call, Page& page) {
  page.add({pathOf(call.a).filename().string(), everyNth(readViewCloud(pathOf(call.a)), call.every)});
  checkSize(call, page, 1);
  return {{"title", pathOf(call.a).filename().string()}, {"notes", Json::array()}};
}

Json addDifference(const ViewCall& call, Page& page) {
  const ViewCloud a = readViewCloud(pathOf(call.a)), b = readViewCloud(pathOf(call.b), a.origin);
  warnOfFloats(call.a, a.floatStep, "--distance", call.distance);
  warnOfFloats(call.b, b.floatStep, "--distance", call.distance);
  const ViewCloud both = differenceOf(a, b, call.distance);
  // Each cloud has counts of its own: a point that is the same in both is one of A and one of B.
  const ViewColumn& difference = *both.find("difference");
  auto kinds = difference.values.begin();
  for (const auto& [cloud, name] : {std::pair(&a, "A"), std::pair(&b, "B")}) {
    const auto end = kinds + static_cast<ptrdiff_t>(cloud->size());
    std::string summary = grouped(cloud->size()) + " points";
    for (const auto& [kind, what] : difference.names)
      if (const auto count = std::count(kinds, end, kind); count > 0)
        summary += ", " + grouped(static_cast<uint64_t>(count)) + " " + what;
    say(name, summary);
    kinds = end;
  }
  page.add({"A and B", everyNth(both, call.every)});
  checkSize(call, page, 1);
  const bool byBeam = comparesBeams(a, b);
  return {{"title", pathOf(call.a).filename().string() + " and " + pathOf(call.b).filename().string()},
          {"notes",
           {"A is " + call.a + ", B is " + call.b + ".",
            std::string(byBeam ? "Points of one beam are compared" : "Each point is compared with the nearest one") +
                "; they differ if they are more than " + formatted("%g", call.distance) + " m apart."}},
          {"colour", "difference"}};
}

int runView(const ViewCall& call) {
  if (!lower(pathOf(call.output).extension().string()).starts_with(".htm"))
    throw Error(ErrorCode::invalidArgument, call.output + ": the page's name ends with .html");
  if (!(call.distance >= 0 && call.distance <= 1e9))  // NaN is within any CLI::Range
    throw Error(ErrorCode::invalidArgument, "--distance: " + formatted("%g", call.distance) + " is not 0..1e9 m");
  const std::string three = readThree(call.three);
  checkWritable(pathOf(call.output));
  std::error_code absent;
  const bool isFolder = fs::is_directory(pathOf(call.a), absent);
  if (!call.b.empty() && (isFolder || fs::is_directory(pathOf(call.b), absent)))
    throw Error(ErrorCode::invalidArgument,
                (isFolder ? call.a : call.b) + ": is a folder; two clouds are compared, or one folder is shown");
  if (!isFolder && !(call.sensor + call.frames).empty())
    throw Error(ErrorCode::invalidArgument,
                std::string(call.sensor.empty() ? "--frames" : "--sensor") + ": " + call.a + " is one cloud");
  Page page;
  Json head = !call.b.empty() ? addDifference(call, page) : isFolder ? addSeries(call, page) : addCloud(call, page);
  if (!call.colour.empty()) {
    const std::vector<std::string> names = page.fieldNames();
    std::string known;
    for (const std::string& name : names) known += (known.empty() ? "" : ", ") + name;
    if (std::find(names.begin(), names.end(), call.colour) == names.end())
      throw Error(ErrorCode::invalidArgument, "--colour: there is no field '" + call.colour + "'; there are " + known);
    head["colour"] = call.colour;
  }
  head["every"] = call.every;
  AtomicFile out(pathOf(call.output));
  out.write(page.html(std::move(head), three));
  out.commit();
  say("frames", grouped(page.frameCount()) + " with " + grouped(page.pointCount()) + " points");
  say("page", call.output + ", " + fileSize(call.output));
  return 0;
}

}  // namespace

Action addView(CLI::App& app) {
  const auto call = std::make_shared<ViewCall>();
  app.add_option("CLOUD", call->a,
                 "A cloud (" + cloudEndings("or") + "), the output folder of gnosphere drive, or a folder of clouds")
      ->required();
  CLI::Option* const second = app.add_option("B", call->b, "Another cloud, to show how the two differ");
  app.add_option("-o,--output", call->output, "Page to write (.html)")->required();
  app.add_option("--colour", call->colour, "Field to begin with; the page has a list of all");
  app.add_option("--every", call->every, "Show every N-th point only")
      ->check(CLI::Range(uint64_t{1}, uint64_t{0xffffffff}));
  app.add_option("--frames", call->frames, "Show the frames from A on and before B only, A:B");
  app.add_option("--sensor", call->sensor, "Sensor of a drive to show instead of its first");
  app.add_option("--distance", call->distance, "Distance in metres from which on points of A and B differ")
      ->capture_default_str()
      ->needs(second);
  app.add_option("--three", call->three, "Folder of three.js")->capture_default_str();
  app.footer(
      "The page needs no other file and no network.\n"
      "Example: gnosphere view cloud.pcd -o cloud.html");
  return [call] { return runView(*call); };
}

}  // namespace gnosphere::cli
