#include "acus/scene/scenario/scenario.h"

#include <gmock/gmock.h>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "support/temporary_folder.h"

namespace acus::scenario {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;

/// A scenario folder with the files that the text names.
class ScenarioFile : public testing::Test {
 protected:
  void SetUp() override {
    for (const char* name : {"ct.nrrd", "needle.json", "probe.json", "table.json"}) {
      WriteTextFile(folder_ / name, "");
    }
  }
  Scenario Read(const std::string& text, const std::vector<Override>& overrides = {}) {
    WriteTextFile(folder_ / "scene.json", text);
    return ReadScenario(folder_ / "scene.json", overrides);
  }
  testing_support::TemporaryFolder temporary_;
  fs::path folder_ = temporary_.path();
};

constexpr const char* kText = R"({"format": "acus-scenario/1", "patient": {"ct": "ct.nrrd"},
  "needle": "needle.json", "probe": "probe.json",
  "effects": {"needle_force": {"table": "table.json"}, "ct_slice": {}}})";

TEST_F(ScenarioFile, HoldsOnlyTheEffectsItNamesWithDefaultsFilledIn) {
  const Scenario s = Read(kText);
  EXPECT_TRUE(s.needle_force.has_value());
  EXPECT_TRUE(s.ct_slice.has_value() && s.ct_slice->needle);
  EXPECT_FALSE(s.ultrasound.has_value());
  EXPECT_EQ(s.image_rate_hz, 30.0);
  EXPECT_EQ(s.patient.ct, folder_ / "ct.nrrd");
  EXPECT_TRUE(s.patient.ct_from_reference.isApprox(Eigen::Isometry3d::Identity()));
  EXPECT_EQ(s.session.reference_frame, "Reference");
}

TEST_F(ScenarioFile, TakesGuidanceWithAnyModelButTheOnesThatGuideThemselves) {
  EXPECT_EQ(Read(kText).needle_force->guidance, GuidanceKind::kOwn);
  EXPECT_EQ(Read(kText, {ParseOverride("/effects/needle_force/guidance=virtual_fixture")})
                .needle_force->guidance,
            GuidanceKind::kVirtualFixture);
  EXPECT_FALSE(Read(kText).needle_force->direct_method);
  EXPECT_TRUE(Read(kText, {ParseOverride("/effects/needle_force/model=alamilla"),
                           ParseOverride("/effects/needle_force/wall=direct")})
                  .needle_force->direct_method);
  EXPECT_THAT(
      [&] { Read(kText, {ParseOverride("/effects/needle_force/wall=direct")}); },
      ThrowsMessage<InputError>(HasSubstr("only the model alamilla has the direct method")));
  EXPECT_THAT([&] { Read(kText, {ParseOverride("/effects/needle_force/guidance=fixture")}); },
              ThrowsMessage<InputError>(AllOf(HasSubstr("/effects/needle_force/guidance"),
                                              HasSubstr("virtual_fixture"))));
  EXPECT_THAT(
      [&] {
        Read(kText, {ParseOverride("/effects/needle_force/guidance=none"),
                     ParseOverride(R"(/effects/needle={"model": "rigid"})")});
      },
      ThrowsMessage<InputError>(HasSubstr("effects/needle already computes")));
}

