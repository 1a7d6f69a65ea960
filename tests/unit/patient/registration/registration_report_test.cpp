#include "acus/patient/registration/registration_report.h"

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "acus/base/config/json_file.h"
#include "acus/base/core/error.h"
#include "acus/base/core/random.h"
#include "acus/data/transforms/transform_file.h"
#include "support/temporary_folder.h"

namespace acus::registration {
namespace {

using Eigen::Vector3d;
using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::ThrowsMessage;

transforms::MarkerPairs Pairs(int count, double noise_mm) {
  RandomStream random(5, "report");
  transforms::MarkerPairs pairs;
  pairs.reference_mm.resize(3, count);
  for (double& x : pairs.reference_mm.reshaped()) x = random.Uniform(-90, 90);
  pairs.ct_mm = pairs.reference_mm;
  for (double& x : pairs.ct_mm.reshaped()) x += noise_mm * random.Normal();
  for (int i = 0; i < count; ++i) pairs.names.push_back("m" + std::to_string(i));
  return pairs;
}

transforms::Landmarks Target(const Vector3d& ct_mm) {
  return {"targets.csv", {"canal"}, ct_mm};
}

RegistrationSettings Fle(double fle_rms_mm) {
  RegistrationSettings settings;
  settings.fle_rms_mm = fle_rms_mm;
  return settings;
}

TEST(Register, ScalesTheTargetErrorWithTheGivenLocalisationError) {
  const transforms::MarkerPairs pairs = Pairs(6, 0.3);
  const auto one = Register(pairs, Target({10, 20, 30}), Fle(1.0));
  const auto two = Register(pairs, Target({10, 20, 30}), Fle(2.0));
  EXPECT_NEAR(two.targets[0].tre.rms_mm, 2 * one.targets[0].tre.rms_mm, 1e-12);
  const auto own = Register(pairs, Target({10, 20, 30}));
  EXPECT_NEAR(own.targets[0].tre.rms_mm, own.fle_rms_mm * one.targets[0].tre.rms_mm, 1e-12);
  EXPECT_GT(*one.fre_p_value, 0.9);
  const auto tight = Register(pairs, std::nullopt, Fle(0.05));
  EXPECT_LT(*tight.fre_p_value, 1e-6);
  EXPECT_THAT(tight.warnings, Contains(HasSubstr("larger than the given FLE explains")));
  EXPECT_THAT([&] { Register(pairs, std::nullopt, Fle(0.0)); },
              ThrowsMessage<InputError>(HasSubstr("above 0")));
}

TEST(Register, WarnsOfWhatMakesItWorse) {
  EXPECT_THAT(Register(Pairs(6, 0.3), std::nullopt).warnings, IsEmpty());
  EXPECT_THAT(Register(Pairs(3, 0.3), std::nullopt).warnings, Contains(HasSubstr("with 3 points")));
  transforms::MarkerPairs thin = Pairs(6, 0.0);
  thin.reference_mm.bottomRows<2>() *= 0.02;
  thin.ct_mm = thin.reference_mm;
  EXPECT_THAT(Register(thin, std::nullopt).warnings, Contains(HasSubstr("nearly on a line")));
  transforms::MarkerPairs wrong = Pairs(6, 0.3);
  wrong.ct_mm.col(4) += Vector3d(0, 8, 0);
  const auto report = Register(wrong, std::nullopt);
  EXPECT_THAT(report.warnings, Contains(HasSubstr("point 'm4' does not fit the others")));
  EXPECT_THAT(TableText(report), HasSubstr("m4"));
}

TEST(WriteResult, HoldsTheSameTransformTwice) {
  const testing_support::TemporaryFolder folder;
  transforms::MarkerPairs pairs = Pairs(5, 0.3);
  pairs.ct_mm.colwise() += Vector3d(100, -200, 300);
  const auto report = Register(pairs, Target({1, 2, 3}));
  WriteResult(folder.path(), report, RunContext{});
  const auto document = config::ReadJson(folder / "registration.json");
  const Eigen::Isometry3d read = transforms::ReadTransform(folder / "ct_from_reference.tfm");
  EXPECT_EQ(read.matrix(), report.fit.ct_from_reference.matrix());
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) {
      EXPECT_EQ(document["ct_from_reference"][i][j].get<double>(), read(i, j));
    }
  }
  // It takes the reference frame to CT, not back.
  const double distance_mm =
      (read * Vector3d(pairs.reference_mm.col(0)) - pairs.ct_mm.col(0)).norm();
  EXPECT_NEAR(document["points"][0]["residual_mm"].get<double>(), distance_mm, 1e-12);
  EXPECT_LT(distance_mm, 2.0);
  EXPECT_TRUE(document.contains("provenance"));
  const auto& back = document["targets"][0]["reference_mm"];
  const Vector3d reference_mm(back[0], back[1], back[2]);
  EXPECT_LT((read * reference_mm - Vector3d(1, 2, 3)).norm(), 1e-9);
}

}  // namespace
}  // namespace acus::registration
