#include "acus/data/transforms/transform_file.h"

#include <gmock/gmock.h>
#include <numbers>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "support/fuzz.h"
#include "support/temporary_folder.h"

namespace acus::transforms {
namespace {

using Eigen::AngleAxisd;
using Eigen::Isometry3d;
using Eigen::Vector3d;
using testing::HasSubstr;
using testing::ThrowsMessage;

/// Removed when the tests end.
std::filesystem::path TransformFileScratch() {
  static const testing_support::TemporaryFolder folder;
  return folder.path();
}

constexpr const char* kHead = "#Insight Transform File V1.0\n#Transform 0\n";

std::filesystem::path TransformFileFileWith(std::string_view text) {
  const auto path = TransformFileScratch() / "transform.tfm";
  WriteTextFile(path, text);
  return path;
}

Isometry3d ReadText(const std::string& text) {
  return ReadTransform(TransformFileFileWith(text));
}

Isometry3d Oblique() {
  return Eigen::Translation3d(120.5, -35.25, 840.125) *
         AngleAxisd(1.1, Vector3d(1, -2, 0.5).normalized());
}

TEST(WriteTransform, ComesBackBitForBit) {
  const auto path = TransformFileScratch() / "written.tfm";
  WriteTransform(path, Oblique(), "ct_from_reference\nsecond line");
  EXPECT_EQ(ReadTransform(path).matrix(), Oblique().matrix());
  Isometry3d sheared = Oblique();
  sheared(0, 0) *= 1.1;
  EXPECT_THAT([&] { WriteTransform(path, sheared, ""); },
              ThrowsMessage<InputError>(HasSubstr("not rigid")));
}

TEST(ReadTransform, TurnsAboutTheCentre) {
  // A quarter turn about z through the point (10, 0, 0), then 1 mm along z.
  const Isometry3d read =
      ReadText(std::string(kHead) +
               "Transform: AffineTransform_double_3_3\n"
               "Parameters: 0 -1 0 1 0 0 0 0 1 0 0 1\nFixedParameters: 10 0 0\n");
  EXPECT_TRUE((read * Vector3d(10, 0, 0)).isApprox(Vector3d(10, 0, 1), 1e-12));
  EXPECT_TRUE((read * Vector3d(11, 0, 0)).isApprox(Vector3d(10, 1, 1), 1e-12));
}

TEST(ReadTransform, ReadsTheKindsOfRigidTransform) {
  const std::string centre = "\nFixedParameters: 0 0 0\n";
  const auto x = AngleAxisd(0.1, Vector3d::UnitX());
  const auto y = AngleAxisd(0.2, Vector3d::UnitY());
  const auto z = AngleAxisd(0.3, Vector3d::UnitZ());
  const std::string euler =
      std::string(kHead) + "Transform: Euler3DTransform_double_3_3\nParameters: 0.1 0.2 0.3 4 5 6";
  EXPECT_TRUE(ReadText(euler + centre).linear().isApprox((z * x * y).toRotationMatrix(), 1e-12));
  EXPECT_TRUE(ReadText(euler + "\nFixedParameters: 0 0 0 1\n")
                  .linear()
                  .isApprox((z * y * x).toRotationMatrix(), 1e-12));
  EXPECT_EQ(ReadText(euler + centre).translation(), Vector3d(4, 5, 6));
  const double s = std::sin(std::numbers::pi / 4);
  const std::string half = std::to_string(s);
  EXPECT_TRUE(
      ReadText(std::string(kHead) +
               "Transform: VersorRigid3DTransform_double_3_3\nParameters: 0 0 " + half + " 1 2 3" +
               centre)
          .linear()
          .isApprox(AngleAxisd(std::numbers::pi / 2, Vector3d::UnitZ()).toRotationMatrix(), 1e-5));
  EXPECT_EQ(
      ReadText(std::string(kHead) +
               "Transform: TranslationTransform_double_3_3\nParameters: 1 2 3\nFixedParameters:\n")
          .translation(),
      Vector3d(1, 2, 3));
  EXPECT_EQ(ReadText(std::string(kHead) +
                     "Transform: IdentityTransform_double_3_3\nParameters:\nFixedParameters:\n")
                .matrix(),
            Eigen::Matrix4d::Identity());
  EXPECT_EQ(ReadText("1 0 0 5\n0 1 0 6\n0 0 1 7\n0 0 0 1\n").translation(), Vector3d(5, 6, 7));
}

// What ITK 5.2 makes of the point (80, 0, 0) with transforms that it wrote itself.
TEST(ReadTransform, AgreesWithItk) {
  const auto mapped = [](const std::string& kind, const std::string& parameters,
                         const std::string& fixed) {
    const Isometry3d read =
        ReadText(kHead + ("Transform: " + kind) + "_double_3_3\nParameters: " + parameters +
                 "\nFixedParameters: " + fixed + "\n");
    return Vector3d(read * Vector3d(80, 0, 0));
  };
  const Vector3d zxy(90.658143996803787, 29.501953483917614, 18.58559866679483);
  const Vector3d zyx(90.58072434584264, 30.993773653557128, 18.694875439454698);
  EXPECT_LT((mapped("Euler3DTransform", "0.1 -0.2 0.3 4 5 6", "10 20 30 0") - zxy).norm(), 1e-12);
  EXPECT_LT((mapped("Euler3DTransform", "0.1 -0.2 0.3 4 5 6", "10 20 30 1") - zyx).norm(), 1e-12);
  EXPECT_LT(
      (mapped("VersorRigid3DTransform",
              "0.06407134770607117 -0.09115754934299072 0.14357217502739192 4 5 6", "10 20 30") -
       zxy)
          .norm(),
      1e-12);
  EXPECT_LT(
      (mapped(
           "QuaternionRigidTransform",
           "0.06407134770607117 -0.09115754934299072 0.14357217502739192 0.9833474432563558 4 5 6",
           "10 20 30") -
       zxy)
          .norm(),
      1e-12);
}

TEST(ReadTransform, ComposesTheLastPartFirst) {
  const std::string text = std::string(kHead) +
                           "Transform: CompositeTransform_double_3_3\n#Transform 1\n"
                           "Transform: TranslationTransform_double_3_3\nParameters: 1 2 3\n"
                           "FixedParameters: \n#Transform 2\n"
                           "Transform: AffineTransform_double_3_3\n"
                           "Parameters: 0 -1 0 1 0 0 0 0 1 10 0 0\nFixedParameters: 0 0 0\n";
  // The rotation and its translation, then the other translation.
  EXPECT_LT((ReadText(text) * Eigen::Vector3d(1, 0, 0) - Eigen::Vector3d(11, 3, 3)).norm(), 1e-12);
}

TEST(ReadTransform, SaysWhatIsWrong) {
  const auto reading = [](const std::string& text) { return [text] { ReadText(text); }; };
  const std::string affine = std::string(kHead) + "Transform: AffineTransform_double_3_3\n";
  const std::string fixed = "FixedParameters: 0 0 0\n";
  EXPECT_THAT(reading(affine + "Parameters: 2 0 0 0 1 0 0 0 1 0 0 0\n" + fixed),
              ThrowsMessage<InputError>(HasSubstr("not a rigid transform")));
  EXPECT_THAT(reading(affine + "Parameters: -1 0 0 0 1 0 0 0 1 0 0 0\n" + fixed),
              ThrowsMessage<InputError>(HasSubstr("not a rigid transform")));
  EXPECT_THAT(
      reading(affine + "Parameters: 1 0 0 0 1 0 0 0 1 0 0 nan\n" + fixed),
      ThrowsMessage<InputError>(HasSubstr("transform.tfm:4: 'nan' is not a finite number")));
  EXPECT_THAT(reading(affine + "Parameters: 1 0 0 0 1 0 0 0 1 0 0 1e9\n" + fixed),
              ThrowsMessage<InputError>(HasSubstr("kilometre")));
  EXPECT_THAT(reading(affine + "Parameters: 1 0 0\n" + fixed),
              ThrowsMessage<InputError>(HasSubstr("needs 12 parameters, got 3")));
  EXPECT_THAT(reading(affine), ThrowsMessage<InputError>(HasSubstr("has no complete transform")));
  EXPECT_THAT(reading(affine + affine), ThrowsMessage<InputError>(HasSubstr("second transform")));
  EXPECT_THAT(
      reading(std::string(kHead) + "Transform: BSplineTransform_double_3_3\nParameters: 1\n" +
              fixed),
      ThrowsMessage<InputError>(HasSubstr("'BSplineTransform_double_3_3' is not read here")));
  EXPECT_THAT(reading("1 2 3"), ThrowsMessage<InputError>(HasSubstr("16 numbers")));
  EXPECT_THAT(reading(""), ThrowsMessage<InputError>(HasSubstr("16 numbers")));
}

TEST(ReadTransform, SurvivesBrokenFiles) {
  const auto path = TransformFileScratch() / "fuzz.tfm";
  WriteTransform(path, Oblique(), "ct_from_reference");
  const std::string valid = ReadTextFile(path);
  EXPECT_GT(testing_support::ReadDamagedCopies(valid, path, 600, [&] { ReadTransform(path); }),
            200);
}

}  // namespace
}  // namespace acus::transforms
