#include "acus/imaging/volume_rendering/warp_lattice.h"

#include <cmath>
#include <gtest/gtest.h>

#include "acus/imaging/volume_rendering/patient_view.h"
#include "support/trunk_ct.h"
#include "support/view_scenes.h"

namespace acus::volume_rendering {
namespace {

using testing_support::PsnrDb;

using Eigen::Vector3d;

/// Organs within a wall slide along it by 15 mm; all else follows DiaphragmMm.
Vector3d SlidingMm(const Vector3d& place_mm) {
  const bool inside = std::hypot(place_mm[0] / 145.0, place_mm[1] / 102.0) < 1.0;
  return 0.5 * testing_support::DiaphragmMm(place_mm) + Vector3d(0.0, 0.0, inside ? 15.0 : 0.0);
}

breathing::MotionField TrunkField(bool slides) {
  volume::Geometry nodes;
  nodes.size.setConstant(64);
  nodes.spacing_mm.setConstant(400.0 / 63.0);
  nodes.origin_mm.setConstant(-200.0);
  breathing::MotionField field(nodes, 1);
  std::vector<float> values;
  const Eigen::Affine3d ct_from_index = nodes.ct_from_index();
  for (int k = 0; k < 64; ++k) {
    for (int j = 0; j < 64; ++j) {
      for (int i = 0; i < 64; ++i) {
        const Vector3d place = ct_from_index * Vector3d(i, j, k);
        const Vector3d moved = slides ? SlidingMm(place) : testing_support::DiaphragmMm(place);
        for (const double mm : moved) values.push_back(static_cast<float>(mm));
      }
    }
  }
  field.SetComponent(0, values);
  return field;
}

ViewImage Image(const std::shared_ptr<const volume::CtVolume>& ct, const char* layer,
                const breathing::MotionField& field, double lattice_mm) {
  ViewSettings settings;
  settings.rays.warp.lattice_mm = lattice_mm;
  PatientView view({.ct = ct, .layers = {{layer, 1.0}}, .surfaces = {}, .field = &field}, settings);
  const ImageSize size{112, 112};
  const Camera camera = LookAt(ViewFrom("oblique", view.box_in_ct_mm(), size), size);
  const breathing::MotionMap motion = testing_support::At(field, 0.8);
  ViewImage out;
  view.Render(camera, {.motion = &motion}, out, 2);
  return out;
}

// Against every sample inverted to the last digits. 40 dB is 2.5 of 255 grey levels: not seen.
TEST(WarpLattice, TheImageIsThatOfExactInversion) {
  const auto ct = testing_support::TrunkCt(128);
  for (const bool slides : {false, true}) {
    const breathing::MotionField field = TrunkField(slides);
    for (const char* layer : {"skin", "bone", "soft_tissue"}) {
      const ViewImage exact = Image(ct, layer, field, 0.0);
      const double usual_db = PsnrDb(Image(ct, layer, field, WarpSettings{}.lattice_mm), exact);
      const double coarse_db = PsnrDb(Image(ct, layer, field, 5.0), exact);
      std::printf("  %s, %-11s: %.1f dB; with 5 mm allowed %.1f dB\n",
                  slides ? "sliding" : "smooth ", layer, usual_db, coarse_db);
      EXPECT_GT(usual_db, 40.0) << layer << slides;
      EXPECT_GE(usual_db, coarse_db - 0.5);
    }
  }
}

struct Blocks {
  std::shared_ptr<volume::CtVolume> ct = testing_support::TrunkCt(96);
  TransferFunction transfer{std::vector<VolumeLayer>{{"soft_tissue", 1.0}}};
  breathing::MotionField field;
  breathing::MotionMap motion;
  VisibleBlocks blocks;
  WarpLattice lattice;
  explicit Blocks(bool slides)
      : field(TrunkField(slides)),
        motion(testing_support::At(field, 0.8)),
        blocks(*ct, transfer, &field) {
    blocks.Update(&motion, 1.0);
    lattice.Update(motion, blocks, ct->geometry.index_from_ct(), 0.15, 2);
  }
};

TEST(WarpLattice, SaysWhereTissueWasWithinItsTolerance) {
  for (const bool slides : {false, true}) {
    const Blocks b(slides);
    const Eigen::Affine3f ct_from_blocks = b.blocks.blocks_from_ct().inverse();
    const Eigen::Affine3d ct_from_index = b.ct->geometry.ct_from_index();
    double worst_mm = 0.0;
    int judged = 0;
    for (int n = 0; n < 40000; ++n) {
      const auto part = [n](double step) { return static_cast<float>(std::fmod(step * n, 1.0)); };
      const Eigen::Vector3f in_blocks =
          (Eigen::Array3f(part(0.618034), part(0.7548777), part(0.5698403)) *
           (b.blocks.size().cast<float>() - 1.0F))
              .matrix();
      const Eigen::Array3i block = in_blocks.array().cast<int>();
      if (b.blocks.DistanceOf(block) != 0 || !b.lattice.IsSmooth(block)) continue;
      const Vector3d place = (ct_from_blocks * in_blocks).cast<double>();
      const Vector3d rest =
          place + ct_from_index.linear() * b.lattice.OffsetAt(block, in_blocks).cast<double>();
      worst_mm = std::max(worst_mm, (b.motion.WorldMm(rest) - place).norm());
      ++judged;
    }
    EXPECT_GT(judged, 3000);
    EXPECT_LT(worst_mm, 0.4) << slides;  // Between the five places, at a node of the field.
    EXPECT_GT(b.lattice.SmoothShare(), slides ? 0.5 : 0.9);
    if (slides) {
      EXPECT_LT(b.lattice.SmoothShare(), 0.95);
    }
  }
}

TEST(WarpLattice, IsEmptyWithoutToleranceOrMotion) {
  Blocks b(false);
  b.lattice.Update(b.motion, b.blocks, b.ct->geometry.index_from_ct(), 0.0, 1);
  EXPECT_EQ(b.lattice.SmoothShare(), 0.0);
  const breathing::MotionMap still(b.field, {});
  b.lattice.Update(still, b.blocks, b.ct->geometry.index_from_ct(), 0.15, 1);
  EXPECT_FALSE(b.lattice.IsSmooth({5, 5, 5}));
}

// What is jumped over, and samples that need no voxel, change no bit.
TEST(RayCaster, SkippingChangesNoBit) {
  const auto ct = testing_support::TrunkCt(96);
  const Vector3d eye(-300.0, -700.0, 250.0);
  for (const char* layer : {"skin", "bone", "soft_tissue"}) {
    const TransferFunction transfer{std::vector<VolumeLayer>{{layer, 1.0}}};
    VisibleBlocks blocks(*ct, transfer, nullptr);
    blocks.Update(nullptr, 1.0);
    const HiddenCells hidden(*ct, transfer);
    VolumeScene scene;
    const SlopeVolume slopes(*ct, 1);
    scene.ct = ct.get();
    scene.slopes = &slopes;
    scene.transfer = &transfer;
    scene.blocks = &blocks;
    const RayCaster plain(scene, {}, eye);
    scene.hidden = &hidden;
    const RayCaster skipping(scene, {}, eye);
    int seen = 0;
    for (int row = -20; row < 20; ++row) {
      for (int column = -20; column < 20; ++column) {
        const auto ray = [&](double x, double y) {
          return Vector3d(
              (Vector3d(300.0, 700.0, -250.0) + 10.0 * Vector3d(x, 0.0, y)).normalized());
        };
        const Vector3d rim[] = {ray(column - 0.5, row - 0.5), ray(column + 0.5, row - 0.5),
                                ray(column - 0.5, row + 0.5), ray(column + 0.5, row + 0.5)};
        const float empty_mm = skipping.EmptyUntilMm(ray(column, row), rim);
        for (const double off : {-0.45, 0.0, 0.3}) {
          const Vector3d direction = ray(column + off, row - off);
          const RayColour a = plain.Cast(direction, {});
          const RayColour b = skipping.Cast(direction, {}, empty_mm);
          ASSERT_TRUE((a.colour == b.colour).all());
          ASSERT_EQ(a.opacity, b.opacity);
          seen += a.opacity > 0.5F;
        }
      }
    }
    EXPECT_GT(seen, 100) << layer;
  }
}

}  // namespace
}  // namespace acus::volume_rendering
