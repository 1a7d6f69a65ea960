// How tissue that the needle has moved looks in an image, by every model of tissue.
#pragma once

#include <Eigen/Dense>
#include <vector>

#include "acus/base/core/run_context.h"
#include "acus/physics/tissue/tool_sample.h"
#include "benchmarks/sweep.h"
#include "benchmarks/tissue_block.h"

namespace acus::benchmarks {

/// Displacements in the plane of the needle, 60 x 60 mm around it, when the tip of an insertion is
/// 30 mm deep and moves in: in a tissue's middle, where models agree on what has given way.
struct TissueImage {
  static constexpr int kPixels = 256;     ///< Each way.
  std::vector<Eigen::Vector3d> moved_mm;  ///< Row by row; zero above the skin.
  std::vector<double> image_us;           ///< CPU time of each of a few images.
  double preparation_s = kNotMeasured;    ///< CPU time of what only the image needs, s.
  double memory_mb = kNotMeasured;        ///< Of what only the image needs.
};

/// Finite elements of this size; their forces as RunFem makes them.
TissueImage ImageOfFem(double element_mm, const TissueBlockTables& tables,
                       const std::vector<tissue::ToolSample>& samples, const RunContext& context);
/// The plane of 2010, with 361 nodes.
TissueImage ImageOfPlane(const TissueBlockTables& tables,
                         const std::vector<tissue::ToolSample>& samples);
TissueImage ImageOfSprings(const TissueBlockTables& tables,
                           const std::vector<tissue::ToolSample>& samples);
/// Displacement functions; the forces are those of the springs.
TissueImage ImageOfFunctions(const TissueBlockTables& tables,
                             const std::vector<tissue::ToolSample>& samples);

/// Root mean square of the distance of two images' tissue, mm, where `reference` moves by more
/// than a hundredth of its largest displacement. @pre both of the same insertion.
double RmsDifferenceMm(const TissueImage& image, const TissueImage& reference);

}  // namespace acus::benchmarks
