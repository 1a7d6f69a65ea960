#include "acus/imaging/ultrasound/beams/beam_path.h"

#include <gtest/gtest.h>

namespace acus::ultrasound {
namespace {

/// A linear map, which pieces between knots follow exactly.
class Sheared : public slicing::RestMap {
 public:
  explicit Sheared(double spacing_mm) : spacing_mm_(spacing_mm) {}
  Eigen::Vector3d RestInCtMm(const Eigen::Vector3d& place_mm,
                             const Eigen::Vector3d&) const noexcept override {
    return place_mm + Eigen::Vector3d(2.0 + 0.05 * place_mm.y(), -1.0, 0.1 * place_mm.x());
  }
  double SpacingMm() const noexcept override { return spacing_mm_; }

 private:
  double spacing_mm_;
};

TEST(BeamPath, FollowsTissueOnEveryLineAndSample) {
  acoustics::Probe probe = acoustics::DefaultProbe();
  probe.kind = acoustics::ProbeKind::kLinear;
  probe.width_mm = 30.0;
  probe.depth_mm = 40.0;
  probe.samples_per_line = 161;
  const Eigen::Isometry3d pose(Eigen::Translation3d(5, -3, 8) *
                               Eigen::AngleAxisd(0.4, Eigen::Vector3d(1, 2, 2).normalized()));
  Eigen::Affine3d index_from_ct = Eigen::Affine3d::Identity();
  index_from_ct.linear().diagonal() << 2.0, 1.0, 0.5;
  // Knots on every line, on every few, with and without a rest at the end.
  for (const int lines : {61, 64}) {
    for (const double spacing_mm : {0.1, 1.1, 2.6, 7.0}) {
      probe.scan_lines = lines;
      const acoustics::ScanGrid grid = acoustics::BeamGridOf(probe);
      BeamPath path({.grid = &grid, .index_from_ct = index_from_ct, .elevation_mm = {}});
      const Sheared rest(spacing_mm);
      path.Set(pose, &rest);
      double largest = 0.0;
      for (int k = 0; k < grid.samples; ++k) {
        const slicing::kernels::Lines at = path.Voxels(path.PieceAt(k), 0);
        for (int l = 0; l < grid.lines(); ++l) {
          const auto n = static_cast<std::size_t>(l);
          const Eigen::Vector2d in_plane_mm =
              grid.start_mm[n] + k * grid.step_mm * grid.direction[n];
          const Eigen::Vector3d place_mm =
              pose * Eigen::Vector3d(in_plane_mm.x(), in_plane_mm.y(), 0.0);
          const Eigen::Vector3d expected = index_from_ct * rest.RestInCtMm(place_mm, place_mm);
          for (int a = 0; a < 3; ++a) {
            const double place = at.start[a][l] + static_cast<double>(k) * at.step[a][l];
            ASSERT_TRUE(std::isfinite(place)) << "line " << l << ", sample " << k;
            largest = std::max(largest, std::abs(place - expected[a]));
          }
        }
      }
      EXPECT_LT(largest, 2e-4) << lines << " lines, " << spacing_mm << " mm";
    }
  }
}

}  // namespace
}  // namespace acus::ultrasound
