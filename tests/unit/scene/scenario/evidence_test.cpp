#include "acus/scene/scenario/evidence.h"

#include <cmath>
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "acus/base/config/json_file.h"
#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "acus/scene/scenario/scenario.h"
#include "support/fuzz.h"
#include "support/temporary_folder.h"

namespace acus::scenario {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::HasSubstr;
using testing::ThrowsMessage;

Evidence Full() {
  Evidence evidence;
  evidence.asked = "--budget force=0.5ms,image=16ms";
  evidence.machine = "Some processor, 8 threads";
  evidence.acus_version = "1.2.3";
  evidence.session = "insertion";
  evidence.session_s = 20.0;
  evidence.settings_measured = 34;
  evidence.repetitions = 3;
  evidence.predicted = {};
  evidence.predicted.step_us_p999 = 61.5;
  evidence.predicted.image_ms_p95 = 14.0;
  evidence.measured = {
      .step_us_median = 12.5, .step_us_p999 = 60.25, .image_ms_median = 12.0, .image_ms_p95 = 13.5};
  evidence.force_rms_n = 0.0125;
  evidence.image_ssim = 1.0;
  evidence.stages = {{"tissue contact", "step", 0.75}, {"ultrasound", "image", 0.9}};
  return evidence;
}

class EvidenceFile : public testing::Test {
 protected:
  void SetUp() override {
    setenv("ACUS_CONFIGS", (fs::path(ACUS_SOURCE_DIR) / "configs").c_str(), 1);
  }
  json Document(const json& evidence) const {
    return {{"format", "acus-scenario/1"},
            {"patient", json::object()},
            {"effects", {{"needle_force", json::object()}}},
            {"evidence", evidence}};
  }
  Scenario Read(const json& evidence) const {
    config::WriteJson(file_, Document(evidence));
    return ReadScenario(file_, {});
  }
  testing_support::TemporaryFolder temporary_;
  fs::path file_ = temporary_.path() / "scenario.json";
};

TEST_F(EvidenceFile, ReadsBackAsWritten) {
  const Scenario scenario = Read(ToJson(Full()));
  ASSERT_TRUE(scenario.evidence.has_value());
  const Evidence& read = *scenario.evidence;
  EXPECT_EQ(ToJson(read), ToJson(Full()));
  EXPECT_EQ(read.asked, Full().asked);
  EXPECT_EQ(read.measured.step_us_p999, 60.25);
  EXPECT_TRUE(std::isnan(read.predicted.step_us_median));
  EXPECT_TRUE(std::isnan(read.image_psnr_db));
  EXPECT_EQ(read.stages[1].stage, "ultrasound");
  EXPECT_EQ(read.stages[0].share, 0.75);
}

TEST_F(EvidenceFile, IsOptionalAndSoIsWhatItHolds) {
  WriteTextFile(file_,
                R"({"format": "acus-scenario/1", "patient": {}, "effects": {"needle_force": {}}})");
  EXPECT_FALSE(ReadScenario(file_, {}).evidence.has_value());
  const Scenario scenario = Read(json::object());
  ASSERT_TRUE(scenario.evidence.has_value());
  EXPECT_EQ(scenario.evidence->settings_measured, 0);
  EXPECT_TRUE(std::isnan(scenario.evidence->measured.step_us_median));
}

TEST_F(EvidenceFile, WhatIsWrongIsSaid) {
  json evidence = ToJson(Full());
  evidence["measured"]["step_us_p99"] = 3.0;
  EXPECT_THAT([&] { Read(evidence); }, ThrowsMessage<InputError>(HasSubstr("step_us_p999")));
  evidence = ToJson(Full());
  evidence["measured"]["image_ms_p95"] = -1.0;
  EXPECT_THAT([&] { Read(evidence); },
              ThrowsMessage<InputError>(HasSubstr("/evidence/measured/image_ms_p95")));
  evidence = ToJson(Full());
  evidence["stages"][0]["share"] = 1.5;
  EXPECT_THAT([&] { Read(evidence); },
              ThrowsMessage<InputError>(HasSubstr("/evidence/stages/0/share")));
}

TEST_F(EvidenceFile, DamagedFilesAreReadOrRefused) {
  const std::string valid = Document(ToJson(Full())).dump(2);
  const int refused =
      testing_support::ReadDamagedCopies(valid, file_, 500, [this] { ReadScenario(file_, {}); });
  EXPECT_GT(refused, 200);
}

}  // namespace
}  // namespace acus::scenario
