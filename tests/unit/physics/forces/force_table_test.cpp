#include "acus/physics/forces/laws/force_table.h"

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "acus/base/core/error.h"
#include "acus/base/math/between_patients.h"
#include "layered_body.h"

namespace acus::forces {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;

json Minimal() {
  return json::parse(R"({"format": "acus-forces/1",
    "tissues": [{"tissue": "soft_tissue", "source": "test", "cutting_n": 0.5}]})");
}

TEST(ForceTable, TheTableOf2021HasTheLiverOfThePaper) {
  const ForceTable table = ReadForceTable(kConfigs / "forces" / "bovine_2021.json");
  const TissueForce& liver = table.tissue[volume::LabelOf("liver")];
  EXPECT_EQ(liver.membrane.a1_n_per_mm, 0.048);
  EXPECT_EQ(liver.membrane.a2_n_per_mm2, 0.0052);
  EXPECT_FALSE(table.HasTime());
}

TEST(ForceTable, DefaultHasALiverThatRelaxesAndStopsAtBone) {
  const ForceTable table = ReadForceTable(kConfigs / "forces" / "default.json");
  const TissueForce& liver = table.tissue[volume::LabelOf("liver")];
  EXPECT_LT(liver.time.relaxation.ElasticShare(), 0.3);
  EXPECT_GT(liver.withdrawal_tip_n, 0.0);
  EXPECT_TRUE(liver.no_membrane_from.test(volume::LabelOf("vessel")));
  EXPECT_FALSE(liver.no_membrane_from.test(volume::LabelOf("fat")));
  EXPECT_TRUE(table.tissue[volume::LabelOf("bone")].impenetrable);
  EXPECT_EQ(table.tissue[0].cutting_n, 0.0);  // Outside is free.
  for (const volume::StandardLabel& label : volume::StandardLabels()) {
    const TissueForce& row = table.tissue[label.label];
    if (row.membrane.puncture_n == 0.0) continue;
    EXPECT_LE(row.cutting_n, row.membrane.puncture_n) << label.name << ": a puncture must drop";
    EXPECT_LT(row.membrane.PunctureDepthMm(), 20.0) << label.name;
  }
}

TEST(ForceTable, TissuesWithoutARowAreSoftTissue) {
  const ForceTable table = ForceTableFromJson(Minimal(), "t");
  EXPECT_EQ(table.tissue[volume::LabelOf("liver")].cutting_n, 0.5);
  EXPECT_EQ(table.tissue[200].cutting_n, 0.5);
  EXPECT_FALSE(table.named.test(volume::LabelOf("liver")));
}

TEST(ForceTable, ScalesWithTheNeedle) {
  const ForceTable table = SimpleTable();
  const ForceTable thin = table.ScaledTo(0.635);
  const TissueForce& liver = table.tissue[volume::LabelOf("liver")];
  const TissueForce& thin_liver = thin.tissue[volume::LabelOf("liver")];
  EXPECT_DOUBLE_EQ(thin_liver.cutting_n, 0.5 * liver.cutting_n);
  EXPECT_DOUBLE_EQ(thin_liver.friction_n_per_mm, 0.5 * liver.friction_n_per_mm);
  EXPECT_NEAR(thin_liver.membrane.PunctureDepthMm(), liver.membrane.PunctureDepthMm(), 1e-12);
}

TEST(ForceTable, WithdrawalFrictionIsThatOfInsertionUnlessItIsGiven) {
  json document = Minimal();
  document["tissues"][0]["friction_n_per_mm"] = 0.016;
  const volume::Label soft = volume::LabelOf("soft_tissue");
  EXPECT_EQ(ForceTableFromJson(document, "t").tissue[soft].withdrawal_friction_n_per_mm, 0.016);
  document["tissues"][0]["withdrawal_friction_n_per_mm"] = 0.0105;
  const ForceTable table = ForceTableFromJson(document, "t");
  EXPECT_EQ(table.tissue[soft].friction_n_per_mm, 0.016);
  EXPECT_EQ(table.tissue[soft].withdrawal_friction_n_per_mm, 0.0105);
  const ForceTable thin = table.ScaledTo(0.5 * table.reference_diameter_mm);
  EXPECT_DOUBLE_EQ(thin.tissue[soft].withdrawal_friction_n_per_mm, 0.5 * 0.0105);
}

