// Views that are hard on a tracker: each must be found within a bound, or not be found, or be said
// to be uncertain. Never a wrong pose that claims to be good.
#include <gtest/gtest.h>
#include <iostream>

#include "support/bound.h"
#include "support/facet_views.h"

namespace acus::camera {
namespace {

using namespace testing_support;

class HardView : public testing::Test {
 protected:
  CameraModel camera_ = ReadCamera(ConfigPath("cameras/webcam_720p.json"));
  FacetSet set_ = ReadFacets(ConfigPath("facets/training.json"));
  Eigen::Isometry3d truth_ = FacingPose({30, -100, 1000}, 25, 60, 10);

  Image Take(const ImageMaking& making) {
    MannequinCamera maker(camera_, set_, {}, making);
    Image image;
    const ObjectInView shown[] = {{"Reference", truth_}};
    maker.Render(shown, 1, image);
    return image;
  }
  std::optional<ObjectPose> Locate(const Image& image,
                                   const std::optional<Eigen::Isometry3d>& previous = {}) {
    MarkerDetector detector(set_.dictionary);
    return LocateObject(*set_.Find("Reference"), detector.Detect(image, &camera_), camera_, {},
                        previous);
  }
  void ExpectGood(const HardCase& hard, const std::optional<ObjectPose>& pose, double position_mm,
                  double angle_deg) {
    ASSERT_TRUE(pose);
    const PoseError error = ErrorOf(pose->camera_from_object, truth_);
    std::cout << error.position_mm << " mm, " << error.angle_deg << " deg, " << pose->corners_used
              << " corners, " << pose->corners_rejected << " rejected\n";
    hard.Expect("error of position", error.position_mm, Below(position_mm), "mm");
    hard.Expect("error of direction", error.angle_deg, Below(angle_deg), "deg");
  }
};

std::uint8_t* PixelAt(Image& image, double column, double row) {
  return image.pixels.data() + (static_cast<int>(row) * image.width_px + static_cast<int>(column));
}

void Cover(Image& image, const Eigen::Vector2d& from, const Eigen::Vector2d& to,
           std::uint8_t level) {
  for (int row = static_cast<int>(from[1]); row < to[1]; ++row) {
    std::fill(PixelAt(image, from[0], row), PixelAt(image, to[0], row), level);
  }
}

TEST_F(HardView, OutOfFocus) {
  const HardCase hard("Out of focus by 1.5 pixels.");
  ExpectGood(hard, Locate(Take({.blur_sigma_px = 1.5, .colour = false})), 0.5, 0.5);
}

TEST_F(HardView, FarOutOfFocus) {
  // A blur of half a module: the code shines into the edges. It must at least be said.
  const auto pose = Locate(Take({.blur_sigma_px = 3.0, .colour = false}));
  const HardCase hard("A blur of half a module: the code shines into the edges; it must be said.");
  ExpectGood(hard, pose, 5.0, 1.0);
  hard.Expect("error of position as a share of what is said",
              ErrorOf(pose->camera_from_object, truth_).position_mm / pose->PositionSigmaMm(),
              Below(3.0));
}

TEST_F(HardView, Noise) {
  const HardCase hard("Noise of 15 grey levels.");
  ExpectGood(hard, Locate(Take({.noise_sigma = 15.0, .colour = false})), 0.5, 0.5);
}

TEST_F(HardView, DimAndUneven) {
  const HardCase hard("White at 90 of 255, and light that falls off by 90 % across the image.");
  ExpectGood(hard, Locate(Take({.black = 20, .white = 90, .light_gradient = 0.9, .colour = false})),
             0.5, 0.5);
}

TEST_F(HardView, Grazing) {
  // One facet of the roof at 80 degrees from facing, the other at 20.
  const HardCase hard("One facet at 80 degrees from facing, the other at 20.");
  truth_ = FacingPose({0, 0, 1000}, 50, 90, 0);
  ExpectGood(hard, Locate(Take({.colour = false})), 0.5, 0.5);
}

TEST_F(HardView, FarAndTiny) {
  // 3 m: 18 px a side.
  truth_ = FacingPose({100, 50, 3000}, 25, 60, 10);
  const HardCase hard("At 3 m: markers of 18 pixels.");
  ExpectGood(hard, Locate(Take({.colour = false})), 5.0, 0.5);
}

TEST_F(HardView, HalfOutOfTheImage) {
  const HardCase hard("Half out of the image.");
  truth_ = FacingPose({520, -100, 1000}, 25, 60, 10);
  ExpectGood(hard, Locate(Take({.colour = false})), 0.5, 0.5);
}

TEST_F(HardView, HandOverSixOfEightMarkers) {
  Image image = Take({.colour = false});
  const auto corner_of = [&](int marker, std::size_t corner) {
    for (const Marker& known : set_.Find("Reference")->markers) {
      if (known.id == marker) return *camera_.Project(truth_ * known.CornersInObjectMm()[corner]);
    }
    return Eigen::Vector2d(0, 0);
  };
  // All of the right facet and the top of the left one.
  Eigen::AlignedBox2d box;
  for (const int id : {4, 5, 6, 7}) {
    for (std::size_t k = 0; k < 4; ++k) box.extend(corner_of(id, k));
  }
  Cover(image, box.min(), box.max().cwiseMin(Eigen::Vector2d(1279, 719)), 110);
  const auto pose = Locate(image);
  ASSERT_TRUE(pose);
  const HardCase hard("A hand over six of eight markers.");
  EXPECT_LE(pose->corners_used, 16);
  ExpectGood(hard, pose, 0.5, 0.5);
}

TEST_F(HardView, FingerOverAnEdge) {
  // A finger from outside covers a third of one marker's edge: that marker cannot be read, or its
  // edge is found from the rest.
  Image image = Take({.colour = false});
  const Marker& marker = set_.Find("Reference")->markers[0];
  const Eigen::Vector2d a = *camera_.Project(truth_ * marker.CornersInObjectMm()[0]);
  const Eigen::Vector2d b = *camera_.Project(truth_ * marker.CornersInObjectMm()[1]);
  const Eigen::Vector2d middle = 0.5 * (a + b);
  Cover(image, middle - Eigen::Vector2d(6, 20), middle + Eigen::Vector2d(6, 2), 150);
  const HardCase hard("A finger over a third of one marker's edge.");
  ExpectGood(hard, Locate(image), 0.5, 0.5);
}

TEST_F(HardView, Mirrored) {
  Image image = Take({.colour = false});
  for (int row = 0; row < image.height_px; ++row) {
    std::reverse(PixelAt(image, 0, row), PixelAt(image, 0, row) + image.width_px);
  }
  EXPECT_FALSE(Locate(image));
}

TEST_F(HardView, ASheetThatIsThereTwice) {
  // A copy of one marker elsewhere in the image: the other seven say which one is ours.
  FacetSet twice = set_;
  Marker copy = twice.objects[0].markers[2];
  copy.object_from_marker = Eigen::Translation3d(-250, 60, 40) * copy.object_from_marker;
  twice.objects[0].markers.push_back(copy);
  MannequinCamera maker(camera_, twice, {}, {.colour = false});
  Image image;
  const ObjectInView shown[] = {{"Reference", truth_}};
  maker.Render(shown, 1, image);
  const auto pose = Locate(image);
  ASSERT_TRUE(pose);
  const HardCase hard("A copy of one marker elsewhere in the image.");
  EXPECT_EQ(pose->corners_used, 32);
  ExpectGood(hard, pose, 0.5, 0.5);
}

TEST_F(HardView, ASheetThatHasSlipped) {
  // One marker was stuck on 8 mm beside its place: its corners are left out, and counted.
  FacetSet slipped = set_;
  slipped.objects[0].markers[5].object_from_marker =
      Eigen::Translation3d(0, 8, 0) * slipped.objects[0].markers[5].object_from_marker;
  MannequinCamera maker(camera_, slipped, {}, {.colour = false});
  Image image;
  const ObjectInView shown[] = {{"Reference", truth_}};
  maker.Render(shown, 1, image);
  const auto pose = Locate(image);
  ASSERT_TRUE(pose);
  const HardCase hard("One marker was stuck on 8 mm beside its place.");
  hard.Expect("corners left out", pose->corners_rejected, Exactly(4));
  ExpectGood(hard, pose, 0.5, 0.5);
}

TEST_F(HardView, NothingThere) {
  Image image = Take({.colour = false});
  std::fill(image.pixels.begin(), image.pixels.end(), std::uint8_t{120});
  EXPECT_FALSE(Locate(image));
  EXPECT_FALSE(Locate(Image{}));
}

TEST_F(HardView, NothingButNoise) {
  const HardCase hard("An image of static: no pose may be made of it.");
  Image image = Take({.colour = false});
  RandomStream random(5, "static");
  for (std::uint8_t& level : image.pixels) level = static_cast<std::uint8_t>(random.Next() & 0xff);
  hard.Expect("poses found", Locate(image).has_value(), Exactly(0));
}

/// One small marker from the front has two poses.
class TwoPoses : public HardView {
 protected:
  TwoPoses() { set_ = OneMarker(30.0); }
};

TEST_F(TwoPoses, AWrongOneIsNeverSaidToBeSure) {
  const HardCase hard("One small marker from the front has two poses that fit alike.");
  int wrong_and_sure = 0;
  int unsure = 0;
  int wrong = 0;
  int count = 0;
  for (int i = 0; i < 40; ++i) {
    RandomStream random(11, "flat", static_cast<std::uint64_t>(i));
    truth_ = FacingPose({random.Uniform(-200, 200), random.Uniform(-100, 100), 1200},
                        random.Uniform(0, 35), random.Uniform(0, 360), random.Uniform(0, 360));
    const auto pose = Locate(Take({.noise_sigma = 4.0, .colour = false}));
    ASSERT_TRUE(pose);
    ++count;
    unsure += pose->ambiguous ? 1 : 0;
    const double off = ErrorOf(pose->camera_from_object, truth_).angle_deg;
    if (off < 5.0) continue;
    ++wrong;
    wrong_and_sure += pose->ambiguous ? 0 : 1;
  }
  std::cout << count << " views, " << wrong << " wrong, " << unsure << " said to be ambiguous\n";
  EXPECT_GT(wrong, 0);  // Otherwise this tests nothing.
  hard.Expect("wrong poses said to be sure", wrong_and_sure, Exactly(0));
  // Nor may all be called ambiguous.
  hard.Expect("poses said to be unsure, of 40", unsure, Below(3.0 * count / 4.0));
}

TEST_F(TwoPoses, TheImageBeforeDeterminesWhich) {
  const HardCase hard("Of two poses that fit alike, the one near the image before is taken.");
  Largest off_deg;
  for (int i = 0; i < 20; ++i) {
    RandomStream random(12, "flat", static_cast<std::uint64_t>(i));
    const double azimuth = random.Uniform(0, 360);
    truth_ = FacingPose({50, 20, 1200}, 18, azimuth, 30);
    const Eigen::Isometry3d before = FacingPose({52, 19, 1198}, 16, azimuth + 4, 29);
    const auto pose = Locate(Take({.noise_sigma = 4.0, .colour = false}), before);
    ASSERT_TRUE(pose);
    off_deg.Add(ErrorOf(pose->camera_from_object, truth_).angle_deg);
  }
  hard.Expect("error of direction", off_deg, Below(5.0), "deg");
}

}  // namespace
}  // namespace acus::camera
