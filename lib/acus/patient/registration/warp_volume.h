// A CT and its labels in the shape that a displacement field gives them.
#pragma once

#include "acus/base/core/run_context.h"
#include "acus/data/volume/displacement_file.h"
#include "acus/data/volume/volume.h"
#include "acus/patient/registration/elastic_lattice.h"

namespace acus::registration {

/// The grid of the CT, grown on every side by the largest displacement along that axis.
volume::Geometry GrownGeometry(const volume::Geometry& ct, const LatticeField& field);

/// Each voxel shows the tissue that has moved there: value at X with X + u(X) = x, to 0.01 mm;
/// trilinear for CT, nearest for labels. Outside the CT -1024 HU and label 0.
volume::CtVolume WarpCt(const volume::CtVolume& ct, const LatticeField& field,
                        const RunContext& context);
volume::LabelMap WarpLabels(const volume::LabelMap& labels, const LatticeField& field,
                            const RunContext& context);

/// The field for a file: displacements of CT places, at the nodes.
volume::DisplacementField ToDisplacementField(const LatticeField& field);

}  // namespace acus::registration