TEST_F(ScenarioFile, HoldsTheProbeForceOfItsModel) {
  const auto read = [this](const std::string& effect) {
    return Read(R"({"format": "acus-scenario/1", "patient": {},
      "effects": {"probe_force": )" +
                effect + "}}");
  };
  const Scenario vidal = read(R"({"table": "table.json", "multi_proxy": {"reads": "labels"}})");
  ASSERT_TRUE(vidal.probe_force.has_value());
  EXPECT_EQ(vidal.probe_force->model, ProbeForceModelKind::kVidal);
  EXPECT_FALSE(vidal.probe_force->reads_labels);  // The paper's reads the CT.
  const Scenario many = read(R"({"table": "table.json", "model": "multi_proxy",
    "multi_proxy": {"reads": "labels", "tool": "fingertip", "proxies": 9}})");
  EXPECT_EQ(many.probe_force->model, ProbeForceModelKind::kMultiProxy);
  EXPECT_TRUE(many.probe_force->reads_labels && many.probe_force->is_fingertip);
  EXPECT_EQ(many.probe_force->num_proxies, 9);
  EXPECT_EQ(many.probe_force->fingertip_radius_mm, 8.0);
  EXPECT_THAT([&] { read(R"({"table": "table.json", "model": "vidla"})"); },
              ThrowsMessage<InputError>(
                  AllOf(HasSubstr("/effects/probe_force/model"), HasSubstr("multi_proxy"))));
  for (const char* bad : {"0", "65", "2.5", "\"many\""}) {
    EXPECT_THROW(
        read(std::string(R"({"table": "table.json", "multi_proxy": {"proxies": )") + bad + "}}"),
        InputError)
        << bad;
  }
}

TEST_F(ScenarioFile, KnowsTheNeedlesShape) {
  EXPECT_FALSE(Read(kText).shape.has_value());
  const auto with = [&](const char* needle) {
    return Read(kText, {ParseOverride(std::string("/effects/needle=") + needle),
                        ParseOverride("/effects/needle/elasticity=table.json")});
  };
  const Scenario s = with(R"({"model": "bendable", "nodes": 50, "bevel": false})");
  ASSERT_TRUE(s.shape.has_value());
  EXPECT_EQ(s.shape->model, NeedleModelKind::kBendable);
  EXPECT_EQ(s.shape->nodes, 50);
  EXPECT_FALSE(s.shape->bevel);
  EXPECT_EQ(s.shape->path_spacing_mm, 1.0);
  EXPECT_EQ(s.shape->kappa_n_per_mm, 0.5);
  EXPECT_EQ(s.shape->hand_n_mm_per_rad, 500.0);
  EXPECT_TRUE(with(R"({"model": "lateral_beam", "axis_lock": true})").shape->axis_lock);
  EXPECT_THAT(
      [&] { with(R"({"model": "bendy"})"); },
      ThrowsMessage<InputError>(AllOf(HasSubstr("/effects/needle/model"), HasSubstr("bendable"))));
  EXPECT_THAT([&] { with(R"({"model": "bendable", "node": 50})"); },
              ThrowsMessage<InputError>(HasSubstr("node")));
  for (const char* bad :
       {R"({"model": "bendable", "nodes": 3})", R"({"model": "bendable", "nodes": 129})",
        R"({"model": "bendable", "path_spacing_mm": 0.1})",
        R"({"model": "bendable", "path_spacing_mm": 21})",
        R"({"model": "bendable", "hand": {"kappa_n_per_mm": 0}})",
        R"({"model": "bendable", "hand": {"stiffness_n_per_mm": 101}})",
        R"({"model": "bendable", "tip_stiffness_n_per_mm": -1})",
        R"({"model": "bendable", "influence_radius_mm": 0})"}) {
    EXPECT_THROW(with(bad), InputError) << bad;
  }
  EXPECT_THAT([&] { with(R"({"model": "bendable", "axis_lock": true})"); },
              ThrowsMessage<InputError>(AllOf(HasSubstr("axis_lock"), HasSubstr("lateral_beam"))));
  EXPECT_THAT(
      [&] {
        Read(kText, {ParseOverride("/effects/needle/model=rigid"),
                     ParseOverride("/effects/needle/elasticity=table.json"),
                     ParseOverride("/effects/needle_force=null")});
      },
      ThrowsMessage<InputError>(AllOf(HasSubstr("/effects/needle "), HasSubstr("needle_force"))));
}

