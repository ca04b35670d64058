// SPDX-License-Identifier: Apache-2.0
// The tables of options, accuracies, effects and formats, and everything that repeats them: headers, the schema of
// drive files, the documents.
#include <catch2/catch_test_macros.hpp>
#include <catch2/matchers/catch_matchers_exception.hpp>
#include <cctype>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <variant>
#include <vector>

#include "base/file.hpp"
#include "base/limits.hpp"
#include "common/effects/parameters.h"
#include "drive/formats/format.hpp"
#include "effects/effect_table.hpp"
#include "folder.hpp"
#include "gnosphere/error.hpp"
#include "house/table_docs.hpp"
#include "option_table.hpp"
#include "output/cloud_format.hpp"
#include "scan/fields.hpp"

using namespace gnosphere;
using namespace gnosphere::test;
using Catch::Matchers::Message;

namespace {

const std::string kSource = GNOSPHERE_SOURCE;

template <class Owner>
void refused(const std::string& assignment, const std::string& why) {
  INFO(assignment);
  Owner owner;
  CHECK_THROWS_MATCHES(assign(owner, assignment), Error, Message(why));
}

/// Checks that a header has the sentence, whatever its lines and capitals are.
void checkSentence(const std::string& header, const std::string& sentence) {
  INFO(sentence);
  CHECK(header.find(sentences(sentence)) != std::string::npos);
}

template <class Owner>
void checkSentences(const std::string& header, const Parameter<Owner>& parameter) {
  INFO(parameter.name);
  checkSentence(header, parameter.doc);
  if (const auto* choice = std::get_if<ChoiceParameter<Owner>>(&parameter.kind))
    for (const ChoiceWord& word : choice->words) checkSentence(header, word.doc);
}

template <class Owner>
std::string tableOf(const std::vector<Option<Owner>>& options) {
  std::string table;
  for (const auto& [parameter, changes] : options)
    table += tableRow(parameter) + " | " + kChanges[static_cast<size_t>(changes)] + " |\n";
  return table;
}

/// Returns a value of a parameter other than its default.
template <class Owner>
nlohmann::json otherValue(const Parameter<Owner>& parameter) {
  const Owner defaults;
  Owner owner;
  return std::visit(
      Visitor{[&](const NumberParameter<Owner>& n) { return nlohmann::json(n.of(owner) == n.min ? n.max : n.min); },
              [&](const CountParameter<Owner>& n) { return nlohmann::json(n.get(defaults) == n.min ? n.max : n.min); },
              [&](const FlagParameter<Owner>& flag) { return nlohmann::json(!flag.of(owner)); },
              [&](const ChoiceParameter<Owner>& choice) {
                return nlohmann::json(choice.words[choice.get(defaults) == 0 ? 1 : 0].name);
              },
              [](const TextParameter<Owner>&) { return nlohmann::json("another"); },
              [](const IndicesParameter<Owner>&) {
                return nlohmann::json{3u, 4u};
              },
              [](const BoxesParameter<Owner>&) {
                return nlohmann::json{{{"min", {0, 0, 0}}, {"max", {1, 1, 1}}, {"extinction", 0.5}}};
              }},
      parameter.kind);
}

/// Checks that each of these parameters, set to another value, changes its own text and no other one.
template <class Owner>
void checkAlone(const std::vector<const Parameter<Owner>*>& all) {
  for (const Parameter<Owner>* parameter : all) {
    Owner owner;
    readValue(*parameter, owner, parameter->name, otherValue(*parameter));
    for (const Parameter<Owner>* other : all) {
      INFO(parameter->name << " and " << other->name);
      CHECK((valueText(*other, owner) == valueText(*other, Owner())) == (other != parameter));
    }
  }
}

}  // namespace

TEST_CASE("an assignment sets an option of a simulator or of a sensor's request") {
  SimulatorOptions options;
  assign(options, "accuracy=exact");
  CHECK(options.accuracy == Accuracy::exact);
  assign(options, "accuracy_parts.range=plane");
  REQUIRE(options.accuracyParts);
  CHECK(options.accuracyParts->range == AccuracyParts::Range::plane);
  CHECK(options.accuracyParts->inside == AccuracyParts::Inside::exact);  // the others stay those of `exact`
  assign(options, "accuracy=draft");
  CHECK(options.accuracy == Accuracy::draft);
  CHECK_FALSE(options.accuracyParts);
  assign(options, "tuning.binning=lists");
  assign(options, "tuning.culling.rows=false");
  assign(options, "tuning.max_buffer_bytes=18446744073709551615");
  assign(options, "cache=off");
  CHECK(options.tuning.binning == Binning::lists);
  CHECK_FALSE(options.tuning.culling.rows);
  CHECK(options.tuning.maxBufferBytes == UINT64_MAX);
  CHECK(options.cache == "off");
  SensorRequest request;
  assign(request, "variable_weather=true");
  assign(request, "ignored_instances=[3,4]");
  CHECK(request.variableWeather);
  CHECK(request.ignoredInstances == std::vector<uint32_t>{3, 4});
}

