// Arrays as NumPy files (.npy, version 1.0), little endian, in C order.
#pragma once

#include <filesystem>

#include "acus/imaging/rf/beamform.h"
#include "acus/imaging/rf/channel_data.h"

namespace acus::rf {

/// float32, shape (transmits, elements, samples). Whole or not at all.
void WriteNumpy(const std::filesystem::path& path, const ChannelData& data);

/// complex64, shape (rows, columns): the analytic signal.
void WriteNumpy(const std::filesystem::path& path, const IqImage& image);

}  // namespace acus::rf
