// Which rows the stages of the aperture model work on.
#pragma once

#include "acus/data/volume/volume.h"
#include "acus/imaging/acoustics/probe.h"

namespace acus::ultrasound {

/// Every `samples`-th sample of a grid, and one more row at its end.
acoustics::ScanGrid Coarser(const acoustics::ScanGrid& grid, int samples);

/// Samples from one row of tissue to the next. The volume is smooth over a voxel: rows one voxel
/// apart lose nothing of it.
int SamplesPerRow(const acoustics::ScanGrid& grid, const volume::Geometry& geometry);

/// Samples, an odd number, whose intensities make one row of the shown image: as many as a pixel is
/// long. What is between pixels is averaged, not skipped.
int SamplesPerShownRow(const acoustics::Probe& probe, const acoustics::ScanGrid& grid);

/// Every `samples`-th sample of a grid.
acoustics::ScanGrid ShownRows(const acoustics::ScanGrid& grid, int samples);

}  // namespace acus::ultrasound