TEST_CASE("docs/limits.md has the table of limits, and the kernels keep to it") {
  std::string table;
  for (const Limit* limit : limits::kAll)
    table += "| " + std::to_string(limit->most) + " " + limit->what + " | " + limit->beyond + " |\n";
  checkTable(kSource + "/docs/limits.md", "## Scenes, sensors and effects", table);
  CHECK(limits::kLayers.most == gpu::kMaxLayers);
  CHECK(limits::kEchoes.most == gpu::kMaxEchoes);
  CHECK(limits::kEchoes.what == "echoes per beam, " + std::to_string(gpu::kFewEchoes) + " if it has at most " +
                                    std::to_string(gpu::kFewReturns) + " returns");
  CHECK(limits::kCoordinate.holds(gpu::kCoordinateLimit));
  CHECK_FALSE(limits::kCoordinate.holds(1.0001 * gpu::kCoordinateLimit));
  CHECK(limits::kPlaced.most == limits::kCoordinate.most);
}

TEST_CASE("docs/api.md has a row with name and type for every field") {
  const std::string page = readWholeFile(kSource + "/docs/api.md");
  const size_t begin = page.find("| name | `Field` | type |");
  REQUIRE(begin != page.npos);
  std::istringstream rows(page.substr(begin, page.find("\n\n", begin) - begin));
  std::string row;
  std::getline(rows, row);
  std::getline(rows, row);
  for (size_t i = 0; i < kFieldCount; ++i) {
    const FieldInfo field = fieldInfo(static_cast<Field>(i));
    const std::string count = field.components > 1 ? std::to_string(field.components) + " " : "";
    REQUIRE(std::getline(rows, row));
    INFO(row);
    CHECK(row.starts_with("| `" + std::string(field.name) + "` | "));
    CHECK(row.find(" | " + count + nameOf(field.type) + " | ") != row.npos);
  }
  CHECK_FALSE(std::getline(rows, row));
}

TEST_CASE("a count beyond a limit is an error that names whose it is and the limit") {
  CHECK_NOTHROW(limits::kFrames.check(16, "it has"));
  CHECK_THROWS_MATCHES(limits::kFrames.check(17, "it has"), Error,
                       Message("it has 17 frames of a recorder, or batches of a stream, in flight; the limit is 16"));
}

TEST_CASE("every option sets the member that has its name") {
  using S = SimulatorOptions;
  using P = AccuracyParts;
  struct Case {
    const char* assignment;
    bool (*isSet)(const S&);
  };
  constexpr uint64_t kMany = uint64_t{1} << 40;
  const Case cases[] = {
      {"accuracy=draft", [](const S& o) { return o.accuracy == Accuracy::draft; }},
      {"accuracy_parts.bounds=corners", [](const S& o) { return o.accuracyParts->bounds == P::Bounds::corners; }},
      {"accuracy_parts.cull=first_corner", [](const S& o) { return o.accuracyParts->cull == P::Cull::firstCorner; }},
      {"accuracy_parts.inside=plain", [](const S& o) { return o.accuracyParts->inside == P::Inside::plain; }},
      {"accuracy_parts.range=plane", [](const S& o) { return o.accuracyParts->range == P::Range::plane; }},
      {"faces=front", [](const S& o) { return o.faces == ReflectingFaces::front; }},
      {"tuning.binning=nearest", [](const S& o) { return o.tuning.binning == Binning::nearest; }},
      {"tuning.culling.range=false", [](const S& o) { return !o.tuning.culling.range; }},
      {"tuning.culling.rows=false", [](const S& o) { return !o.tuning.culling.rows; }},
      {"tuning.culling.columns=false", [](const S& o) { return !o.tuning.culling.columns; }},
      {"tuning.culling.cones=false", [](const S& o) { return !o.tuning.culling.cones; }},
      {"tuning.culling.occlusion=always",
       [](const S& o) { return o.tuning.culling.occlusion == Culling::Occlusion::always; }},
      {"tuning.sub_rays=one", [](const S& o) { return o.tuning.subRays == SubRays::one; }},
      {"tuning.keep_still=false", [](const S& o) { return !o.tuning.keepStill; }},
      {"tuning.float64=false", [](const S& o) { return !o.tuning.float64; }},
      {"tuning.stage_times=true", [](const S& o) { return o.tuning.stageTimes; }},
      {"tuning.max_batch_bytes=1099511627776", [](const S& o) { return o.tuning.maxBatchBytes == kMany; }},
      {"tuning.max_submission_work=1099511627776", [](const S& o) { return o.tuning.maxSubmissionWork == kMany; }},
      {"tuning.max_buffer_bytes=1099511627776", [](const S& o) { return o.tuning.maxBufferBytes == kMany; }},
      {"cache=here", [](const S& o) { return o.cache == "here"; }},
      {"validation=true", [](const S& o) { return o.validation; }},
      {"compile_only=true", [](const S& o) { return o.compileOnly; }},
      {"results_on_device=true", [](const S& o) { return o.resultsOnDevice; }}};
  std::vector<std::string> names, tried;
  for (const auto& option : simulatorOptionTable()) names.push_back(option.parameter.name);
  for (const Case& one : cases) {
    INFO(one.assignment);
    S options;
    assign(options, one.assignment);
    CHECK(one.isSet(options));
    tried.push_back(std::string(one.assignment).substr(0, std::string(one.assignment).find('=')));
  }
  CHECK(tried == names);
}

