#include "acus/physics/mechanics/elements/elasticity_table.h"

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "acus/base/config/json_file.h"
#include "acus/base/core/error.h"
#include "acus/base/math/between_patients.h"

namespace acus::mechanics {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;

json Minimal() {
  return json::parse(R"({"format": "acus-elasticity/1",
    "tissues": [{"tissue": "fat", "source": "test", "youngs_modulus_kpa": 3}]})");
}

TEST(ElasticityTable, DefaultHasEverySoftTissueAndNoBone) {
  const ElasticityTable table = ReadElasticityTable(std::filesystem::path(ACUS_SOURCE_DIR) /
                                                    "configs" / "elasticity" / "default.json");
  for (const volume::StandardLabel& label : volume::StandardLabels()) {
    const bool is_soft = label.name != "outside" && label.name != "bone";
    EXPECT_EQ(table.named.test(label.label), is_soft) << label.name;
  }
  EXPECT_DOUBLE_EQ(table.At(volume::LabelOf("liver")).youngs_modulus_mpa, 0.0055);
  EXPECT_EQ(table.At(volume::LabelOf("liver")).poissons_ratio, 0.49);
}

TEST(ElasticityTable, EveryLawIsThatOfAPreset) {
  const auto folder = std::filesystem::path(ACUS_SOURCE_DIR) / "configs" / "elasticity";
  for (const auto& [file, kind] : {std::pair{"default.json", LawKind::kFung},
                                   {"yeoh.json", LawKind::kYeoh},
                                   {"neo_hookean.json", LawKind::kNeoHookean}}) {
    const ElasticityTable table = ReadElasticityTable(folder / file);
    for (const char* tissue : {"skin", "muscle", "liver"}) {
      EXPECT_EQ(table.law[volume::LabelOf(tissue)].kind, kind) << file << " " << tissue;
    }
  }
}

// A value is an estimate, or has a species and a test.
TEST(ElasticityTable, SourcesOfPresetsNameSpeciesAndTest) {
  const auto folder = std::filesystem::path(ACUS_SOURCE_DIR) / "configs" / "elasticity";
  for (const char* file : {"default.json", "viscoelastic.json", "yeoh.json", "neo_hookean.json"}) {
    const json document = config::ReadJson(folder / file);
    for (const json& row : document.at("tissues")) {
      const std::string source = row.at("source");
      EXPECT_TRUE(source.starts_with("estimate") || source.starts_with("human, ") ||
                  source.starts_with("pig, "))
          << file << ": " << row.at("tissue") << ": " << source;
    }
  }
}

TEST(ElasticityTable, ModuliFollowFromYoungAndPoisson) {
  const ElasticTissue tissue{.youngs_modulus_mpa = 0.012, .poissons_ratio = 0.2};
  EXPECT_DOUBLE_EQ(tissue.ShearModulusMpa(), 0.005);
  EXPECT_NEAR(tissue.BulkModulusMpa(), 0.012 / 1.8, 1e-17);
  EXPECT_EQ(ElasticityTableFromJson(Minimal(), "t").At(2).youngs_modulus_mpa, 0.003);
}

TEST(ElasticityTable, ATissueWithoutARowIsRefusedWithTheRemedy) {
  const ElasticityTable table = ElasticityTableFromJson(Minimal(), "t.json");
  EXPECT_THAT([&] { table.At(volume::LabelOf("liver")); },
              ThrowsMessage<InputError>(AllOf(HasSubstr("'liver' (label 8)"), HasSubstr("t.json"),
                                              HasSubstr("add a row"), HasSubstr("fixed_tissues"))));
  EXPECT_THAT([&] { table.At(200); },
              ThrowsMessage<InputError>(HasSubstr("label 200, which is no standard label")));
  EXPECT_THAT([&] { table.At(0); }, ThrowsMessage<InputError>(HasSubstr("mesh the label map")));
}

