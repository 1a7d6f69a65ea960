// Writes the smallest NIfTI-1 label map, with or without header extensions.
#pragma once

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

namespace acus::testing_support {

/// 8-bit labels on a grid of 1 mm, axes RAS, first voxel at the origin. Each extension is a text
/// with code 0.
inline void WriteNiftiLabels(const std::filesystem::path& path, int columns, int rows, int slices,
                             const std::vector<std::uint8_t>& labels,
                             const std::vector<std::string>& extensions) {
  std::string bytes(352, '\0');
  const auto put = [&](std::size_t at, auto value) {
    std::memcpy(&bytes[at], &value, sizeof(value));
  };
  put(0, std::int32_t{348});
  for (const auto& [at, size] : {std::pair{42, columns}, {44, rows}, {46, slices}}) {
    put(static_cast<std::size_t>(at), static_cast<std::int16_t>(size));
  }
  put(40, std::int16_t{3});
  put(70, std::int16_t{2});  // Unsigned bytes.
  put(72, std::int16_t{8});
  for (const std::size_t at : {80U, 84U, 88U}) put(at, 1.0F);
  put(112, 1.0F);
  put(254, std::int16_t{1});  // The sform is used.
  put(280, 1.0F);
  put(300, 1.0F);
  put(320, 1.0F);
  std::memcpy(&bytes[344], "n+1", 4);
  if (!extensions.empty()) bytes[348] = 1;
  for (std::string text : extensions) {
    text.resize((text.size() + 8 + 15) / 16 * 16 - 8, '\0');
    const auto size = static_cast<std::int32_t>(text.size() + 8);
    std::string head(8, '\0');
    std::memcpy(head.data(), &size, 4);
    bytes += head + text;
  }
  put(108, static_cast<float>(bytes.size()));
  bytes.append(labels.begin(), labels.end());
  std::ofstream(path, std::ios::binary) << bytes;
}

/// The label table as Connectome Workbench and TotalSegmentator write it.
inline std::string NiftiLabelXml(const std::vector<std::pair<int, std::string>>& labels) {
  std::string xml =
      R"(<?xml version="1.0" encoding="UTF-8"?> <CaretExtension><VolumeInformation Index="0"><LabelTable>)";
  for (const auto& [key, name] : labels) {
    xml += "<Label Key=\"" + std::to_string(key) +
           "\" Red=\"1\" Green=\"0\" Blue=\"0\" Alpha=\"1\"><![CDATA[" + name + "]]></Label>\n";
  }
  return xml + "</LabelTable></VolumeInformation></CaretExtension>";
}

}  // namespace acus::testing_support