TEST_F(ScenarioFile, TakesChangesFromTheCommandLine) {
  const Scenario s =
      Read(kText, {ParseOverride("/effects/ct_slice=null"),
                   ParseOverride("/effects/ultrasound/needle=false"),
                   ParseOverride("/effects/ultrasound/acoustics=table.json"),
                   ParseOverride("/session/face_px=[410,20]"), ParseOverride("/image_rate_hz=10"),
                   ParseOverride("/name=sweep 2")});
  EXPECT_FALSE(s.ct_slice.has_value());
  EXPECT_FALSE(s.ultrasound->needle);
  EXPECT_EQ(s.image_rate_hz, 10.0);
  EXPECT_EQ(s.session.face_px, Eigen::Vector2d(410, 20));
  EXPECT_EQ(s.name, "sweep 2");
  EXPECT_THAT([] { ParseOverride("image_rate_hz=10"); },
              ThrowsMessage<InputError>(HasSubstr("/json/pointer=value")));
  EXPECT_THAT([&] { Read(kText, {ParseOverride("/effects/ultrasond/needle=false")}); },
              ThrowsMessage<InputError>(HasSubstr("did you mean \"ultrasound\"")));
  EXPECT_THAT([&] { Read(kText, {ParseOverride("/needle/x=1")}); },
              ThrowsMessage<InputError>(HasSubstr("--set /needle/x")));
}

TEST_F(ScenarioFile, TakesTheModelOfTheUltrasoundWithItsOwnSettings) {
  const Scenario old = Read(kText, {ParseOverride("/effects/ultrasound/acoustics=table.json")});
  EXPECT_EQ(old.ultrasound->model, UltrasoundModel::kColumns2010);
  EXPECT_EQ(old.ultrasound->acoustics, folder_ / "table.json");
  const Scenario vidal =
      Read(kText, {ParseOverride("/effects/ultrasound/model=vidal_2008"),
                   ParseOverride("/effects/ultrasound/vidal_2008/acoustics=table.json")});
  EXPECT_EQ(vidal.ultrasound->model, UltrasoundModel::kVidal2008);
  EXPECT_EQ(vidal.ultrasound->acoustics, folder_ / "table.json");
  EXPECT_THAT([&] { Read(kText, {ParseOverride("/effects/ultrasound/model=vidal")}); },
              ThrowsMessage<InputError>(HasSubstr("vidal_2008")));
}

constexpr const char* kTissueText = R"({"format": "acus-scenario/1", "patient": {"mesh": "mesh"},
  "needle": "needle.json", "probe": "probe.json",
  "effects": {"needle_force": {"model": "tissue", "table": "table.json"},
              "tissue": {"model": "fe_3d", "elasticity": "table.json", "table": "table.json"}}})";

TEST_F(ScenarioFile, ReadsTheTissueEffectWithTheSettingsOfItsModel) {
  fs::create_directory(folder_ / "mesh");
  const Scenario s = Read(kTissueText, {ParseOverride("/effects/tissue/fe_3d/probe_contact=true")});
  ASSERT_TRUE(s.tissue.has_value());
  EXPECT_EQ(s.tissue->model, TissueModelKind::kFem3d);
  EXPECT_TRUE(s.tissue->TouchesNeedle());
  EXPECT_TRUE(s.tissue->probe_contact);
  EXPECT_TRUE(s.tissue->image);
  EXPECT_EQ(s.tissue->contact_spacing_mm, 2.0);
  EXPECT_FALSE(s.tissue->finite_strain);
  const Scenario strained =
      Read(kTissueText, {ParseOverride("/effects/tissue/fe_3d/law=finite_strain"),
                         ParseOverride("/effects/tissue/fe_3d/strain_nodes=90")});
  EXPECT_TRUE(strained.tissue->finite_strain);
  EXPECT_EQ(strained.tissue->strain_nodes, 90);
  EXPECT_EQ(strained.tissue->strain_iterations, 3);
  EXPECT_EQ(s.patient.mesh, folder_ / "mesh" / "mesh.vtu");
  EXPECT_EQ(s.needle_force->model, NeedleForceModelKind::kTissue);
  const Scenario springs =
      Read(kTissueText, {ParseOverride("/effects/tissue/model=springs"),
                         ParseOverride("/effects/tissue/springs/influence_radius_mm=7")});
  EXPECT_EQ(springs.tissue->influence_radius_mm, 7.0);
  EXPECT_FALSE(springs.tissue->printed_form);
  EXPECT_TRUE(
      Read(kTissueText, {ParseOverride("/effects/tissue/displacement_functions/form=printed")})
          .tissue->printed_form);
}

