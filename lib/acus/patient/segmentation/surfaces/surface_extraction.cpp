#include "acus/patient/segmentation/surfaces/surface_extraction.h"

#include <algorithm>
#include <cmath>
#include <vtkCellArray.h>
#include <vtkDecimatePro.h>
#include <vtkFloatArray.h>
#include <vtkFlyingEdges3D.h>
#include <vtkIdList.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkWindowedSincPolyDataFilter.h>

#include "acus/base/core/parallel.h"
#include "acus/patient/segmentation/voxels/crop.h"

namespace acus::segmentation {
namespace {

/// Parts of at least min_part_ml, without the cavities inside them.
Mask SolidParts(const Mask& mask, double min_part_ml) {
  const double ml = mask.geometry.voxel_volume_mm3() / 1000.0;
  const Components parts = ConnectedComponents(mask);
  Mask solid = Kept(parts, [&](std::int32_t n) {
    return static_cast<double>(parts.num_voxels[static_cast<std::size_t>(n)]) * ml >= min_part_ml;
  });
  Mask outside(solid.geometry);
  for (std::size_t i = 0; i < solid.voxels.size(); ++i) outside.voxels[i] = solid.voxels[i] ^ 1U;
  const Components holes = ConnectedComponents(outside);
  std::vector<std::uint8_t> is_open(holes.num_voxels.size(), 0);
  const auto& size = mask.geometry.size;
  for (int k = 0; k < size[2]; ++k) {
    for (int j = 0; j < size[1]; ++j) {
      const bool edge_row = k == 0 || j == 0 || k == size[2] - 1 || j == size[1] - 1;
      for (int i = 0; i < size[0]; i += edge_row ? 1 : std::max(1, size[0] - 1)) {
        is_open[static_cast<std::size_t>(holes.number.At(i, j, k))] = 1;
      }
    }
  }
  for (std::size_t i = 0; i < solid.voxels.size(); ++i) {
    const auto n = static_cast<std::size_t>(holes.number.voxels[i]);
    if (n != 0 && is_open[n] == 0) solid.voxels[i] = 1;
  }
  return solid;
}

/// The share of each cell of a coarser grid that is in the mask, with one empty cell all around.
volume::Grid<float> Occupancy(const Mask& mask, double grid_mm, int num_threads) {
  const volume::Geometry& fine = mask.geometry;
  const Eigen::Array3i factor =
      (grid_mm / fine.spacing_mm).round().cast<int>().max(1).min(fine.size);
  volume::Geometry coarse = fine;
  coarse.size = (fine.size + factor - 1) / factor + 2;
  coarse.spacing_mm = fine.spacing_mm * factor.cast<double>();
  const Eigen::Vector3d first =
      ((factor.cast<double>() - 1.0) / 2.0 - factor.cast<double>()).matrix();
  coarse.origin_mm = fine.ct_from_index() * first;
  volume::Grid<float> out(coarse, 0.0F);
  ParallelFor(coarse.size[2] - 2, num_threads, [&](int kk) {
    for (int k = kk * factor[2]; k < std::min((kk + 1) * factor[2], fine.size[2]); ++k) {
      for (int j = 0; j < fine.size[1]; ++j) {
        for (int i = 0; i < fine.size[0]; ++i) {
          if (mask.At(i, j, k) == 0) continue;
          out.At(i / factor[0] + 1, j / factor[1] + 1, kk + 1) += 1.0F;
        }
      }
    }
    // The last cell along an axis may hold fewer voxels than the others.
    const auto inside = [&](int cell, int axis) {
      return std::min(factor[axis], fine.size[axis] - cell * factor[axis]);
    };
    for (int jj = 0; jj + 2 < coarse.size[1]; ++jj) {
      for (int ii = 0; ii + 2 < coarse.size[0]; ++ii) {
        out.At(ii + 1, jj + 1, kk + 1) /=
            static_cast<float>(inside(ii, 0) * inside(jj, 1) * inside(kk, 2));
      }
    }
  });
  return out;
}

/// In the grid's own frame: no rotation, first cell at the origin.
vtkNew<vtkImageData> ToVtk(const volume::Grid<float>& grid) {
  vtkNew<vtkImageData> image;
  const auto& g = grid.geometry;
  image->SetDimensions(g.size[0], g.size[1], g.size[2]);
  image->SetSpacing(g.spacing_mm[0], g.spacing_mm[1], g.spacing_mm[2]);
  vtkNew<vtkFloatArray> values;
  values->SetNumberOfTuples(static_cast<vtkIdType>(grid.voxels.size()));
  std::ranges::copy(grid.voxels, values->GetPointer(0));
  image->GetPointData()->SetScalars(values);
  return image;
}

/// From the frame of ToVtk to LPS, outwards.
mesh::Surface FromVtk(vtkPolyData* poly, const volume::Geometry& g) {
  mesh::Surface surface;
  surface.nodes_mm.resize(3, poly->GetNumberOfPoints());
  for (vtkIdType n = 0; n < poly->GetNumberOfPoints(); ++n) {
    surface.nodes_mm.col(n) =
        g.direction * Eigen::Map<const Eigen::Vector3d>(poly->GetPoint(n)) + g.origin_mm;
  }
  surface.triangles.resize(3, poly->GetNumberOfPolys());
  vtkNew<vtkIdList> corners;
  Eigen::Index count = 0;
  poly->GetPolys()->InitTraversal();
  while (poly->GetPolys()->GetNextCell(corners) != 0) {
    if (corners->GetNumberOfIds() != 3) continue;
    for (int c = 0; c < 3; ++c) surface.triangles(c, count) = static_cast<int>(corners->GetId(c));
    ++count;
  }
  surface.triangles.conservativeResize(3, count);
  if (mesh::SignedVolumeMm3(surface) < 0.0) surface.triangles.row(1).swap(surface.triangles.row(2));
  return surface;
}

}  // namespace

mesh::Surface ExtractSurface(const Mask& mask, const SurfaceOptions& options, int num_threads) {
  const Box box = BoundsOf(mask);
  ACUS_REQUIRE(!box.empty(), "a tissue is empty; there is no surface to extract");
  const Mask solid = SolidParts(Cropped(mask, box), options.min_part_ml);
  ACUS_REQUIRE(Count(solid) > 0, "no part of a tissue is as large as ", options.min_part_ml,
               " ml; there is no surface to extract");
  const volume::Grid<float> share = Occupancy(solid, options.grid_mm, num_threads);
  const vtkNew<vtkImageData> image = ToVtk(share);
  vtkNew<vtkFlyingEdges3D> edges;
  edges->SetInputData(image);
  edges->SetValue(0, 0.5);
  edges->ComputeNormalsOff();
  edges->ComputeGradientsOff();
  edges->ComputeScalarsOff();
  vtkNew<vtkWindowedSincPolyDataFilter> sinc;
  sinc->SetInputConnection(edges->GetOutputPort());
  sinc->SetNumberOfIterations(options.smoothing_iterations);
  sinc->SetPassBand(options.smoothing_pass_band);
  sinc->NormalizeCoordinatesOn();
  sinc->BoundarySmoothingOff();
  sinc->FeatureEdgeSmoothingOff();
  sinc->NonManifoldSmoothingOff();
  sinc->Update();
  const vtkIdType triangles = sinc->GetOutput()->GetNumberOfPolys();
  vtkNew<vtkDecimatePro> decimate;
  decimate->SetInputConnection(sinc->GetOutputPort());
  decimate->PreserveTopologyOn();
  decimate->SplittingOff();
  decimate->BoundaryVertexDeletionOff();
  decimate->SetTargetReduction(std::clamp(
      1.0 - options.target_triangles / static_cast<double>(std::max<vtkIdType>(triangles, 1)), 0.0,
      0.99));
  decimate->Update();
  return mesh::WithoutUnusedNodes(FromVtk(decimate->GetOutput(), share.geometry));
}

}  // namespace acus::segmentation
