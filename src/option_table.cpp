// SPDX-License-Identifier: Apache-2.0
// The sentences are those of gnosphere/simulator.hpp; a test compares.
#include "option_table.hpp"

#include "base/lasting.hpp"
#include "base/nearest_text.hpp"
#include "effects/decide.hpp"
#include "effects/parameter_text.hpp"

namespace gnosphere {
namespace {

using S = SimulatorOptions;
using Parts = AccuracyParts;

std::vector<ChoiceWord> accuracyWords() {
  std::vector<ChoiceWord> words;
  for (const AccuracySetting& setting : accuracySettings()) words.push_back({setting.name, setting.doc});
  return words;
}

/// Makes the row of the option `accuracy`. A new value replaces parts that were given one by one.
Option<S> accuracyOption() {
  const auto get = [](const S& options) { return static_cast<size_t>(options.accuracy); };
  const auto set = [](S& options, size_t word) {
    options.accuracy = static_cast<Accuracy>(word);
    options.accuracyParts.reset();
  };
  return {{"accuracy", "", "Named choices of its parts.", ChoiceParameter<S>{accuracyWords(), get, set}},
          Changes::cloud};
}

/// One part of the accuracy; the others stay those of SimulatorOptions::accuracy.
template <auto kPart>
Option<S> part(const char* name, std::vector<ChoiceWord> words, const char* doc) {
  const auto get = [](const S& options) { return static_cast<size_t>(accuracyPartsOf(options).*kPart); };
  const auto set = [](S& options, size_t word) {
    Parts parts = accuracyPartsOf(options);
    parts.*kPart = static_cast<std::remove_reference_t<decltype(parts.*kPart)>>(word);
    options.accuracyParts = parts;
  };
  return {{name, "", doc, ChoiceParameter<S>{std::move(words), get, set}}, Changes::cloud};
}

std::vector<Option<S>> makeSimulatorTable() {
  using namespace rows;
  using enum Changes;
  return {
      accuracyOption(),
      part<&Parts::bounds>(
          "accuracy_parts.bounds",
          {{"paper", "The floor of the corners' angles, computed with GLSL's asin and atan."},
           {"corners",
            "The corners' angles, widened for rounding: misses beams where an edge bulges beyond them and at the "
            "poles."},
           {"exact", "Every beam that can meet the triangle."}},
          "Which beams a triangle is tested against."),
      part<&Parts::cull>("accuracy_parts.cull", {{"first_corner"}, {"nearest_point"}},
                         "Which point of a triangle must be in range."),
      part<&Parts::inside>("accuracy_parts.inside",
                           {{"plain", "Signs of the edge normals a x b, equation 2 of the paper."},
                            {"watertight", "No beam slips between triangles that share an edge or a corner."},
                            {"exact", "Exact signs; a beam on a shared edge hits exactly one triangle."}},
                           "How the inside test decides whether a beam hits a triangle."),
      part<&Parts::range>("accuracy_parts.range",
                          {{"plane", "Equation 4 of the paper."},
                           {"edge_weights", "A convex combination of the depths of the corners."},
                           {"exact", "The exact quotient, correctly rounded; only with the exact inside test."}},
                          "How the range of a hit is computed."),
      {choice<&S::faces>(
           "faces",
           {{"material", "Both faces of double-sided materials, the front of others; only glTF files have others."},
            {"front"},
            {"both"}},
           "Which faces of a triangle reflect."),
       cloud},
      {choice<&S::tuning, &Tuning::binning>(
           "tuning.binning",
           {{"auto",
             "Slabs on a CPU; nearest on other devices and for footprints; lists with the bounds of the paper."},
            {"nearest", "One 64-bit atomic minimum per hit; replaced by lists on devices without that instruction."},
            {"lists", "A list of candidates per beam: count, prefix sum, fill."},
            {"slabs",
             "One subgroup owns a slab of columns, so the minimum needs no atomics; replaced by lists as `nearest` "
             "is."}},
           "How the hits of each beam are collected. Every choice gives the same cloud."),
       time},
      {flag<&S::tuning, &Tuning::culling, &Culling::range>(
           "tuning.culling.range", "Triangles out of range are skipped before they are projected."),
       time},
      {flag<&S::tuning, &Tuning::culling, &Culling::rows>(
           "tuning.culling.rows",
           "Triangles between two rows of beams, or above or below the field of view, are skipped."),
       time},
      {flag<&S::tuning, &Tuning::culling, &Culling::columns>("tuning.culling.columns",
                                                             "Triangles between two columns of beams are skipped."),
       time},
      {flag<&S::tuning, &Tuning::culling, &Culling::cones>(
           "tuning.culling.cones", "Clusters of one-sided triangles that all face away are skipped."),
       time},
      {choice<&S::tuning, &Tuning::culling, &Culling::occlusion>(
           "tuning.culling.occlusion", {{"auto"}, {"always"}, {"never"}},
           "Triangles behind hits nearer to the sensor are skipped. The test reads the word of every beam, so by "
           "default it is used if the scene has enough triangles to make that worthwhile."),
       time},
      {choice<&S::tuning, &Tuning::subRays>(
           "tuning.sub_rays",
           {{"auto", "Lanes on a graphics card, one on a CPU."},
            {"lanes",
             "The lanes of a subgroup share the sub-rays of a beam. If a lane would have more than two, and with CUDA, "
             "the choice is `one`."},
            {"one", "One invocation has all sub-rays of a beam."}},
           "How the footprints that lie on several triangles are computed. Every choice gives the same cloud."),
       time},
      {flag<&S::tuning, &Tuning::keepStill>(
           "tuning.keep_still",
           "If true, a sensor that scans repeatedly from one pose keeps the hits on instances that have not moved (8 "
           "bytes per beam, from its second scan from that pose). Keeping hits has no effect with lists of hits or "
           "the paper's bounds."),
       time},
      {flag<&S::tuning, &Tuning::float64>("tuning.float64",
                                          "If false, double precision is not used even if the device has it."),
       time},
      {flag<&S::tuning, &Tuning::stageTimes>(
           "tuning.stage_times",
           "If true, the device's own time and that of each stage are measured on a CPU device, too. Other devices "
           "always measure them: it costs them nothing. Mesa's CPU driver stops its threads at every timestamp, which "
           "takes about 1 ms of a scan, as long as a scan of few beams itself."),
       time},
      {count<&S::tuning, &Tuning::maxBatchBytes>(
           "tuning.max_batch_bytes", "bytes", 0, UINT64_MAX,
           "Most bytes that scans which are submitted together take on the device in lists of instances and clusters; "
           "at least one scan is submitted. 0 means 256 MB on a CPU and 1 GB on other devices."),
       machine},
      {count<&S::tuning, &Tuning::maxSubmissionWork>(
           "tuning.max_submission_work", "", 0, UINT64_MAX,
           "Most triangles and lines of light, roughly counted, that one submission looks at on a Vulkan device of the "
           "library's own; a scan of more is several submissions, so that a desktop draws between them and its driver "
           "does not take the device for stuck. 0 means no limit on a CPU and 67,108,864 on other devices."),
       machine},
      {count<&S::tuning, &Tuning::maxBufferBytes>(
           "tuning.max_buffer_bytes", "bytes", 0, UINT64_MAX,
           "Upper limit in bytes for any one buffer on a Vulkan device; 0 means the limit of the device. If an array "
           "needs more, the call that needs it fails for want of memory; the simulator stays usable."),
       machine},
      {text<&S::cache>("cache",
                       "Folder in which compiled kernels are kept. If empty, it is \"gnosphere\" in $XDG_CACHE_HOME "
                       "or ~/.cache, and on Windows in %LOCALAPPDATA%; if \"off\", kernels are not kept."),
       machine},
      {flag<&S::validation>("validation",
                            "Turns the Vulkan validation layer on; its messages are errors of the device."),
       machine},
      {flag<&S::compileOnly>(
           "compile_only",
           "The simulator compiles the pipelines of its sensors' scans and cannot scan. Its plan has what the "
           "driver's compiler says of each pipeline. No device memory is needed and nothing is submitted, so a driver "
           "that only compiles is enough. Only for Vulkan devices of the library's own."),
       machine},
      {flag<&S::resultsOnDevice>(
           "results_on_device",
           "Results stay on the device: a stream of batches submits the scans, and no other call scans. "
           "Only for Vulkan devices of the library's own."),
       machine},
  };
}

std::vector<Option<SensorRequest>> makeRequestTable() {
  using namespace rows;
  return {
      {flag<&SensorRequest::variableWeather>("variable_weather",
                                             "If true, shots may bring their own weather: fog, rain, snow and volumes "
                                             "are planned even if `effects` gives them no value, unless they are off."),
       Changes::cloud},
      {indices<&SensorRequest::ignoredInstances>(
           "ignored_instances", "instance",
           "Indices of instances that the sensor does not see, for example the body of the robot that carries it: its "
           "scans are those of a scene without them. If an instance is removed, its index leaves the list, so that "
           "another one that gets it is seen."),
       Changes::cloud},
  };
}

template <class Owner>
const Option<Owner>& named(const std::vector<Option<Owner>>& table, const std::string& name) {
  std::vector<std::string> names, longer;
  for (const Option<Owner>& option : table) {
    const std::string known = option.parameter.name;
    if (known == name) return option;
    names.push_back(known);
    if (known.ends_with("." + name)) longer.push_back(known);
  }
  refuseArgument("no option is called '" + name + "'; " + nearestText(name, longer.empty() ? names : longer));
}

template <class Owner>
void assignTo(Owner& owner, const std::vector<Option<Owner>>& table, const std::string& assignment,
              const char* example) {
  const auto [name, value] = splitAssignment(assignment, example);
  const Parameter<Owner>& parameter = named(table, name).parameter;
  Owner changed = owner;
  readValue(parameter, changed, name, value);
  owner = std::move(changed);
}

}  // namespace

const std::vector<Option<SimulatorOptions>>& simulatorOptionTable() {
  static const auto& table = lasting(makeSimulatorTable());
  return table;
}

const std::vector<Option<SensorRequest>>& requestOptionTable() {
  static const auto& table = lasting(makeRequestTable());
  return table;
}

const Option<SimulatorOptions>& simulatorOption(const std::string& name) {
  return named(simulatorOptionTable(), name);
}

const Option<SensorRequest>& requestOption(const std::string& name) {
  return named(requestOptionTable(), name);
}

std::string changedOptions(const SimulatorOptions& options) {
  std::string text;
  for (const auto& [parameter, changes] : simulatorOptionTable()) {
    const std::string value = valueText(parameter, options);
    if (changes == Changes::machine || value == valueText(parameter, SimulatorOptions())) continue;
    text += (text.empty() ? "" : ", ") + quoted(parameter.name) + ": " + value;
  }
  return "{" + text + "}";
}

const std::vector<ChoiceWord>& wordsOf(const std::string& option) {
  return std::get<ChoiceParameter<SimulatorOptions>>(simulatorOption(option).parameter.kind).words;
}

void assign(SimulatorOptions& options, const std::string& assignment) {
  assignTo(options, simulatorOptionTable(), assignment, "tuning.binning=lists");
}

void assign(SensorRequest& request, const std::string& assignment) {
  assignTo(request, requestOptionTable(), assignment, "variable_weather=true");
}

}  // namespace gnosphere