TEST_F(ScenarioFile, TakesTheFormsAsPrinted) {
  fs::create_directory(folder_ / "mesh");
  const auto plane = [this](const char* turned) {
    return Read(kTissueText,
                {ParseOverride("/effects/tissue/model=fe_2d"),
                 ParseOverride("/effects/tissue/fe_2d/update=full"), ParseOverride(turned)});
  };
  EXPECT_TRUE(plane("/effects/tissue/fe_2d/turned_planes=0").tissue->plane_full_update);
  EXPECT_FALSE(Read(kTissueText).tissue->plane_full_update);
  EXPECT_THAT([&] { plane("/effects/tissue/fe_2d/turned_planes=4"); },
              ThrowsMessage<InputError>(AllOf(HasSubstr("/effects/tissue/fe_2d/update"),
                                              HasSubstr("set turned_planes to 0"))));
  const auto needle = [this](const char* form) {
    return Read(kText, {ParseOverride(R"(/effects/needle={"model": "bendable"})"),
                        ParseOverride("/effects/needle/elasticity=table.json"),
                        ParseOverride(std::string("/effects/needle/hand/form=") + form)})
        .shape->hand_has_potential;
  };
  EXPECT_FALSE(needle("printed"));
  EXPECT_TRUE(needle("potential"));
  const auto image = [this](const char* model, const char* deformation) {
    return Read(kText,
                {ParseOverride(std::string("/effects/ultrasound/model=") + model),
                 ParseOverride("/effects/ultrasound/alamilla_2021/acoustics=table.json"),
                 ParseOverride("/effects/ultrasound/vidal_2008/acoustics=table.json"),
                 ParseOverride(std::string("/effects/ultrasound/alamilla_2021/deformation=") +
                               deformation)})
        .ultrasound->displaces_pixels;
  };
  EXPECT_TRUE(image("alamilla_2021", "pixels"));
  EXPECT_FALSE(image("alamilla_2021", "tissue"));
  EXPECT_FALSE(image("vidal_2008", "pixels"));
  const auto breath = [this](const std::string& more) {
    return Read(R"({"format": "acus-scenario/1", "patient": {"ct": "ct.nrrd"}, "effects": {
      "ct_slice": {}, "breathing": {"motion": "motion")" +
                more + "}}}")
        .breathing->adds_motion;
  };
  EXPECT_TRUE(breath(R"(, "tools": "printed")"));
  EXPECT_FALSE(breath(""));
}

TEST_F(ScenarioFile, FidelityOfImagesHasItsDefaultsAndItsBounds) {
  fs::create_directory(folder_ / "mesh");
  const auto with = [this](const char* change) {
    return Read(kTissueText,
                {ParseOverride("/effects/ultrasound/model=beams"), ParseOverride(change)});
  };
  const Scenario s = with("/effects/ultrasound/seed=7");
  EXPECT_EQ(s.tissue->inverse_iterations, 12);
  EXPECT_EQ(s.ultrasound->scan_lines, 0);  // As the probe preset says.
  EXPECT_EQ(s.ultrasound->samples_per_line, 0);
  EXPECT_EQ(s.ultrasound->seed, 7U);
  EXPECT_EQ(with("/effects/ultrasound/scan_lines=16").ultrasound->scan_lines, 16);
  EXPECT_EQ(with("/effects/ultrasound/samples_per_line=64").ultrasound->samples_per_line, 64);
  for (const char* bad :
       {"/effects/ultrasound/scan_lines=15", "/effects/ultrasound/scan_lines=4097",
        "/effects/ultrasound/samples_per_line=63", "/effects/ultrasound/samples_per_line=8193",
        "/effects/ultrasound/seed=-1", "/effects/tissue/inverse_iterations=0",
        "/effects/tissue/inverse_iterations=101"}) {
    EXPECT_THROW(with(bad), InputError) << bad;
  }
}

