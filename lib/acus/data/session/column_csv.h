// CSV files of trackers whose columns a mapping names (acus-columns/1).
#pragma once

#include <filesystem>

#include "acus/data/session/session.h"

namespace acus::session {

/// Reads needle and probe from a CSV. Rows whose cells are empty, not numbers, beyond a kilometre,
/// or whose status is none of the valid ones are samples that were not seen.
/// @param columns  File of format acus-columns/1: rows that make up the names of the columns, the
///     first row of data, the columns of time, position and rotation, and their units.
/// @throws InputError naming file, row and column; for a column that is not there, those that are.
Session ReadColumnCsv(const std::filesystem::path& path, const std::filesystem::path& columns);

}  // namespace acus::session
