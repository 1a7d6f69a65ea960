// One setting of a tissue model, run: the building block of the sweep over tissue.
#pragma once

#include <optional>
#include <vector>

#include "acus/base/core/run_context.h"
#include "acus/physics/mechanics/condensation/compliance.h"
#include "acus/physics/mechanics/condensation/reachable.h"
#include "acus/physics/mechanics/elements/stiffness.h"
#include "acus/physics/tissue/plane_model_2010.h"
#include "acus/physics/tissue/spring_model.h"
#include "acus/physics/tissue/strain_contact.h"
#include "benchmarks/insertion.h"
#include "benchmarks/tissue_block.h"

namespace acus::benchmarks {

/// 3D finite elements. Defaults: those of acus-mesh (corridor and condensation) and of a scenario's
/// effects/tissue/fe_3d.
struct FemSetting {
  double element_mm = 4.0;
  mechanics::ElementKind element = mechanics::ElementKind::kAveragedDilatation;
  double corridor_radius_mm = 6.0;
  double tip_reach_mm = 12.0;
  mechanics::Storage storage = mechanics::Storage::kDouble;
  double contact_spacing_mm = 2.0;
  std::optional<tissue::StrainSettings> strain{};  ///< None: the linear law.
};

struct MeasuredRun {
  InsertionRun run;
  double preparation_s = 0.0;  ///< CPU time: mesh, condensation, model.
  double memory_mb = 0.0;      ///< Of the compliance, or of what the model has instead.
  int num_nodes = 0;           ///< Of the mesh; 0: none.
};

/// From 3 mm above the skin to beyond the deepest tip: the needle's way.
mechanics::Capsule WayOf(const std::vector<tissue::ToolSample>& samples, double radius_mm);

/// The models that the runs below insert the needle into.
tissue::PlaneModel2010 PlaneOf(double spacing_mm, double width_mm, double depth_mm,
                               const TissueBlockTables& tables,
                               const std::vector<tissue::ToolSample>& samples);
tissue::SpringModel SpringsOf(double node_spacing_mm, const TissueBlockTables& tables);

/// Meshes the block, condenses it, inserts the needle.
MeasuredRun RunFem(const FemSetting& setting, const TissueBlockTables& tables,
                   const std::vector<tissue::ToolSample>& samples, const RunContext& context);

/// The plane of 2010 with nodes so far apart; the paper's 361 nodes: 19 x 19.
MeasuredRun RunPlane(double spacing_mm, double width_mm, double depth_mm,
                     const TissueBlockTables& tables,
                     const std::vector<tissue::ToolSample>& samples);

/// Springs along the path of the needle.
MeasuredRun RunSprings(double node_spacing_mm, const TissueBlockTables& tables,
                       const std::vector<tissue::ToolSample>& samples);

/// No elastic tissue: the laws of force along the path alone.
MeasuredRun RunRigid(const TissueBlockTables& tables,
                     const std::vector<tissue::ToolSample>& samples);

/// The same mesh, all of muscle, pressed on 24 x 24 mm of its skin: relative error, percent, of the
/// dimple's depth (displacement of the middle less that of the first node beyond 30 mm from it)
/// against the half space of Love.
double DimpleErrorPercent(double element_mm, mechanics::ElementKind element,
                          const TissueBlockTables& tables, const RunContext& context);

}  // namespace acus::benchmarks
