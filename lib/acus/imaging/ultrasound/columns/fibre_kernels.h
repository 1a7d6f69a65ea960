// Sheets of connective tissue in rows of scatterers, in vector instructions chosen at run time
// (Highway). The same bits on all instruction sets: see aperture_kernels.h.
#pragma once

#include <cstdint>

#include "acus/imaging/slicing/kernels.h"

namespace acus::ultrasound::kernels {

/// A byte per voxel, four in a word, the first in its lowest bits. At most 2^31 voxels.
struct CodedVoxels {
  const std::uint32_t* words;
  float size[3];              ///< Voxels along i, j, k.
  std::int32_t row_voxels;    ///< From j to j + 1.
  std::int32_t slice_voxels;  ///< From k to k + 1.
};

/// which[l] = code of the voxel nearest to sample `s` of each lane, 0 outside. Returns false if all
/// are 0.
bool CodeRow(const CodedVoxels& voxels, const slicing::kernels::Lines& lines, float s, int lanes,
             float* which);

/// One row of samples, one tissue. Sheets lie where a smooth noise passes its middle; `cells` takes
/// voxel indices to the cells of the noise, `normals` slopes per cell to slopes per mm.
struct SheetRow {
  slicing::kernels::Lines lines;
  float s;             ///< Sample.
  const float* which;  ///< By lane: lanes of `code` are changed, others are left as they are.
  float code;
  float cells[9];    ///< Rows first.
  float normals[9];  ///< Rows first.
  float spacing_mm[3];
  float along[3];  ///< Unit vector of the fibres, mm along the voxel axes.
  std::uint32_t seed;
  float fibre_nepers;   ///< Intensity along the fibres is exp(-this) of that across.
  float per_thickness;  ///< 1 / half thickness of a sheet, in units of the noise.
  float between;        ///< Intensity between sheets.
  float sheet;          ///< Intensity that a sheet adds which faces the beam.
  float per_lobe;       ///< 1 / (2 tan(width)^2) of the lobe of a sheet.
  float diffuse_share;
};

/// intensity[l] *= f (between + f sheet lobe / (1 + q^2)): see FibreStreaks. Rows are written up to
/// the next multiple of kBlock lanes.
void SheetIntensityRow(const SheetRow& row, int lanes, float* intensity);

}  // namespace acus::ultrasound::kernels
