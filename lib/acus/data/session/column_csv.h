// CSV files of trackers whose columns a mapping names (acus-columns/1).
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>

#include "acus/base/core/run_context.h"
#include "acus/data/session/session.h"

namespace acus::session {

/// Reads needle and probe from a CSV; encodings, separators and decimal commas as in
/// delimited_text.h. A unit of length that the file itself declares ("Length Units" of Motive) is
/// used, with a warning where the mapping has another. Rows of equal time are one. Rows whose cells
/// are empty, not numbers, beyond a kilometre, or whose status is none of the valid ones are
/// samples that were not seen.
/// @param columns  File of format acus-columns/1: rows that make up the names of the columns, the
///     first row of data, the columns of time, position and rotation, and their units.
/// @throws InputError naming file, row and column; for a column that is not there, those that are.
///     Unless `as_it_is` also if a tool is metres away or moves within a millimetre, which is a
///     mistake of unit.
Session ReadColumnCsv(const std::filesystem::path& path, const std::filesystem::path& columns,
                      bool as_it_is, const RunContext& context);

/// The same with a mapping that has been read. @pre It fits the schema acus-columns.
Session ReadMappedCsv(const std::filesystem::path& path, const nlohmann::json& mapping,
                      bool as_it_is, const RunContext& context);

}  // namespace acus::session
