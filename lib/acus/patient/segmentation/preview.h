// Images by which a person judges a segmentation.
#pragma once

#include <Eigen/Core>
#include <filesystem>

#include "acus/data/volume/volume.h"

namespace acus::segmentation {

enum class Plane { kAxial, kCoronal, kSagittal };

/// The middle of the body: of the box around all labels but "outside", as voxel numbers.
Eigen::Array3i BodyCentre(const volume::LabelMap& labels);

/// Writes a PNG of the CT slice through `voxel` that is most nearly in `plane`, atomically: soft
/// tissue window (-160 to 240 HU), outlines of the labels in their colours, true aspect ratio,
/// a scale bar in mm, letters for the patient's sides, a legend of tissues. Axial slices are seen
/// from the feet, as radiologists do: the patient's right is on the left.
/// @throws InputError if CT and labels are on different grids or the file cannot be written.
void WritePreview(const std::filesystem::path& path, const volume::CtVolume& ct,
                  const volume::LabelMap& labels, Plane plane, const Eigen::Array3i& voxel);

/// preview_axial.png, preview_coronal.png and preview_sagittal.png through the middle of the body.
void WritePreviews(const std::filesystem::path& folder, const volume::CtVolume& ct,
                   const volume::LabelMap& labels);

}  // namespace acus::segmentation
