#include "acus/imaging/slicing/tracing/beam_labels.h"

#include <cmath>
#include <gtest/gtest.h>

#include "support/allocation_counter.h"
#include "support/icosphere.h"

namespace acus::tracing {
namespace {

using testing_support::Icosphere;

acoustics::Probe CurvedProbe() {
  return {.name = "curved",
          .kind = acoustics::ProbeKind::kCurvilinear,
          .frequency_mhz = 4,
          .scan_lines = 75,
          .radius_mm = 40,
          .field_of_view_rad = 1.0,
          .depth_mm = 90,
          .image_width_px = 200,
          .image_height_px = 180,
          .slice_thickness_mm = 3,
          .dynamic_range_db = 60};
}

/// Pulled towards a line, as by a needle, within 20 mm of it.
class Pulled : public slicing::RestMap {
 public:
  explicit Pulled(double by_mm) : by_mm_(by_mm) {}
  Eigen::Vector3d RestInCtMm(const Eigen::Vector3d& x,
                             const Eigen::Vector3d&) const noexcept override {
    const double r = std::hypot(x[0] - 4.0, x[2]) / 20.0;
    const double share = r < 1.0 ? (1 - r * r) * (1 - r * r) : 0.0;
    return x - by_mm_ * share * Eigen::Vector3d(0.3, 1.0, 0.1);
  }
  double SpacingMm() const noexcept override { return 2.0; }

 private:
  double by_mm_;
};

class BeamLabelsTest : public ::testing::Test {
 protected:
  BeamLabelsTest() {
    index_.linear() = 2.0 * Eigen::Matrix3d::Identity();  // Voxels of 0.5 mm.
    index_.translation() << 100, 90, 80;
    pose_.translation() << 1, -50, 2;
    pose_.linear() =
        Eigen::AngleAxisd(0.2, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  }

  slicing::BeamImage Filled(const slicing::RestMap* rest, int num_threads) {
    slicing::PlaceLines(grid_, index_, pose_, lines_);
    bend_.Set(grid_, pose_, index_, rest);
    slicing::BeamImage label;
    label.Resize(grid_.lines(), grid_.samples);
    labels_.Fill(lines_, bend_, num_threads, label);
    return label;
  }

  /// Where the images look for the sample at rest.
  Eigen::Vector3d RestOf(int line, int k) const {
    slicing::BeamBend::Row row;
    float sample = 0.0F;
    const auto placed = bend_.PlaceRow(lines_, k, line / 16 * 16, 16, row, sample);
    Eigen::Vector3d at;
    for (int a = 0; a < 3; ++a) {
      at[a] = placed.start[a][line % 16] + sample * placed.step[a][line % 16];
    }
    return index_.inverse() * at;
  }

  /// Each sample looked up by itself: what differs must lie within `limit_mm` of a surface.
  void ExpectLikeEachSample(const slicing::BeamImage& label, double limit_mm) const {
    SurfaceTracer::Buffers buffers(tracer_);
    std::vector<LabelChange> changes;
    const auto at = [&](const Eigen::Vector3d& place) {
      const PathPlace path[] = {{place, 0.0}};
      tracer_.Trace(path, buffers, changes);
      return static_cast<float>(changes.back().label);
    };
    int inside = 0;
    for (int l = 0; l < label.lines(); ++l) {
      for (int k = 0; k < label.samples(); ++k) {
        const Eigen::Vector3d place = RestOf(l, k);
        const float found = label.row(k)[l];
        inside += found > 0 ? 1 : 0;
        if (at(place) == found) continue;
        bool is_near = false;
        for (int axis = 0; axis < 6 && !is_near; ++axis) {
          Eigen::Vector3d beside = place;
          beside[axis % 3] += axis < 3 ? limit_mm : -limit_mm;
          is_near = at(beside) == found;
        }
        EXPECT_TRUE(is_near) << "line " << l << ", sample " << k << ": " << found;
      }
    }
    EXPECT_GT(inside, label.lines() * label.samples() / 4);
  }

  acoustics::ScanGrid grid_ = acoustics::ScanGridOf(CurvedProbe());
  SurfaceTracer tracer_{{{Icosphere(45.0, 5), mesh::Winding::kOriented, 4},
                         {Icosphere(15.0, 4, {3, -15, 2}), mesh::Winding::kOriented, 8},
                         {Icosphere(12.0, 4, {-10, 0, 2}), mesh::Winding::kOriented, 5}},
                        1};
  Eigen::Affine3d index_ = Eigen::Affine3d::Identity();
  Eigen::Isometry3d pose_ = Eigen::Isometry3d::Identity();
  BeamLabels labels_{tracer_,
                     Eigen::Affine3d(Eigen::Translation3d(-50, -45, -40)) * Eigen::Scaling(0.5)};
  slicing::BeamLines lines_;
  slicing::BeamBend bend_;
};

TEST_F(BeamLabelsTest, StraightLinesAreOnePieceAndLikeEachSample) {
  const slicing::BeamImage label = Filled(nullptr, 1);
  EXPECT_EQ(labels_.num_pieces(), static_cast<std::size_t>(grid_.lines()));
  ExpectLikeEachSample(label, 1e-4);
}

TEST_F(BeamLabelsTest, BentLinesAreFewPiecesAndLikeEachSample) {
  const Pulled pulled(6.0);
  const slicing::BeamImage label = Filled(&pulled, 1);
  ASSERT_TRUE(bend_.active());
  ExpectLikeEachSample(label, BeamLabels::kMaxBendErrorMm);
  const auto lines = static_cast<std::size_t>(grid_.lines());
  EXPECT_GT(labels_.num_pieces(), lines);
  EXPECT_LT(labels_.num_pieces(), lines * bend_.samples_of_knots().size() / 2);
  // And it shows: without the bend much is elsewhere.
  const slicing::BeamImage straight = Filled(nullptr, 1);
  int moved = 0;
  for (int k = 0; k < label.samples(); ++k) {
    for (int l = 0; l < label.lines(); ++l) moved += label.row(k)[l] != straight.row(k)[l] ? 1 : 0;
  }
  EXPECT_GT(moved, 300);
}

TEST_F(BeamLabelsTest, ThreadsChangeNoBitAndTheLastLineIsCopied) {
  const Pulled pulled(6.0);
  const slicing::BeamImage one = Filled(&pulled, 1), three = Filled(&pulled, 3);
  for (int k = 0; k < one.samples(); ++k) {
    for (int l = 0; l < slicing::kernels::RoundUp(one.lines()); ++l) {
      ASSERT_EQ(one.row(k)[l], three.row(k)[l]);
      ASSERT_EQ(one.row(k)[l], one.row(k)[std::min(l, one.lines() - 1)]);
    }
  }
}

TEST_F(BeamLabelsTest, AllocatesNothingAfterTheFirstImage) {
  const Pulled pulled(6.0);
  slicing::BeamImage label = Filled(&pulled, 2);
  const long before = testing_support::num_allocations;
  labels_.Fill(lines_, bend_, 2, label);
  labels_.Fill(lines_, bend_, 1, label);
  EXPECT_EQ(testing_support::num_allocations - before, 0);
}

}  // namespace
}  // namespace acus::tracing
