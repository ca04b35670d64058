// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <vector>

#include "gnosphere/effects.hpp"

namespace gnosphere {

/// A JSON file of materials. Throws Error(file) or Error(format).
nlohmann::json readMaterialJson(const std::filesystem::path& file);

/// Whether the root of a JSON file is one of ASAM OpenMATERIAL 3D: an asset (.xoma), a mapping (.xomm) or a material
/// (.xomp).
bool isOpenMaterial(const nlohmann::json& root);

/// One row per material of it, whose properties are in files beside `file`. Throws Error(file) or Error(format), also
/// where no material states anything that a laser's reflectance could be told from; some of a mapping may not.
std::vector<MaterialTable::Row> readOpenMaterial(const nlohmann::json& root, const std::filesystem::path& file);

}  // namespace gnosphere
