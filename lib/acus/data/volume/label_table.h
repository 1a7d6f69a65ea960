// Tables in text files that name the values of label maps, and have colours for them.
#pragma once

#include <filesystem>
#include <string>

#include "acus/data/volume/value_names.h"

namespace acus::volume {

/// Reads a label description of ITK-SNAP (`1 255 0 0 1 1 1 "liver"`), a colour table of 3D Slicer
/// or a lookup table of FreeSurfer (`1 liver 255 0 0 255`), a list (`1 liver`), or a table with a
/// header (.csv, .tsv): columns index and name of BIDS, LabelValue and Name with the codes of
/// 3D Slicer. The background (0) is omitted.
/// @returns Nothing if the file is something else.
/// @throws InputError with the line if the file says that it is such a table and a row is none, if
///     an index is no whole number, or a value has two names.
ValueNames NamesInTable(const std::filesystem::path& file);

/// Adds a name. @throws InputError naming `file` if the value has one.
void AddValueName(std::int32_t value, ValueName name, const std::string& file, ValueNames& names);

}  // namespace acus::volume