TEST(ForceTable, SaysWhatIsWrong) {
  const auto with = [](const char* pointer, const json& value) {
    json document = Minimal();
    document[json::json_pointer(pointer)] = value;
    return [document] { ForceTableFromJson(document, "t.json"); };
  };
  EXPECT_THAT(with("/tissues/0/tissue", "soft_tisue"),
              ThrowsMessage<InputError>(
                  AllOf(HasSubstr("t.json: /tissues/0"), HasSubstr("did you mean 'soft_tissue'"))));
  EXPECT_THAT(with("/tissues/0/tissue", "fat"), ThrowsMessage<InputError>(HasSubstr("no row for")));
  EXPECT_THAT(with("/tissues/0/tissue", "outside"),
              ThrowsMessage<InputError>(HasSubstr("free space")));
  EXPECT_THAT(with("/tissues/1", Minimal()["tissues"][0]),
              ThrowsMessage<InputError>(HasSubstr("has a row already")));
  EXPECT_THAT(with("/tissues/0/puncture_n", 2.0),
              ThrowsMessage<InputError>(HasSubstr("never reached")));
  EXPECT_THAT(with("/tissues/0/cutting_n", -1.0), ThrowsMessage<InputError>(HasSubstr("got -1")));
  EXPECT_THAT(with("/tissues/0/cutting_n", 101.0), ThrowsMessage<InputError>(HasSubstr("got 101")));
  EXPECT_THAT(with("/friction_buildup_mm", 0.0), ThrowsMessage<InputError>(HasSubstr("got 0")));
  EXPECT_THAT(with("/friction_buildup_mm", 11.0), ThrowsMessage<InputError>(HasSubstr("got 11")));
  EXPECT_THAT(with("/tissues/0/cutting_stiffness_n_per_mm", -2.0),
              ThrowsMessage<InputError>(HasSubstr("/tissues/0/cutting_stiffness_n_per_mm")));
  EXPECT_THAT(with("/bone/stiffness_n_per_mm", -5.0),
              ThrowsMessage<InputError>(HasSubstr("got -5")));
  EXPECT_THAT(with("/tissues/0/withdrawal_friction_n_per_mm", -0.01),
              ThrowsMessage<InputError>(HasSubstr("got -0.01")));
  EXPECT_THAT(with("/tissues/0/withdrawal_friction_n_per_mm", 5.1),
              ThrowsMessage<InputError>(HasSubstr("got 5.1")));
  const auto structure = [](const char* tissue, double from_hu) {
    return json::array({{{"tissue", tissue}, {"from_hu", from_hu}, {"a1_n_per_mm", 1.0}}});
  };
  EXPECT_THAT(with("/multi_proxy/structures", structure("bonne", 300.0)),
              ThrowsMessage<InputError>(AllOf(HasSubstr("/multi_proxy/structures/0/tissue"),
                                              HasSubstr("did you mean 'bone'"))));
  EXPECT_THAT(with("/multi_proxy/structures", structure("outside", 300.0)),
              ThrowsMessage<InputError>(HasSubstr("free space")));
  EXPECT_THAT(with("/multi_proxy/structures", structure("bone", -400.0)),
              ThrowsMessage<InputError>(HasSubstr("above the skin's -300 HU")));
  EXPECT_THAT(with("/multi_proxy/skin/a1_n_per_mm", -0.1),
              ThrowsMessage<InputError>(HasSubstr("got -0.1")));
  EXPECT_THAT(with("/multi_proxy/largest_force_n", 101.0),
              ThrowsMessage<InputError>(HasSubstr("got 101")));
  EXPECT_THAT(with("/tissues/0/no_membrane_from", json::array({"livr"})),
              ThrowsMessage<InputError>(HasSubstr("no_membrane_from")));
}

TEST(ReadNeedle, ReadsTheThreeNeedles) {
  for (const auto& [file, gauge, length_mm] :
       {std::tuple{"trocar_18g", 18, 150.0}, {"spinal_22g", 22, 90.0}, {"biopsy_16g", 16, 150.0}}) {
    const NeedleProperties needle =
        ReadNeedle(kConfigs / "needles" / (std::string(file) + ".json"));
    EXPECT_EQ(needle.gauge, gauge);
    EXPECT_EQ(needle.length_mm, length_mm);
    EXPECT_EQ(needle.beam.youngs_modulus_mpa, 193e3);
    EXPECT_GT(needle.beam.SecondMomentMm4(), 0.0);
  }
}

TEST(ForceTable, OfAPatientHasEachTissueByItsFactor) {
  const ForceTable table = ReadForceTable(kConfigs / "forces" / "default.json");
  EXPECT_TRUE(table.VariesBetweenPatients());
  EXPECT_FALSE(SimpleTable().VariesBetweenPatients());
  const ForceTable drawn = table.OfPatient(11);
  const auto factor = [](const char* tissue, double gsd) {
    return math::PatientFactor(gsd, 11, volume::LabelOf(tissue));
  };
  const auto ratio = [&](volume::Label label) {
    return drawn.tissue[label].cutting_n / table.tissue[label].cutting_n;
  };
  EXPECT_DOUBLE_EQ(ratio(volume::LabelOf("liver")), factor("liver", 1.18));
  EXPECT_DOUBLE_EQ(ratio(volume::LabelOf("muscle")), factor("muscle", 1.43));
  EXPECT_DOUBLE_EQ(ratio(200), factor("soft_tissue", 1.4));  // Without a row.
  const TissueForce& liver = drawn.tissue[volume::LabelOf("liver")];
  const TissueForce& median = table.tissue[volume::LabelOf("liver")];
  EXPECT_DOUBLE_EQ(liver.membrane.puncture_n, median.membrane.puncture_n * factor("liver", 1.18));
  EXPECT_NEAR(liver.membrane.PunctureDepthMm(), median.membrane.PunctureDepthMm(), 1e-9);
  EXPECT_EQ(liver.time.relaxation.ElasticShare(), median.time.relaxation.ElasticShare());
  EXPECT_DOUBLE_EQ(drawn.multi_proxy.skin.a1_n_per_mm,
                   table.multi_proxy.skin.a1_n_per_mm * factor("skin", 1.36));
  EXPECT_EQ(table.OfPatient(0).tissue[200].cutting_n, table.tissue[200].cutting_n);
}

}  // namespace
}  // namespace acus::forces
