// The front gate of input files: what every reader asks before it opens a file, takes memory for
// what a header declares, or descends into a nested text.
#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <string_view>

namespace acus {

/// The deepest nesting of objects and arrays in a JSON text. Files of the programs have less
/// than 20.
inline constexpr int kMaxJsonDepth = 100;

/// A regular file, or a link to one, that can be opened: no folder, pipe, socket or device, from
/// which a reader would wait or read for ever.
/// @returns its size in bytes.
/// @throws InputError if it is something else, missing, a loop of links, not readable, or larger
///     than `max_bytes`.
std::uintmax_t RequireInputFile(
    const std::filesystem::path& path,
    std::uintmax_t max_bytes = std::numeric_limits<std::uintmax_t>::max());

/// The memory in bytes that an input file may declare: what SetInputMemory says, or half of the
/// memory that is available, by the system, the control group and the limit of the process.
double InputMemoryBytes();

/// What --memory-gb says: GB (10^9 bytes) for one input file; nothing: the default.
void SetInputMemory(std::optional<double> gb);

/// Holds what a header declares against memory before it is taken. By default a file may also not
/// declare more than 2 GB and 100 times its size on the disk: no image compresses so well.
/// @param file_bytes  Size on the disk of header and data.
/// @throws InputError that names `label`, both sizes and --memory-gb.
void RequireMemory(double declared_bytes, double file_bytes, const std::string& label);

/// The data file that a header names: it must lie in the header's folder or below, because data of
/// another folder must not be read without the user's knowledge.
/// @returns its path. @throws InputError that names header and data file.
std::filesystem::path RequireDataBeside(const std::filesystem::path& header,
                                        const std::filesystem::path& data);

/// @throws InputError if objects and arrays of a JSON text are nested deeper than kMaxJsonDepth.
///     Recursive code would exhaust the stack. Comments (// and /* */) and strings do not count.
void RequireJsonDepth(std::string_view text, const std::string& label);

}  // namespace acus
