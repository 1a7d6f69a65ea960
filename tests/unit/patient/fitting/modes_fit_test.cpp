#include "acus/patient/fitting/modes_fit.h"

#include <cmath>
#include <fstream>
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "acus/base/core/error.h"
#include "acus/base/core/random.h"
#include "acus/physics/mechanics/elements/elasticity_table.h"
#include "support/temporary_folder.h"

namespace acus::fitting {
namespace {

using SolidLaw = mechanics::HyperelasticLaw;
using mechanics::LawKind;
using testing::HasSubstr;
using testing::ThrowsMessage;

constexpr double kMuMpa = 0.004;

/// Ogden's closed forms (Ogden 1972): independent of the law's code.
double OgdenStress(double exponent, LoadMode mode, double amount) {
  if (mode != LoadMode::kShear) {
    return 2.0 * kMuMpa / exponent *
           (std::pow(amount, exponent - 1.0) - std::pow(amount, -0.5 * exponent - 1.0));
  }
  const double stretch = 0.5 * amount + std::sqrt(1.0 + 0.25 * amount * amount);
  return 2.0 * kMuMpa / exponent * (std::pow(stretch, exponent) - std::pow(stretch, -exponent)) /
         (stretch + 1.0 / stretch);
}

/// Stretches from 0.85 to 1.15 and shears from -0.3 to 0.3.
template <typename Stress>
ModesTest Specimen(const Stress& stress, double noise_share = 0.0) {
  ModesTest test{.name = "specimen", .mode = {}, .amount = {}, .stress_mpa = {}};
  RandomStream noise(5, "modes");
  const auto add = [&](LoadMode mode, double amount) {
    test.mode.push_back(mode);
    test.amount.push_back(amount);
    test.stress_mpa.push_back(stress(mode, amount) + noise_share * kMuMpa * noise.Normal());
  };
  for (int i = 1; i <= 15; ++i) {
    add(LoadMode::kTension, 1.0 + 0.01 * i);
    add(LoadMode::kCompression, 1.0 - 0.01 * i);
    add(LoadMode::kShear, 0.02 * i);
    add(LoadMode::kShear, -0.02 * i);
  }
  return test;
}

const ModesLawFit& Named(const ModesFit& fit, const char* name) {
  const auto found = std::ranges::find(fit.laws, name, &ModesLawFit::name);
  EXPECT_NE(found, fit.laws.end()) << name;
  return *found;
}

TEST(ModeStress, IsTheClosedForm) {
  for (const double exponent : {-18.0, -4.0, 2.0, 9.0}) {
    const SolidLaw law{.kind = LawKind::kOgden, .ogden = {{{1.0, exponent}}}};
    for (const double amount : {0.8, 0.95, 1.0, 1.1, 1.25}) {
      const LoadMode mode = amount < 1.0 ? LoadMode::kCompression : LoadMode::kTension;
      const double want = OgdenStress(exponent, mode, amount);
      EXPECT_NEAR(ModeStressMpa(law, kMuMpa, mode, amount), want,
                  1e-12 * (kMuMpa + std::abs(want)));
    }
    for (const double amount : {-0.4, -0.1, 0.0, 0.2, 0.5}) {
      const double want = OgdenStress(exponent, LoadMode::kShear, amount);
      EXPECT_NEAR(ModeStressMpa(law, kMuMpa, LoadMode::kShear, amount), want,
                  1e-12 * (kMuMpa + std::abs(want)));
    }
  }
}

TEST(ModeStress, OfFibresIsThatOfStretchedOnes) {
  const SolidLaw law{.kind = LawKind::kNeoHookean, .fibres = {0.01, 0.5}};
  const auto fibre = [](double square) {
    return 0.01 * (square - 1.0) * std::exp(0.5 * std::pow(square - 1.0, 2));
  };
  // Along z: 2 stretch dW/dI4; compressed ones are slack.
  EXPECT_NEAR(ModeStressMpa(law, kMuMpa, LoadMode::kTension, 1.2),
              kMuMpa * (1.2 - 1.0 / 1.44) + 2.0 * 1.2 * fibre(1.44), 1e-15);
  EXPECT_NEAR(ModeStressMpa(law, kMuMpa, LoadMode::kCompression, 0.8), kMuMpa * (0.8 - 1.0 / 0.64),
              1e-15);
  // Sheared across, they turn and stretch: I4 = 1 + amount^2.
  EXPECT_NEAR(ModeStressMpa(law, kMuMpa, LoadMode::kShear, 0.5),
              0.5 * kMuMpa + 2.0 * 0.5 * fibre(1.25), 1e-15);
}

TEST(ModesFit, FindsALawThatOnlyPrincipalStretchesDescribe) {
  const ModesTest test =
      Specimen([](LoadMode mode, double amount) { return OgdenStress(-18.0, mode, amount); }, 0.01);
  const ModesFit fit = FitModes(test);
  ASSERT_TRUE(fit.converged) << fit.message;
  const ModesLawFit& law = Named(fit, "ogden, 1 exponent");
  ASSERT_TRUE(law.converged) << law.message;
  EXPECT_NEAR(law.law.ogden[0].exponent, -18.0, 0.5);
  EXPECT_NEAR(law.shear_modulus_mpa, kMuMpa, 0.02 * kMuMpa);
  EXPECT_TRUE(law.parameters[1].Contains(-18.0));
  EXPECT_LT(law.relative_rms, 0.03);
  // Laws of the first invariant cannot have compression and tension right at once.
  for (const char* other : {"neo_hookean", "yeoh", "fung", "knowles"}) {
    EXPECT_GT(Named(fit, other).relative_rms, 0.15) << other;
  }
}

TEST(ModesFit, FindsFibresAndSoftening) {
  // Written out: the law of Knowles, and fibres that are slack under compression.
  const ModesTest test = Specimen([](LoadMode mode, double amount) {
    const double x =
        mode == LoadMode::kShear ? amount * amount : amount * amount + 2.0 / amount - 3.0;
    const double slope = 0.5 * kMuMpa * std::pow(1.0 + 30.0 / 0.6 * x, 0.6 - 1.0);
    const double square = mode == LoadMode::kShear ? 1.0 + amount * amount : amount * amount;
    const double fibre = 0.003 * std::max(0.0, square - 1.0);
    if (mode == LoadMode::kShear) return 2.0 * amount * (slope + fibre);
    return 2.0 * (amount - 1.0 / (amount * amount)) * slope + 2.0 * amount * fibre;
  });
  const ModesFit fit = FitModes(test);
  const ModesLawFit& law = Named(fit, "knowles with fibres");
  ASSERT_TRUE(law.converged) << law.message;
  EXPECT_LT(law.relative_rms, 0.005);
  EXPECT_NEAR(law.law.fibres.k1_mpa, 0.003, 2e-4);
  EXPECT_EQ(fit.laws[*fit.best].name, "knowles with fibres");
}

TEST(ModesFit, ItsRowIsAnElasticityTableOfTheSameLaw) {
  const ModesTest test = Specimen([](LoadMode mode, double amount) {
    return OgdenStress(-9.0, mode, amount) + 0.2 * OgdenStress(12.0, mode, amount);
  });
  const ModesFit fit = FitModes(test);
  const nlohmann::json document = ModesJson(test, fit);
  int checked = 0;
  for (std::size_t k = 0; k < fit.laws.size(); ++k) {
    if (!fit.laws[k].converged) continue;
    nlohmann::json row = document["laws"][k]["elasticity_row"];
    row["tissue"] = "muscle";
    row["source"] = "test";
    const auto table = mechanics::ElasticityTableFromJson(
        {{"format", "acus-elasticity/1"}, {"tissues", {row}}}, "fit.json");
    const auto label = volume::LabelOf("muscle");
    EXPECT_EQ(table.law[label].kind, fit.laws[k].law.kind);
    const double mu = table.tissue[label].ShearModulusMpa();
    for (const double amount : {0.9, 1.12}) {
      const LoadMode mode = amount < 1.0 ? LoadMode::kCompression : LoadMode::kTension;
      const double want =
          ModeStressMpa(fit.laws[k].law, fit.laws[k].shear_modulus_mpa, mode, amount);
      EXPECT_NEAR(ModeStressMpa(table.law[label], mu, mode, amount), want, 1e-9 * std::abs(want))
          << fit.laws[k].name;
    }
    ++checked;
  }
  EXPECT_GE(checked, 10);
}

class ModesFile : public testing::Test {
 protected:
  std::filesystem::path Write(const std::string& text) {
    std::ofstream(folder_ / "a.csv") << text;
    return folder_ / "a.csv";
  }
  static std::string Rows(const char* mode, double from, double step, int count) {
    std::string text;
    for (int i = 0; i < count; ++i) text += Message(mode, ",", from + step * i, ",", i, "\n");
    return text;
  }
  testing_support::TemporaryFolder folder_;
};

TEST_F(ModesFile, IsReadInAnyUnitOfItsHeader) {
  const std::string rows = Rows("axial", 0.91, 0.02, 10) + Rows("shear", -0.1, 0.05, 6);
  const ModesTest kpa = ReadModesTest(Write("mode,stretch_or_shear,stress_kpa\n" + rows));
  const ModesTest pa = ReadModesTest(Write("mode,stretch_or_shear,stress_pa\n" + rows));
  EXPECT_EQ(kpa.CountOf(LoadMode::kCompression), 5u);
  EXPECT_EQ(kpa.CountOf(LoadMode::kTension), 5u);
  EXPECT_EQ(kpa.CountOf(LoadMode::kShear), 6u);
  EXPECT_DOUBLE_EQ(kpa.stress_mpa[3], 3e-3);
  EXPECT_DOUBLE_EQ(pa.stress_mpa[3], 3e-6);
}

TEST_F(ModesFile, SaysWhatIsWrong) {
  const auto fails = [&](const std::string& rows, const char* why) {
    const auto path = Write("mode,stretch_or_shear,stress_kpa\n" + rows);
    EXPECT_THAT([&] { ReadModesTest(path); }, ThrowsMessage<InputError>(HasSubstr(why)));
  };
  const std::string shear = Rows("shear", -0.1, 0.05, 6);
  fails(Rows("axial", 1.0, 0.01, 20), "a single mode");
  fails(shear + "axial,1.1,2\n", "7 rows; at least 12");
  fails(Rows("axial", 0.0, 0.01, 12) + shear, "a.csv:2: a stretch of 0; 0.2 to 5 is allowed");
  fails(Rows("axial", 0.9, 0.02, 12) + "shear,20,1\n", "Is it in percent?");
  fails(Rows("torsion", 0.9, 0.02, 12) + shear, "a.csv:2: mode is 'torsion'");
  fails(Rows("compression", 1.01, 0.02, 12) + shear, "a stretch of 1.01 is tension");
}

}  // namespace
}  // namespace acus::fitting