TEST_F(ScenarioFile, RefusesEffectsThatLeanOnOneThatIsNotThere) {
  fs::create_directory(folder_ / "mesh");
  EXPECT_THAT([&] { Read(kTissueText, {ParseOverride("/effects/tissue=null")}); },
              ThrowsMessage<InputError>(HasSubstr("springs, fe_2d or fe_3d")));
  EXPECT_THAT(
      [&] {
        Read(kTissueText, {ParseOverride("/effects/tissue/model=displacement_functions"),
                           ParseOverride("/effects/needle_force=null")});
      },
      ThrowsMessage<InputError>(HasSubstr("/effects/needle_force/model=layered")));
  EXPECT_THAT(
      [&] { Read(kTissueText, {ParseOverride("/effects/tissue/model=displacement_functions")}); },
      ThrowsMessage<InputError>(HasSubstr("computes forces")));
  EXPECT_THAT([&] { Read(kTissueText, {ParseOverride("/effects/tissue/warp_spacing_mm=0")}); },
              ThrowsMessage<InputError>(HasSubstr("/effects/tissue/warp_spacing_mm")));
  EXPECT_THAT([&] { Read(kTissueText, {ParseOverride("/effects/tissue/model=fe_4d")}); },
              ThrowsMessage<InputError>(HasSubstr("fe_3d")));
}

TEST_F(ScenarioFile, FilesOfThePatientNeedNotBeThereUntilAnEffectReadsThem) {
  const Scenario s =
      Read(R"({"format": "acus-scenario/1", "patient": {"ct": "no.nrrd", "mesh": "nowhere"},
               "needle": "needle.json", "probe": "probe.json", "effects": {"ct_slice": {}}})");
  EXPECT_EQ(s.patient.ct, folder_ / "no.nrrd");
  EXPECT_EQ(s.patient.mesh, folder_ / "nowhere");
}

TEST_F(ScenarioFile, SaysWhatIsWrongAndWhere) {
  EXPECT_THAT([&] { Read(R"({"format": "acus-scenario/1", "patient": {}, "effects": {}})"); },
              ThrowsMessage<InputError>(HasSubstr("/effects")));
  EXPECT_THAT([&] { Read(R"({"format": "acus-session/1"})"); },
              ThrowsMessage<InputError>(HasSubstr("must be \"acus-scenario/1\"")));
  EXPECT_THAT(
      [&] {
        Read(R"({"format": "acus-scenario/1", "effects": {"ct_slice": {}}, "patient":
                   {"ct_from_reference": [2,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]}})");
      },
      ThrowsMessage<InputError>(
          AllOf(HasSubstr("/patient/ct_from_reference"), HasSubstr("not rigid"))));
}

TEST_F(ScenarioFile, SaysWhetherTheBreathIsThatOfTheSession) {
  const auto breath = [this](const std::string& more) {
    return Read(R"({"format": "acus-scenario/1", "patient": {"ct": "ct.nrrd"}, "effects": {
      "ct_slice": {}, "breathing": {"motion": "motion")" +
                more + "}}}")
        .breathing->from_session;
  };
  EXPECT_EQ(breath(R"(, "from_session": "always")"), SessionBreath::kAlways);
  EXPECT_EQ(breath(R"(, "from_session": "never")"), SessionBreath::kNever);
  EXPECT_EQ(breath(R"(, "from_session": "if_recorded")"), breath(""));
  EXPECT_NE(breath(""), SessionBreath::kAlways);
  EXPECT_NE(breath(""), SessionBreath::kNever);
}

}  // namespace
}  // namespace acus::scenario
