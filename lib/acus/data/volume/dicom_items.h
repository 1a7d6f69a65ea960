// The elements of a DICOM file with the items of its sequences.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <vector>

#include "acus/data/volume/dicom_elements.h"

namespace acus::volume {

/// One data set, or one item of a sequence. Tags are group * 65536 + element.
struct DicomItem : DicomValues {
  std::map<std::uint32_t, std::vector<DicomItem>> sequences;

  /// The first item of a sequence, or null.
  const DicomItem* First(std::uint32_t sequence) const;
};

/// A file in memory; the item points into its bytes.
struct DicomDataSet {
  std::vector<std::uint8_t> bytes;
  DicomItem root;
  bool is_encapsulated = false;  ///< Its pixels are compressed.
};

/// Reads a file that ReadDicomHeader has accepted. The value of compressed pixels is the sequence
/// of their fragments.
/// @throws InputError if an item is cut off, broken or nested too deeply.
DicomDataSet ReadDicomDataSet(const std::filesystem::path& path);

}  // namespace acus::volume
