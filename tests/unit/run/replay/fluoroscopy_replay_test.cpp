#include <gmock/gmock.h>

#include "acus/base/config/json_file.h"
#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "acus/data/session/sequence_file.h"
#include "acus/data/session/session_io.h"
#include "acus/data/volume/volume_io.h"
#include "acus/run/replay/replay.h"
#include "support/layered_scene.h"
#include "support/replay_folder.h"

namespace acus::replay {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;

/// A layered patient and an insertion of two seconds, without any probe.
class FluoroscopyReplay : public testing_support::ReplayFolder {
 protected:
  void SetUp() override {
    setenv("ACUS_CONFIGS", (fs::path(ACUS_SOURCE_DIR) / "configs").c_str(), 1);
    const auto scene =
        testing_support::LayeredScene(testing_support::PlanOf(true, true, true, true), true);
    volume::WriteCt(folder_ / "ct.nrrd", *scene.ct);
    volume::WriteLabelMap(folder_ / "labels.seg.nrrd", *scene.labels);
    session::Session session;
    session.name = "insertion";
    for (int ms = 0; ms < 2000; ++ms) {
      session::PoseSample needle{.time_ns = ms * std::int64_t{1'000'000}};
      needle.reference_from_tool =
          Eigen::Isometry3d(Eigen::Translation3d(0.0, 20.0, -5.0 + 0.02 * ms));
      session.needle.push_back(needle);
    }
    session::WriteSession(folder_ / "session", session, context_);
    WriteTextFile(folder_ / "scene.json", R"({"format": "acus-scenario/1", "name": "X-rays",
      "patient": {"ct": "ct.nrrd", "labels": "labels.seg.nrrd",
        "ct_from_reference": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]},
      "effects": {"fluoroscopy": {"rate_hz": 5, "lao_deg": 30}}})");
  }
};

TEST_F(FluoroscopyReplay, MakesImagesAtItsOwnRateWithoutAProbe) {
  Run("run", 2);
  const session::SequenceFile file(folder_ / "run/fluoroscopy.igs.mha");
  EXPECT_EQ(file.header().num_frames(), 10U);  // Two seconds at 5 Hz.
  EXPECT_TRUE(fs::exists(folder_ / "run/fluoroscopy.mp4"));
  EXPECT_FALSE(fs::exists(folder_ / "run/images.igs.mha"));
  EXPECT_EQ(config::ReadJson(folder_ / "run/run.json").at("fluoroscopy_images"), 10);
  const std::string report = ReadTextFile(folder_ / "run/report.html");
  EXPECT_THAT(report, AllOf(HasSubstr("fluoroscopy.mp4"), HasSubstr("Fluoroscopy at")));
}

TEST_F(FluoroscopyReplay, GivesTheSameBytesWithMoreThreads) {
  Run("one", 1);
  Run("two", 2);
  for (const char* name : {"fluoroscopy.igs.mha", "fluoroscopy.mp4"}) {
    EXPECT_EQ(ReadTextFile(folder_ / "one" / name), ReadTextFile(folder_ / "two" / name)) << name;
  }
}

TEST_F(FluoroscopyReplay, ShowsTheNeedleComing) {
  Run("with", 2);
  Run("without", 2, {scenario::ParseOverride("/effects/fluoroscopy/needle=false")});
  const session::SequenceFile with(folder_ / "with/fluoroscopy.igs.mha");
  const session::SequenceFile without(folder_ / "without/fluoroscopy.igs.mha");
  EXPECT_NE(ReadTextFile(folder_ / "with/fluoroscopy.igs.mha"),
            ReadTextFile(folder_ / "without/fluoroscopy.igs.mha"));
}

TEST_F(FluoroscopyReplay, WhenOffTheCTNeedNotBeThere) {
  fs::remove(folder_ / "ct.nrrd");
  const std::vector<scenario::Override> off = {
      scenario::ParseOverride("/effects/fluoroscopy=null"),
      scenario::ParseOverride("/effects/needle_force/model=layered"),
      scenario::ParseOverride("/patient/ct=null")};
  EXPECT_NO_THROW(Run("off", 1, off));
  EXPECT_FALSE(fs::exists(folder_ / "off/fluoroscopy.mp4"));
  EXPECT_THAT([&] { Run(nullptr, 1, {scenario::ParseOverride("/patient/ct=null")}); },
              ThrowsMessage<InputError>(AllOf(HasSubstr("fluoroscopy"), HasSubstr("/patient/ct"))));
}

TEST_F(FluoroscopyReplay, ACArmThatSeesNoPatientIsReported) {
  EXPECT_THAT(
      [&] {
        Run(nullptr, 1, {scenario::ParseOverride("/effects/fluoroscopy/isocentre_mm=[900,0,0]")});
      },
      ThrowsMessage<InputError>(HasSubstr("no ray meets the patient")));
  for (const char* bad :
       {"/effects/fluoroscopy/lao_deg=181", "/effects/fluoroscopy/lao_deg=-181",
        "/effects/fluoroscopy/cranial_deg=91", "/effects/fluoroscopy/rate_hz=0",
        "/effects/fluoroscopy/rate_hz=61", "/effects/fluoroscopy/isocentre_mm=[1,2]"}) {
    EXPECT_THROW(Run(nullptr, 1, {scenario::ParseOverride(bad)}), InputError) << bad;
  }
}

TEST_F(FluoroscopyReplay, ASceneOfSurfacesNeedsNoCT) {
  // The same block of tissue as in the CT, as a closed box: images, labels and forces without CT.
  WriteTextFile(folder_ / "box.obj",
                "v -60 -40 0\nv 60 -40 0\nv -60 80 0\nv 60 80 0\n"
                "v -60 -40 70\nv 60 -40 70\nv -60 80 70\nv 60 80 70\n"
                "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n");
  WriteTextFile(folder_ / "surfaces.json", R"({"format": "acus-surface-scene/1", "spacing_mm": 1,
    "surfaces": [{"file": "box.obj", "tissue": "muscle"}]})");
  const std::string surfaces = (folder_ / "surfaces.json").string();
  EXPECT_THAT([&] { Run(nullptr, 1, {scenario::ParseOverride("/patient/surfaces=" + surfaces)}); },
              ThrowsMessage<InputError>(HasSubstr("surfaces stand in place of ct and labels")));
  fs::remove(folder_ / "ct.nrrd");
  fs::remove(folder_ / "labels.seg.nrrd");
  Run("surfaces", 2,
      {scenario::ParseOverride("/patient/ct=null"), scenario::ParseOverride("/patient/labels=null"),
       scenario::ParseOverride("/effects/needle_force/model=layered"),
       scenario::ParseOverride("/patient/surfaces=" + surfaces)});
  EXPECT_TRUE(fs::exists(folder_ / "surfaces/fluoroscopy.mp4"));
  EXPECT_THAT(ReadTextFile(folder_ / "surfaces/forces.csv"), HasSubstr("muscle"));
}

}  // namespace
}  // namespace acus::replay
