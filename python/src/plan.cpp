// SPDX-License-Identifier: Apache-2.0
// Binds the declarations of gnosphere/plan.hpp.
#include "bind.hpp"

namespace gnosphere::python {

void bindPlan(nb::module_& m) {
  auto plan = nb::class_<Plan>(m, "Plan",
                               "Describes what a scan of one sensor computes, or several scans together, and why. An "
                               "effect, field or buffer that is not listed costs nothing.");
  nb::class_<Plan::Decision>(plan, "Decision", "Whether an effect is in, and why.")
      .def_ro("effect", &Plan::Decision::effect, "One of effect_names().")
      .def_ro("request", &Plan::Decision::request, "What the sensor asked for: off, on or automatic.")
      .def_ro("in_", &Plan::Decision::in,
              "True if scans simulate the effect; `in` in C++, which is a word of Python's.")
      .def_ro(
          "left_out", &Plan::Decision::leftOut,
          "True if the effect is called for, but the accuracy or the device cannot simulate it, or the intensity that "
          "it needs is off.")
      .def_ro("reason", &Plan::Decision::reason, "For example 'the sensor states 3.0 x 1.5 mrad'.");
  nb::class_<Plan::Statistic>(plan, "Statistic",
                              "A number that the driver's compiler reports of a pipeline, with the driver's name.")
      .def_ro("name", &Plan::Statistic::name, "What the driver calls it.")
      .def_ro("value", &Plan::Statistic::value, "As the driver writes it.");
  nb::class_<Plan::Commands>(plan, "Commands",
                             "Commands that the device executes for one submission: the largest number of each.")
      .def_ro("dispatches", &Plan::Commands::dispatches, "Runs of a kernel.")
      .def_ro("fills", &Plan::Commands::fills, "Arrays set to a value.")
      .def_ro("copies", &Plan::Commands::copies, "Copies between arrays.")
      .def_ro("barriers", &Plan::Commands::barriers, "Waits for what came before.")
      .def("all", &Plan::Commands::all, "The sum of all four.");
  auto pipeline = nb::class_<Plan::Pipeline>(plan, "Pipeline", "A kernel as it is compiled for this plan.");
  pipeline.def_ro("name", &Plan::Pipeline::name, "Name of the shader.");
  readTuple(pipeline, "constants", &Plan::Pipeline::constants,
            "Specialisation constants in the order of shaders/options.glsl.");
  pipeline.def_ro("subgroup_size", &Plan::Pipeline::subgroupSize, "Lanes; 0 if it is not known.")
      .def_ro("compile_ms", &Plan::Pipeline::compileMs, "How long the driver took; with compile_only.");
  readTuple(pipeline, "statistics", &Plan::Pipeline::statistics,
            "What the driver's compiler says; with compile_only, and if it reports anything.");
  auto stage = nb::class_<Plan::Stage>(plan, "Stage", "What a stage of the scan runs.");
  stage.def_ro("name", &Plan::Stage::name, "project, bin, resolve, effects, records")
      .def_ro("dispatches", &Plan::Stage::dispatches, "Largest number of dispatches in one submission.");
  readTuple(stage, "pipelines", &Plan::Stage::pipelines, "Empty if the host computes the stage.");
  nb::class_<Plan::Buffer>(plan, "Buffer", "An array on the device.")
      .def_ro("name", &Plan::Buffer::name, "What it holds.")
      .def_ro("bytes", &Plan::Buffer::bytes, "Its size.");

  readTuple(plan, "effects", &Plan::effects, "One per effect, in the order of effect_names().");
  readTuple(plan, "fields", &Plan::fields, "Fields beyond point, range and owner (triangle and instance).");
  readTuple(plan, "stages", &Plan::stages, "The stages in their order.");
  readTuple(plan, "buffers", &Plan::buffers, "Buffers of this sensor on the device.");
  plan.def_ro("binning", &Plan::binning, "nearest, lists or slabs")
      .def_ro("returns", &Plan::returns, "Returns per beam.")
      .def_ro(
          "views", &Plan::views,
          "Scans that one submission makes together: as many as were asked for, or fewer if not so many fit, or 1 if "
          "scans of the sensor are made one by one.")
      .def_ro("commands", &Plan::commands, "All 0 if the host makes the scans.")
      .def("bytes", &Plan::bytes, "Sum over `buffers`.")
      .def("dispatches", &Plan::dispatches, "Sum over `stages`.")
      .def("has", &Plan::has, "effect"_a, "Whether scans simulate the effect.");
  m.def(
      "to_json", [](const Plan& of) { return toJson(of); }, "plan"_a,
      "Writes a plan as JSON: its members, and the sums bytes() and dispatches().");
}

}  // namespace gnosphere::python
