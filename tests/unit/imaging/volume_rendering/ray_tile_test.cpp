#include "acus/imaging/volume_rendering/ray_tile.h"

#include <gtest/gtest.h>
#include <memory>

#include "acus/data/volume/labels.h"
#include "acus/imaging/volume_rendering/smoothing.h"
#include "support/instruction_sets.h"
#include "support/trunk_ct.h"
#include "support/view_scenes.h"

namespace acus::volume_rendering {
namespace {

using Eigen::Vector3d;

/// Everything that a ray can meet: a volume that moves, where it slides too, surfaces and a shadow.
struct Everything {
  std::shared_ptr<volume::CtVolume> ct = testing_support::TrunkCt(80);
  TransferFunction transfer;
  TissueClasses classes;
  breathing::MotionField field = testing_support::FieldOf([](const Vector3d& place) -> Vector3d {
    const double slip_mm = place[2] > 20.0 ? 9.0 : 0.0;
    return 0.5 * testing_support::DiaphragmMm(place) + Vector3d(slip_mm, 0.0, 0.0);
  });
  breathing::MotionMap motion = testing_support::At(field, 0.8);
  VisibleBlocks blocks;
  SlopeVolume slopes;
  HiddenCells hidden;
  WarpLattice lattice;
  ShadowMap shadows;
  std::vector<Fragment> fragments;
  Camera camera;
  VolumeScene scene;
  RaySettings settings;

  explicit Everything(const char* layer)
      : Everything(TransferFunction(std::vector<VolumeLayer>{{layer, 1.0}})) {}

  explicit Everything(const HuWindow& window) : Everything(ShownIn(window)) {
    settings.projection = Projection::kMaximum;
    settings.window = window;
    scene.slopes = nullptr;
  }

  explicit Everything(TransferFunction shown, TissueClasses of_tissues = {})
      : transfer(std::move(shown)),
        classes(std::move(of_tissues)),
        blocks(*ct, transfer, &field, classes),
        slopes(Smoothed(*ct, 1), 1),
        hidden(*ct, transfer, classes) {
    blocks.Update(&motion, 1.0);
    lattice.Update(motion, blocks, ct->geometry.index_from_ct(), 0.15, 1);
    camera = LookAt({.eye_in_ct_mm = {-300, -700, 250}, .focus_in_ct_mm = {0, 0, 0}}, {96, 96});
    scene.ct = ct.get();
    scene.slopes = &slopes;
    scene.transfer = &transfer;
    if (classes.data() != nullptr) scene.classes = &classes;
    scene.blocks = &blocks;
    scene.hidden = &hidden;
    scene.motion = &motion;
    scene.lattice = &lattice;
    scene.light.to_lamp = Eigen::Vector3f(-0.4F, -0.7F, 0.6F).normalized();
    const mesh::Surface tool = testing_support::BallSurface({-60, -180, 60}, 25.0, 12);
    shadows.Begin(ShadowMap::FrameOf(
        scene.light.to_lamp,
        Eigen::AlignedBox3f(Eigen::Vector3f(-85, -205, 35), Eigen::Vector3f(-35, -155, 85))));
    shadows.Add(tool.nodes_mm.cast<float>(), tool.triangles);
    scene.shadows = &shadows;
    for (const float mm : {640.0F, 690.0F, 690.5F, 760.0F}) {
      fragments.push_back({mm, 0.4F, Eigen::Array3f(0.1F, 0.5F, 0.9F), mm == 690.0F});
    }
    fragments.push_back({850.0F, 1.0F, Eigen::Array3f(0.9F, 0.9F, 0.1F)});
  }

  /// Every third pixel has surfaces.
  std::vector<RayColour> Image() const {
    const TileCaster caster(scene, settings, camera);
    std::vector<RayColour> out;
    std::vector<std::span<const Fragment>> fragments_of;
    for (int top = 0; top < 96; top += 8) {
      for (int left = 0; left < 96; left += 13) {
        const TilePlace tile{left, top, std::min(13, 96 - left), 8};
        fragments_of.clear();
        for (int n = 0; n < tile.width_px * tile.height_px; ++n) {
          fragments_of.push_back(n % 3 == 0 ? std::span<const Fragment>(fragments)
                                            : std::span<const Fragment>());
        }
        std::vector<RayColour> of_tile(fragments_of.size());
        caster.Cast(tile, fragments_of, 0.0F, of_tile);
        out.insert(out.end(), of_tile.begin(), of_tile.end());
      }
    }
    return out;
  }

