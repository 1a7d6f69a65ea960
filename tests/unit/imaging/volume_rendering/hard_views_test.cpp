// What a view must bear: an image or a clear message, never a crash.
#include <fstream>
#include <gmock/gmock.h>
#include <limits>

#include "acus/base/core/error.h"
#include "acus/imaging/volume_rendering/patient_view.h"
#include "support/temporary_folder.h"
#include "support/trunk_ct.h"
#include "support/view_scenes.h"

namespace acus::volume_rendering {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

Camera Oblique(const ImageSize& size) {
  return LookAt({.eye_in_ct_mm = {-300, -700, 250}, .focus_in_ct_mm = {0, 0, 0}}, size);
}

std::ptrdiff_t CoveredPixels(const ViewImage& image) {
  return std::ranges::count_if(image.coverage, [](std::uint8_t c) { return c > 0; });
}

// Tissue turned inside out: places that several tissues claim, and others that none does.
TEST(HardViews, AFieldThatFolds) {
  const auto field = testing_support::FieldOf(
      [](const Eigen::Vector3d& place) -> Eigen::Vector3d {
        return 60.0 * Eigen::Vector3d(std::sin(place[1] / 9.0), std::sin(place[2] / 7.0),
                                      std::sin(place[0] / 8.0));
      },
      40);
  const auto motion = testing_support::At(field, 1.0);
  const auto ct = testing_support::TrunkCt(64);
  for (const char* layer : {"skin", "soft_tissue"}) {
    PatientView view({.ct = ct, .layers = {{layer, 1.0}}, .surfaces = {}, .field = &field}, {});
    ViewImage first;
    view.Render(Oblique({48, 48}), {.motion = &motion}, first, 1);
    EXPECT_GT(CoveredPixels(first), 300) << layer;
    ViewImage again;
    view.Render(Oblique({48, 48}), {.motion = &motion}, again, 3);
    EXPECT_EQ(first.colour.rgb, again.colour.rgb) << layer;
  }
}

TEST(HardViews, SurfacesInAFieldThatFolds) {
  const auto field = testing_support::FieldOf(
      [](const Eigen::Vector3d& place) { return Eigen::Vector3d(-place); }, 20);
  const auto motion = testing_support::At(field, 1.0);  // All comes to one point.
  PatientView view({.ct = nullptr,
                    .layers = {},
                    .surfaces = {{"ball", testing_support::BallSurface({0, 0, 0}, 60.0, 16)}},
                    .field = &field},
                   {});
  ViewImage image;
  EXPECT_NO_THROW(view.Render(Oblique({64, 64}), {.motion = &motion}, image, 1));
}

TEST(HardViews, EmptyAndTinyVolumes) {
  volume::Geometry grid;
  for (const int size : {2, 3, 7}) {
    grid.size.setConstant(size);
    grid.spacing_mm.setConstant(40.0);
    for (const std::int16_t hu : {std::numeric_limits<std::int16_t>::lowest(), std::int16_t{-1000},
                                  std::int16_t{50}, std::numeric_limits<std::int16_t>::max()}) {
      const auto ct = std::make_shared<volume::CtVolume>(grid, hu);
      PatientView view({.ct = ct, .layers = {{"bone", 1.0}, {"skin", 0.5}}, .surfaces = {}}, {});
      ViewImage image;
      view.Render(Oblique({40, 40}), {}, image, 2);
      EXPECT_EQ(CoveredPixels(image) > 0, hu > -400) << size << " " << hu;
    }
  }
}

// From within the body, and in images of any size one after the other.
TEST(HardViews, AnyEyeAndAnotherSizeEachTime) {
  PatientView view(
      {.ct = testing_support::TrunkCt(64), .layers = {{"soft_tissue", 1.0}}, .surfaces = {}}, {});
  const Eigen::Vector3d eyes[] = {{0, 0, 0}, {0, -125, 0}, {5000, 0, 0}, {-300, -700, 250}};
  const ImageSize sizes[] = {{1, 1}, {17, 5}, {3, 130}, {64, 48}};
  for (const Eigen::Vector3d& eye : eyes) {
    for (const ImageSize& size : sizes) {
      ViewImage image;
      view.Render(LookAt({.eye_in_ct_mm = eye, .focus_in_ct_mm = {1, 2, 3}}, size), {}, image, 2);
      ASSERT_EQ(image.coverage.size(), static_cast<std::size_t>(size.width_px * size.height_px));
    }
  }
}

TEST(HardViews, ATransferFunctionOfZeros) {
  const testing_support::TemporaryFolder folder;
  const std::filesystem::path zeros = folder.path() / "zeros.json";
  std::ofstream(zeros) << R"({"format": "acus-transfer-function/1", "name": "Zeros", "nodes": [
      {"hu": 0, "extinction_per_mm": 0, "colour": [1, 1, 1]},
      {"hu": 100, "extinction_per_mm": 0, "colour": [1, 1, 1]}]})";
  PatientInView patient{
      .ct = testing_support::TrunkCt(32), .layers = {{zeros.string(), 1.0}}, .surfaces = {}};
  EXPECT_THAT([&] { PatientView(patient, {}); },
              ThrowsMessage<InputError>(HasSubstr("nothing to show")));
  patient.surfaces = {{"ball", testing_support::BallSurface({0, 0, 0}, 60.0, 16)}};
  PatientView view(patient, {});
  ViewImage image;
  view.Render(Oblique({64, 64}), {}, image, 1);
  EXPECT_GT(CoveredPixels(image), 50);
}

}  // namespace
}  // namespace acus::volume_rendering