TEST_CASE("an option, or a parameter of an effect, changes no other one") {
  std::vector<const Parameter<SimulatorOptions>*> options;
  for (const auto& option : simulatorOptionTable())
    if (option.parameter.name != std::string("accuracy")) options.push_back(&option.parameter);  // it sets its parts
  checkAlone(options);
  std::vector<const Parameter<SensorRequest>*> requests;
  for (const auto& option : requestOptionTable()) requests.push_back(&option.parameter);
  checkAlone(requests);
  std::vector<const Parameter<Effects>*> effects = {&seedParameter()};
  for (const EffectInfo& effect : effectTable())
    for (const Parameter<Effects>& parameter : effect.parameters) effects.push_back(&parameter);
  CHECK(effects.size() > 30);
  checkAlone(effects);
}

TEST_CASE("every option can be read, and every word of a choice set") {
  for (const auto& [parameter, changes] : simulatorOptionTable()) {
    INFO(parameter.name);
    const SimulatorOptions defaults;
    SimulatorOptions options;
    assign(options, std::string(parameter.name) + "=" + valueText(parameter, defaults));
    CHECK(valueText(parameter, options) == valueText(parameter, defaults));
    if (const auto* choice = std::get_if<ChoiceParameter<SimulatorOptions>>(&parameter.kind))
      for (const ChoiceWord& word : choice->words) {
        assign(options, parameter.name + std::string("=") + word.name);
        CHECK(valueText(parameter, options) == quoted(word.name));
      }
  }
}

TEST_CASE("an assignment that is wrong names the nearest options, or the values") {
  using S = SimulatorOptions;
  refused<S>("accuracy", "'accuracy' is not NAME=VALUE, as tuning.binning=lists");
  refused<S>("acuracy=exact", "no option is called 'acuracy'; the nearest are accuracy, cache, faces");
  refused<S>("binning=lists", "no option is called 'binning'; there is tuning.binning");
  refused<S>("range=plane", "no option is called 'range'; there are accuracy_parts.range, tuning.culling.range");
  refused<S>("faces=back", "faces must be material, front or both, is \"back\"");
  refused<S>("tuning.keep_still=2", "tuning.keep_still must be true or false, is 2");
  refused<S>("tuning.max_buffer_bytes=-1",
             "tuning.max_buffer_bytes must be a whole number, 0..18446744073709551615, is -1");
  refused<SensorRequest>("ignored_instances=3",
                         "ignored_instances must be a list of instance indices, as [0, 3], is 3");
}

TEST_CASE("the accuracies are in the order of the enum, and the C interface has them") {
  std::string names;
  for (size_t i = 0; i < accuracySettings().size(); ++i) {
    const AccuracySetting& setting = accuracySettings()[i];
    CHECK(static_cast<size_t>(setting.accuracy) == i);
    CHECK(nameOf(setting.accuracy) == std::string(setting.name));
    names += i ? ", GNO_ACCURACY_" : " GNO_ACCURACY_";
    for (const char* c = setting.name; *c; ++c) names += static_cast<char>(std::toupper(*c));
    names += " = " + std::to_string(i);
  }
  checkRepeated(kSource + "/include/gnosphere.h", 0, "typedef int32_t gno_accuracy;\nenum {", " };", names);
}

