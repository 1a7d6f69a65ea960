#include "acus/data/volume/displacement_file.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "acus/base/core/error.h"
#include "acus/data/volume/scalar_file.h"

namespace acus::volume {

DisplacementField ReadDisplacementField(const std::filesystem::path& path) {
  const ScalarFile file = ReadVectorFile(path);
  ACUS_REQUIRE(file.type == ScalarType::kFloat32 || file.type == ScalarType::kFloat64,
               path.string(), ": displacements must be floating-point numbers, in mm");
  DisplacementField field{
      .geometry = file.geometry, .displacement_in_ct_mm = {}, .notes = file.notes};
  field.displacement_in_ct_mm.resize(3 * file.geometry.num_voxels());
  if (file.type == ScalarType::kFloat32) {
    std::memcpy(field.displacement_in_ct_mm.data(), file.bytes.data(), file.bytes.size());
  } else {
    for (std::size_t n = 0; n < field.displacement_in_ct_mm.size(); ++n) {
      double value = 0.0;
      std::memcpy(&value, &file.bytes[n * sizeof value], sizeof value);
      field.displacement_in_ct_mm[n] = static_cast<float>(value);
    }
  }
  ACUS_REQUIRE(
      std::ranges::all_of(field.displacement_in_ct_mm, [](float v) { return std::isfinite(v); }),
      path.string(), ": holds a displacement that is not finite");
  return field;
}

void WriteDisplacementField(const std::filesystem::path& path, const DisplacementField& field) {
  ScalarFile file{.geometry = field.geometry,
                  .type = ScalarType::kFloat32,
                  .num_components = 3,
                  .bytes = {},
                  .keys = {}};
  ACUS_REQUIRE(field.displacement_in_ct_mm.size() == 3 * field.geometry.num_voxels(), path.string(),
               ": ", field.displacement_in_ct_mm.size(), " numbers for ",
               field.geometry.num_voxels(), " displacements");
  file.bytes.resize(sizeof(float) * field.displacement_in_ct_mm.size());
  std::memcpy(file.bytes.data(), field.displacement_in_ct_mm.data(), file.bytes.size());
  WriteScalarFile(path, file);
}

}  // namespace acus::volume
