// Channel data as MATLAB files (version 5, or 7.3, which is HDF5).
#pragma once

#include <filesystem>
#include <string>

#include "acus/imaging/rf/channel_data.h"

namespace acus::rf {

/// Reads a variable of samples x elements, or samples x elements x transmits, of any real number
/// class. The sampling rate is not part of it and stays 0.
/// @param variable  Its name; empty: the only numeric variable of more than one number.
/// @throws InputError if the file is no MATLAB file or damaged, there is no such variable, or its
///     shape or class is another one.
ChannelData ReadMatlab(const std::filesystem::path& path, const std::string& variable);

/// Reads one number, "fs" or, of a structure, "param.fs".
/// @throws InputError if the file has no such number.
double ReadMatlabNumber(const std::filesystem::path& path, const std::string& name);

/// Writes the variables rf (single, samples x elements x transmits), fs_hz and t0_s, as version 5.
/// Whole or not at all. @throws InputError if it cannot be written.
void WriteMatlab(const std::filesystem::path& path, const ChannelData& data);

}  // namespace acus::rf
