// SPDX-License-Identifier: Apache-2.0
// The functions of gno_effects, which are requests for effects.
#include "c/handles.hpp"

using namespace gnosphere;
using namespace gnosphere::c;

namespace {

std::vector<const char*> pointers(const std::vector<std::string>& texts) {
  std::vector<const char*> result;
  for (const std::string& text : texts) result.push_back(text.c_str());
  return result;
}

}  // namespace

extern "C" {

gno_status gno_effects_create(gno_effects* effects) {
  return giveHandle(effects, "effects", [&] { return make<gno_effects>({}); });
}

gno_status gno_effects_preset(const char* name, gno_effects* effects) {
  return giveHandle(effects, "effects", [&] { return make<gno_effects>(effectPreset(&the(name, "name"))); });
}

gno_status gno_effects_load(const char* file, gno_effects* effects) {
  return giveHandle(effects, "effects", [&] { return make<gno_effects>(loadEffects(fileOf(file))); });
}

gno_status gno_effects_load_mode(const char* file, const char* mode, gno_effects* effects) {
  return giveHandle(effects, "effects", [&] { return make<gno_effects>(loadEffects(fileOf(file), orEmpty(mode))); });
}

gno_status gno_effects_from_json(const char* json, gno_effects* effects) {
  return giveHandle(effects, "effects",
                    [&] { return make<gno_effects>(effectsFromJson(&the(json, "json"), "the text")); });
}

gno_status gno_effects_destroy(gno_effects effects) {
  return guard([&] { destroy(effects); });
}

gno_status gno_effects_assign(gno_effects effects, const char* assignment) {
  return guard([&] { assign(*Locked(effects), &the(assignment, "assignment")); });
}

gno_status gno_effects_set_seed(gno_effects effects, uint64_t seed) {
  return guard([&] { Locked(effects)->seed = seed; });
}

gno_status gno_effects_to_json(gno_effects effects, const char** json) {
  return guard([&] {
    thread_local std::string text;
    text = toJson(*Locked(effects));
    the(json, "json") = text.c_str();
  });
}

gno_status gno_effect_names(const char* const** names, size_t* count) {
  return guard([&] {
    static const auto& all = *new auto(pointers(effectNames()));  // also for threads that outlive static objects
    the(names, "names") = all.data();
    the(count, "count") = all.size();
  });
}

gno_status gno_effect_presets(const char* const** names, size_t* count) {
  return guard([&] {
    static const auto& all = *new auto(pointers(effectPresets()));
    the(names, "names") = all.data();
    the(count, "count") = all.size();
  });
}

}  // extern "C"