TEST(ElasticityTable, ReadsLawsAndRefusesWhatTheyCannotUse) {
  const auto with = [](const char* law) {
    json document = Minimal();
    document["tissues"][0]["law"] = json::parse(law);
    return ElasticityTableFromJson(document, "t.json").law[2];
  };
  EXPECT_EQ(ElasticityTableFromJson(Minimal(), "t").law[2], HyperelasticLaw{});
  EXPECT_EQ(with(R"({"model": "fung", "b": 2, "source": "s"})"),
            (HyperelasticLaw{LawKind::kFung, 0.0, 0.0, 2.0}));
  EXPECT_EQ(with(R"({"model": "yeoh", "c2_kpa": 1, "c3_kpa": 2, "source": "s"})"),
            (HyperelasticLaw{LawKind::kYeoh, 1e-3, 2e-3, 0.0}));
  EXPECT_EQ(with(R"({"model": "neo_hookean", "source": "s"})"), HyperelasticLaw{});
  const auto fails = [&](const char* law, const char* message) {
    EXPECT_THAT([&] { with(law); }, ThrowsMessage<InputError>(HasSubstr(message))) << law;
  };
  fails(R"({"model": "fung", "source": "s"})", "/tissues/0/law/b: missing");
  fails(R"({"model": "yeoh", "c2_kpa": 1, "source": "s"})", "/law/c3_kpa: missing");
  fails(R"({"model": "neo_hookean", "b": 1, "source": "s"})", "/law/b: belongs to the law fung");
  EXPECT_EQ(with(R"({"model": "knowles", "b": 30, "power": 0.6, "source": "s"})"),
            (HyperelasticLaw{.kind = LawKind::kKnowles, .exponent_b = 30.0, .power_n = 0.6}));
  EXPECT_EQ(with(R"({"model": "ogden", "exponents": [-20], "source": "s"})"),
            (HyperelasticLaw{.kind = LawKind::kOgden, .ogden = {{{1.0, -20.0}}}}));
  const HyperelasticLaw two = with(R"({"model": "ogden", "exponents": [-20, 8],
      "shares": [0.75, 0.25], "source": "s", "fibres": {"k1_kpa": 2, "direction": [0, 3, 4]}})");
  EXPECT_EQ(two.ogden[1], (OgdenTerm{0.25, 8.0}));
  EXPECT_EQ(two.fibres.k1_mpa, 2e-3);
  EXPECT_TRUE(two.fibres.direction_in_ct.isApprox(Eigen::Vector3d(0.0, 0.6, 0.8)));
  fails(R"({"model": "holzapfel", "source": "s"})", "/law/model");
  fails(R"({"model": "ogden", "source": "s"})", "/law/exponents: missing");
  fails(R"({"model": "ogden", "exponents": [4, 0.5], "shares": [0.5, 0.5], "source": "s"})",
        "/law/exponents/1: is 0.5");
  fails(R"({"model": "ogden", "exponents": [4, -4], "shares": [0.5, 0.6], "source": "s"})",
        "sum to 1.1");
  fails(R"({"model": "ogden", "exponents": [4, -4], "source": "s"})",
        "/law/shares: has 1 number, exponents has 2");
  fails(R"({"model": "knowles", "b": 30, "power": 0.4, "source": "s"})", "/law/power");
  fails(R"({"model": "fung", "b": 2, "source": "s",
            "fibres": {"k1_kpa": 2, "direction": [0, 0, 0]}})",
        "/fibres/direction: is zero");
  fails(R"({"model": "fung", "b": 2})", "source");
  fails(R"({"model": "yeoh", "c2_kpa": -2, "c3_kpa": 0.1, "source": "s"})", "would let go");
}

