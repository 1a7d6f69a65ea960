// Labels of all samples of an image's lines, from the triangles of surfaces.
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "acus/imaging/slicing/beam_bend.h"
#include "acus/imaging/slicing/ct_sampler.h"
#include "acus/imaging/slicing/tracing/surface_tracer.h"

namespace acus::tracing {

/// Follows the lines at rest: one straight piece where the tissue has not moved, else as few pieces
/// as keep every sample within kMaxBendErrorMm of where it lies. Not for two threads at a time: it
/// holds buffers.
class BeamLabels {
 public:
  static constexpr double kMaxBendErrorMm = 0.01;

  /// Keeps a reference to `tracer`, which must outlive this.
  /// @param ct_from_index  Of the indices in which the lines are given.
  BeamLabels(const SurfaceTracer& tracer, const Eigen::Affine3d& ct_from_index);

  /// Sets label(line, sample) of all lines, and of the copies of the last line up to the next
  /// multiple of 16, as numbers. A sample on a surface belongs to what begins there. `label` has
  /// been resized to the grid. The same bits with any number of threads; allocates nothing after
  /// the first call while no line crosses more than SurfaceTracer::kUsualCrossings triangles.
  void Fill(const slicing::BeamLines& lines, const slicing::BeamBend& bend, int num_threads,
            slicing::BeamImage& label);

  /// Pieces of all lines of the last Fill.
  std::size_t num_pieces() const;

 private:
  static constexpr int kLines = 16;  ///< Of one piece of work: a row of cache.

  /// What one piece of work holds.
  struct Group {
    explicit Group(const SurfaceTracer& tracer) : buffers(tracer) {}
    SurfaceTracer::Buffers buffers;
    std::vector<Eigen::Vector3d> knot_mm;  ///< By knot, then line of the group.
    std::vector<PathPlace> path;
    std::vector<LabelChange> changes;
    std::size_t num_pieces = 0;
  };

  void Prepare(const slicing::BeamBend& bend, int lines, int samples);
  void PlaceKnots(const slicing::BeamLines& lines, const slicing::BeamBend& bend, int first,
                  Group& group) const;
  void LayPath(int line, Group& group) const;

  const SurfaceTracer& tracer_;
  Eigen::Affine3d ct_from_index_;
  std::vector<int> knots_;  ///< Samples between which lines are straight.
  std::vector<Group> groups_;
};

}  // namespace acus::tracing
