// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <vector>

#include "gnosphere/effects.hpp"

namespace gnosphere {

/// Reads a JSON file of materials. Throws Error(file) or Error(format) if the file cannot be read or is invalid.
nlohmann::json readMaterialJson(const std::filesystem::path& file);

/// Returns whether the root of a JSON file is one of ASAM OpenMATERIAL 3D: an asset (.xoma), a mapping (.xomm) or a
/// material (.xomp).
bool isOpenMaterial(const nlohmann::json& root);

/// Returns one row per material; property files are looked for relative to `file`. Throws Error(file), or
/// Error(format), also if no material has properties from which a reflectance follows. In a mapping, single materials
/// may lack them.
std::vector<MaterialTable::Row> readOpenMaterial(const nlohmann::json& root, const std::filesystem::path& file);

}  // namespace gnosphere
