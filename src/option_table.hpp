// SPDX-License-Identifier: Apache-2.0
// The tables of options: those of a simulator, and those of a sensor's request.
#pragma once

#include <string>
#include <vector>

#include "effects/parameter.hpp"
#include "gnosphere/options.hpp"

namespace gnosphere {

/// Subject that another value of an option changes.
enum class Changes { cloud, time, machine };
inline constexpr const char* kChanges[] = {"the cloud", "time and memory", "how the device is used"};

template <class Owner>
struct Option {
  Parameter<Owner> parameter;
  Changes changes;
};

/// Every option of SimulatorOptions that a text can set. Devices, material tables and functions are not among them.
const std::vector<Option<SimulatorOptions>>& simulatorOptionTable();
const std::vector<Option<SensorRequest>>& requestOptionTable();

/// Returns the option of that name. Throws Error(invalidArgument) with the nearest names.
const Option<SimulatorOptions>& simulatorOption(const std::string& name);
const Option<SensorRequest>& requestOption(const std::string& name);

/// Returns the options that change clouds or times and do not have their defaults, as an object of JSON.
std::string changedOptions(const SimulatorOptions& options);

/// Returns the words of a choice, such as those of "accuracy".
const std::vector<ChoiceWord>& wordsOf(const std::string& simulatorOption);

}  // namespace gnosphere