TEST(ElasticityTable, SaysWhatIsWrong) {
  const auto with = [](const char* pointer, const json& value) {
    json document = Minimal();
    document[json::json_pointer(pointer)] = value;
    return [document] { ElasticityTableFromJson(document, "t.json"); };
  };
  EXPECT_THAT(with("/tissues/0/tissue", "musle"),
              ThrowsMessage<InputError>(AllOf(HasSubstr("t.json: /tissues/0/tissue"),
                                              HasSubstr("did you mean 'muscle'"))));
  EXPECT_THAT(with("/tissues/0/tissue", "outside"),
              ThrowsMessage<InputError>(HasSubstr("free space")));
  EXPECT_THAT(with("/tissues/1", Minimal()["tissues"][0]),
              ThrowsMessage<InputError>(HasSubstr("has a row already")));
  for (const auto& [key, value] : {std::pair<const char*, double>{"youngs_modulus_kpa", 0.0},
                                   {"youngs_modulus_kpa", 2e8},
                                   {"poissons_ratio", -0.01},
                                   {"poissons_ratio", 0.5}}) {
    EXPECT_THAT(with((std::string("/tissues/0/") + key).c_str(), value),
                ThrowsMessage<InputError>(HasSubstr(key)))
        << value;
  }
  EXPECT_THAT(with("/tissues", json::array()), ThrowsMessage<InputError>(HasSubstr("/tissues")));
}

TEST(ElasticityTable, OfAPatientHasAllModuliOfATissueByOneFactor) {
  const ElasticityTable table = ElasticityTableFromJson(json::parse(R"({
    "format": "acus-elasticity/1", "tissues": [
      {"tissue": "muscle", "source": "test", "youngs_modulus_kpa": 12,
       "between_patients": {"gsd": 1.5, "source": "test"},
       "law": {"model": "yeoh", "source": "test", "c2_kpa": 2, "c3_kpa": 3,
               "fibres": {"k1_kpa": 4, "direction": [0, 0, 1]}},
       "membrane": {"source": "test", "youngs_modulus_kpa": 1000, "thickness_mm": 0.1,
                    "tension_n_per_m": 10, "solid_youngs_modulus_kpa": 5}},
      {"tissue": "fat", "source": "test", "youngs_modulus_kpa": 3}]})"),
                                                        "test");
  const ElasticityTable drawn = table.OfPatient(4);
  const volume::Label muscle = volume::LabelOf("muscle"), fat = volume::LabelOf("fat");
  const double factor = math::PatientFactor(1.5, 4, muscle);
  ASSERT_GT(std::abs(factor - 1.0), 0.01);
  EXPECT_DOUBLE_EQ(drawn.At(muscle).youngs_modulus_mpa, factor * 0.012);
  EXPECT_DOUBLE_EQ(drawn.SolidAt(muscle).youngs_modulus_mpa, factor * 0.005);
  EXPECT_DOUBLE_EQ(drawn.law[muscle].c2_mpa, factor * 0.002);
  EXPECT_DOUBLE_EQ(drawn.law[muscle].c3_mpa, factor * 0.003);
  EXPECT_DOUBLE_EQ(drawn.law[muscle].fibres.k1_mpa, factor * 0.004);
  EXPECT_DOUBLE_EQ(drawn.membranes.at(0).youngs_modulus_mpa, factor * 1.0);
  EXPECT_DOUBLE_EQ(drawn.membranes.at(0).tension_n_per_mm, factor * 0.01);
  EXPECT_EQ(drawn.At(muscle).poissons_ratio, table.At(muscle).poissons_ratio);
  EXPECT_EQ(drawn.At(fat).youngs_modulus_mpa, table.At(fat).youngs_modulus_mpa);
  EXPECT_EQ(table.OfPatient(0).At(muscle).youngs_modulus_mpa, 0.012);
  // The stress of the whole law is that of the median patient times the factor.
  const Eigen::Matrix3d stretched = Eigen::Vector3d(0.9, 1.0, 1.2).asDiagonal();
  const auto stress = [&](const ElasticityTable& t) -> Eigen::Matrix3d {
    return ShapeStressMpa(t.law[muscle], t.At(muscle).ShearModulusMpa(), stretched);
  };
  EXPECT_TRUE(stress(drawn).isApprox(factor * stress(table), 1e-12));
  EXPECT_TRUE(drawn.VariesBetweenPatients());
}

}  // namespace
}  // namespace acus::mechanics
