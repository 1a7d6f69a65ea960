#include "acus/data/volume/named_values.h"

#include "acus/base/core/error.h"
#include "acus/data/volume/dicom_segmentation.h"
#include "acus/data/volume/nifti_label_table.h"
#include "acus/data/volume/scalar_file.h"
#include "acus/data/volume/segment_keys.h"
#include "acus/data/volume/volume_io.h"

namespace acus::volume {

NamedValues ReadNamedValues(const std::filesystem::path& path) {
  const std::string name = path.filename().string();
  if (!IsScalarFileName(path) && path.extension() != ".vti" && IsDicomSegmentation(path)) {
    return ReadDicomSegmentation(path);
  }
  NamedValues map;
  std::map<std::string, std::string> keys;
  map.values = ReadIntegerVolume(path, &keys);
  if (name.ends_with(".nii") || name.ends_with(".nii.gz")) {
    map.names = NiftiLabelTable(path);
    if (!map.names.empty()) map.named_by = "by the label table in its header";
  } else {
    map.names = SegmentsFromKeys(keys);
    if (!map.names.empty()) map.named_by = "by the names of its segments";
  }
  return map;
}

}  // namespace acus::volume