  std::vector<RayColour> ImageRayByRay() const {
    const RayCaster caster(scene, settings, camera.EyeInCtMm());
    std::vector<RayColour> out;
    for (int top = 0; top < 96; top += 8) {
      for (int left = 0; left < 96; left += 13) {
        int n = 0;
        for (int row = top; row < top + 8; ++row) {
          for (int column = left; column < std::min(96, left + 13); ++column, ++n) {
            const auto of_pixel =
                n % 3 == 0 ? std::span<const Fragment>(fragments) : std::span<const Fragment>();
            out.push_back(caster.Cast(camera.DirectionInCt({column, row}).normalized(), of_pixel));
          }
        }
      }
    }
    return out;
  }
};

void ExpectWhatRaysGiveOneByOne(const Everything& all) {
  ASSERT_GT(all.lattice.SmoothShare(), 0.5);
  ASSERT_LT(all.lattice.SmoothShare(), 0.99);
  const std::vector<RayColour> many = all.Image();
  const std::vector<RayColour> one = all.ImageRayByRay();
  ASSERT_EQ(many.size(), one.size());
  double sum = 0.0;
  int seen = 0;
  int far_off = 0;
  for (std::size_t n = 0; n < one.size(); ++n) {
    const float off = std::max((many[n].colour - one[n].colour).abs().maxCoeff(),
                               std::abs(many[n].opacity - one[n].opacity));
    sum += static_cast<double>(off) * off;
    seen += one[n].opacity > 0.5F;
    // A ray along an edge of a rib or of a shadow may just meet or miss it.
    far_off += off > 0.02F;
  }
  EXPECT_GT(seen, 1500);
  EXPECT_LT(std::sqrt(sum / static_cast<double>(one.size())), 2e-3);
  EXPECT_LT(far_off, 10);
}

// Bone; what ends a ray at the first bone; and what all of the body shows.
const HuWindow kWindows[] = {{100.0, 1000.0}, {100.0, 600.0}, {-200.0, 100.0}};

TEST(TileCaster, GivesWhatRaysGiveOneByOne) {
  for (const char* layer : {"skin", "bone", "soft_tissue"}) {
    SCOPED_TRACE(layer);
    ExpectWhatRaysGiveOneByOne(Everything(layer));
  }
  for (const HuWindow& window : kWindows) {
    SCOPED_TRACE(window.high_hu);
    ExpectWhatRaysGiveOneByOne(Everything(window));
  }
}

/// The trunk, of which labels call a slanted half liver.
Everything HalfALiver() {
  const TransferFunction transfer(std::vector<VolumeLayer>{{"liver", 1.0}});
  const volume::Geometry grid = testing_support::TrunkCt(80)->geometry;
  volume::LabelMap labels(grid, volume::LabelOf("muscle"));
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        if (i + j - k < 50) labels.At(i, j, k) = volume::LabelOf("liver");
      }
    }
  }
  return Everything(transfer, TissueClasses(grid, labels, transfer.class_of_label()));
}

TEST(TileCaster, GivesWhatRaysGiveOneByOneByTissue) {
  ExpectWhatRaysGiveOneByOne(HalfALiver());
}

// A sample that nothing can show at is not looked at; the image is the same.
TEST(TileCaster, PassesHiddenCellsWithoutLosingASample) {
  for (const char* layer : {"skin", "bone"}) {
    Everything all(layer);
    const std::vector<RayColour> passing = all.Image();
    all.scene.hidden = nullptr;
    const std::vector<RayColour> looking = all.Image();
    for (std::size_t n = 0; n < looking.size(); ++n) {
      EXPECT_LT((passing[n].colour - looking[n].colour).abs().maxCoeff(), 1e-4F) << n;
      EXPECT_NEAR(passing[n].opacity, looking[n].opacity, 1e-4F) << n;
    }
  }
}

void ExpectTheSameBitsOnEveryInstructionSet(const Everything& all) {
  std::vector<RayColour> first;
  int targets = 0;
  testing_support::OnEveryInstructionSet([&](const char* name) {
    const std::vector<RayColour> image = all.Image();
    if (first.empty()) first = image;
    for (std::size_t n = 0; n < first.size(); ++n) {
      ASSERT_TRUE((image[n].colour == first[n].colour).all()) << name << n;
      ASSERT_EQ(image[n].opacity, first[n].opacity) << name << n;
    }
    ++targets;
  });
  EXPECT_GT(targets, 1);
}

TEST(TileCaster, GivesTheSameBitsOnEveryInstructionSet) {
  ExpectTheSameBitsOnEveryInstructionSet(Everything("soft_tissue"));
  for (const HuWindow& window : kWindows) {
    ExpectTheSameBitsOnEveryInstructionSet(Everything(window));
  }
}

// The same pixels in tiles of other sizes: lanes do not depend on each other.
void ExpectRaysThatDoNotDependOnAdjacentRays(const Everything& all) {
  const TileCaster caster(all.scene, all.settings, all.camera);
  std::vector<RayColour> whole(128);
  caster.Cast({40, 40, 16, 8}, {}, 0.0F, whole);
  for (const int n : {0, 17, 60, 127}) {
    std::vector<RayColour> alone(1);
    caster.Cast({40 + n % 16, 40 + n / 16, 1, 1}, {}, 0.0F, alone);
    EXPECT_TRUE((alone[0].colour == whole[static_cast<std::size_t>(n)].colour).all()) << n;
    EXPECT_EQ(alone[0].opacity, whole[static_cast<std::size_t>(n)].opacity) << n;
  }
}

TEST(TileCaster, RaysDoNotDependOnAdjacentRays) {
  ExpectRaysThatDoNotDependOnAdjacentRays(Everything("skin"));
  for (const HuWindow& window : kWindows) {
    ExpectRaysThatDoNotDependOnAdjacentRays(Everything(window));
  }
}

}  // namespace
}  // namespace acus::volume_rendering
