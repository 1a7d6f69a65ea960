// Labels along lines through closed surfaces, from their triangles themselves.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "acus/data/mesh/closed_surface.h"
#include "acus/data/mesh/surface.h"
#include "acus/data/volume/volume.h"
#include "acus/imaging/slicing/tracing/triangle_tree.h"

namespace acus::tracing {

/// A closed surface and the tissue inside it. LPS, mm.
struct LabelledSurface {
  mesh::Surface surface;
  mesh::Winding winding = mesh::Winding::kOriented;  ///< As mesh::CheckClosed says.
  volume::Label label = 0;
};

/// A place of a path that is straight between them; `at` numbers the places along it, rising.
struct PathPlace {
  Eigen::Vector3d place_mm;  ///< LPS.
  double at = 0.0;
};

/// From `at` on, up to the next change, the path is in tissue `label`; 0: in none.
struct LabelChange {
  double at;
  volume::Label label;
};

/// Follows paths through all surfaces. Inside and outside, and what counts where surfaces overlap,
/// are as in segmentation::LabelsOfSurfaces; equations and errors: docs/models/surfaces.md.
/// Immutable: any number of threads may trace at a time, each with its own Buffers.
class SurfaceTracer {
 public:
  /// Crossings of one path that Buffers hold before they grow.
  static constexpr std::size_t kUsualCrossings = 4096;

  struct Crossing {
    double at;
    std::uint32_t surface;
    int turn;
  };
  class Buffers {
   public:
    explicit Buffers(const SurfaceTracer& tracer);

   private:
    friend class SurfaceTracer;
    std::vector<Crossing> crossings_;
    std::vector<int> winding_;           ///< By surface.
    std::vector<std::uint64_t> inside_;  ///< One bit for each surface.
  };

  /// @param surfaces  Where they overlap the last one counts.
  /// @param num_threads  That build the hierarchy.
  /// @throws InputError if there is no triangle, a coordinate is not finite, or a triangle names
  ///     no node.
  /// @pre the surfaces are closed.
  SurfaceTracer(std::vector<LabelledSurface> surfaces, int num_threads);

  /// What lies along the path, in order; the first change is at the path's start. A place on a
  /// surface belongs to what begins there. Allocates nothing while `buffers` and `out` are large
  /// enough. Places are rounded to unit_mm(); those farther than 32 times the size of the scene are
  /// moved nearer.
  /// @pre at least one place; all are finite.
  void Trace(std::span<const PathPlace> path, Buffers& buffers,
             std::vector<LabelChange>& out) const;

  /// Places and nodes are multiples of it; it is at most 2.4e-7 times the size of the scene, mm.
  double unit_mm() const { return unit_mm_; }
  std::size_t num_triangles() const { return tree_->num_triangles(); }
  std::size_t num_surfaces() const { return label_.size(); }
  volume::Label label(std::size_t surface) const { return label_[surface]; }
  std::size_t memory_bytes() const { return tree_->memory_bytes(); }

 private:
  Place PlaceOf(const Eigen::Vector3d& place_mm) const noexcept;
  Place FarBehind(const PathPlace* path, std::size_t count) const noexcept;
  void Turn(const Crossing& crossing, Buffers& buffers) const noexcept;
  volume::Label LabelInside(const Buffers& buffers) const noexcept;

  Eigen::Vector3d middle_mm_ = Eigen::Vector3d::Zero();
  double unit_mm_ = 1.0;
  std::vector<volume::Label> label_;
  std::vector<bool> oriented_;
  std::unique_ptr<TriangleTree> tree_;
};

}  // namespace acus::tracing