TEST_CASE("the sentences of the tables are those of the headers") {
  const std::string options = sentences(bytesOf(kSource + "/include/gnosphere/simulator.hpp"));
  for (const auto& option : simulatorOptionTable()) checkSentences(options, option.parameter);
  for (const auto& option : requestOptionTable()) checkSentences(options, option.parameter);
  const std::string effects = sentences(bytesOf(kSource + "/include/gnosphere/effects.hpp"));
  checkSentences(effects, seedParameter());
  for (const EffectInfo& effect : effectTable()) {
    INFO(effect.name);
    checkSentence(effects, effect.doc);
    for (const Parameter<Effects>& parameter : effect.parameters) checkSentences(effects, parameter);
  }
}

TEST_CASE("docs/options.md has the tables of options and of accuracies") {
  const std::string page = kSource + "/docs/options.md";
  std::string accuracies;
  for (const AccuracySetting& setting : accuracySettings())
    accuracies += "| `" + std::string(setting.name) + "` | " + setting.doc + " |\n";
  checkTable(page, "## Options of a simulator", tableOf(simulatorOptionTable()));
  checkTable(page, "## Options of a sensor's request", tableOf(requestOptionTable()));
  checkTable(page, "## Accuracies", accuracies);
}

TEST_CASE("the page of every effect has the table of its parameters") {
  for (const EffectInfo& effect : effectTable()) {
    std::string table;
    for (const Parameter<Effects>& parameter : effect.parameters) table += tableRow(parameter) + " |\n";
    if (!table.empty()) checkTable(kSource + "/docs/effects/" + effect.name + ".md", "| parameter | unit |", table);
  }
}

TEST_CASE("the schema of drive files has the options that change clouds, and the formats") {
  const std::string file = kSource + "/src/drive/drive.schema.json";
  const auto checkWords = [&](size_t from, const std::string& name, const nlohmann::json& words) {
    std::string list;
    for (const nlohmann::json& word : words) list += (list.empty() ? "" : ", ") + word.dump();
    return checkRepeated(file, from, quoted(name.c_str()) + ": {\"enum\": [", "]", list);
  };
  size_t at = 0;
  nlohmann::json simulator = nlohmann::json::object();
  for (const auto& [parameter, changes] : simulatorOptionTable()) {
    if (changes != Changes::cloud) continue;
    nlohmann::json* object = &simulator;
    std::string name = parameter.name;
    for (size_t dot = name.find('.'); dot != name.npos; dot = name.find('.')) {
      nlohmann::json& group = (*object)[name.substr(0, dot)];
      group["type"] = "object";
      group["additionalProperties"] = false;
      object = &group["properties"];
      name = name.substr(dot + 1);
    }
    nlohmann::json& words = (*object)[name]["enum"];
    for (const ChoiceWord& word : std::get<ChoiceParameter<SimulatorOptions>>(parameter.kind).words)
      words.push_back(word.name);
    // The accuracy is an option of the drive itself, too.
    if (name == "accuracy") at = checkWords(at, name, words);
    at = checkWords(at, name, words);
  }
  nlohmann::json formats;
  const std::string page = bytesOf(kSource + "/docs/drives.md");
  for (const drive::FormatInfo& format : drive::formats()) {
    formats.push_back(format.name);
    INFO(format.name);
    CHECK(page.find(std::string("`").append(format.name).append("`")) != std::string::npos);
  }
  checkWords(at, "format", formats);
  // The words stand where they count, and nothing else does.
  const auto schema = nlohmann::json::parse(bytesOf(file));
  CHECK(schema["properties"]["simulator"]["properties"] == simulator);
  CHECK(schema["properties"]["accuracy"]["enum"] == simulator["accuracy"]["enum"]);
  CHECK(schema["properties"]["outputs"]["items"]["properties"]["format"]["enum"] == formats);
}

TEST_CASE("the header that lists the formats of clouds lists all of them") {
  CHECK(cloudEndings("or").starts_with(".pcd, .ply, .bin (KITTI), .npy"));
  CHECK(cloudEndings("or", true).starts_with(".pcd, .ply, .npy"));
  const std::string header = bytesOf(kSource + "/include/gnosphere/output.hpp");
  for (const CloudFormat& format : cloudFormats()) {
    INFO(format.ending);
    CHECK(header.find(format.ending) != std::string::npos);
  }
}
