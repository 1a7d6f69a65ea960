#include "acus/run/replay/patient_range.h"

#include <algorithm>
#include <gmock/gmock.h>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/csv.h"
#include "acus/base/core/error.h"
#include "acus/base/math/statistics.h"
#include "acus/data/session/session_io.h"
#include "support/layered_folder.h"
#include "support/replay_folder.h"

namespace acus::replay {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using testing::ThrowsMessage;

/// A layered patient and a needle that goes 45 mm in and out again.
class PatientRangeReplay : public testing_support::ReplayFolder {
 protected:
  void SetUp() override {
    testing_support::WriteLayeredFolder(folder_, R"({"needle_force": {}, "ultrasound": {}})", 10);
    session::Session session;
    session.name = "in and out";
    for (int n = 0; n < 400; ++n) {
      const double z_mm = n < 200 ? -5.0 + 0.25 * n : 45.0 - 0.25 * (n - 200);
      session::PoseSample needle{.time_ns = n * std::int64_t{10'000'000}};
      needle.reference_from_tool = Eigen::Isometry3d(Eigen::Translation3d(0.0, 20.0, z_mm));
      session.needle.push_back(needle);
      session.probe.push_back({needle.time_ns, Eigen::Isometry3d::Identity(), true});
    }
    session::WriteSession(folder_ / "session", session, context_);
  }

  /// Force along the needle at each step of a patient, N.
  std::vector<double> ForceOf(int seed) {
    const std::string run = Message("patient_", seed);
    Run(run.c_str(), 1, {{"/patient/stiffness/seed", seed}, {"/effects/ultrasound", nullptr}});
    return CsvTable(folder_ / run / "forces.csv").Numbers("force_axial_n");
  }
};

TEST_F(PatientRangeReplay, IsThatOfReplaysOfEachPatient) {
  Run("run", 1, {{"/patient/stiffness/others", 3}, {"/patient/stiffness/seed", 2}});
  const std::vector<std::vector<double>> others = {ForceOf(1), ForceOf(3), ForceOf(4)};
  const CsvTable range(folder_ / "run" / "other_patients_range.csv");
  const auto p5 = range.Numbers("force_axial_p5_n"), p95 = range.Numbers("force_axial_p95_n");
  const auto median = range.Numbers("force_axial_median_n");
  ASSERT_EQ(median.size(), others[0].size());
  for (std::size_t n = 0; n < median.size(); ++n) {
    const std::vector<double> force_n = {others[0][n], others[1][n], others[2][n]};
    EXPECT_NEAR(p5[n], math::Quantile(force_n, 0.05), 1e-5) << n;
    EXPECT_NEAR(median[n], math::Quantile(force_n, 0.5), 1e-5) << n;
    EXPECT_NEAR(p95[n], math::Quantile(force_n, 0.95), 1e-5) << n;
  }
  const CsvTable patients(folder_ / "run" / "other_patients.csv");
  EXPECT_EQ(patients.Numbers("seed"), (std::vector<double>{1, 3, 4}));
  const auto largest_n = patients.Numbers("largest_axial_force_n");
  for (std::size_t n = 0; n < others.size(); ++n) {
    double expected_n = 0.0;
    for (const double force_n : others[n]) expected_n = std::max(expected_n, std::abs(force_n));
    EXPECT_NEAR(largest_n[n], expected_n, 1e-5);
  }
  EXPECT_NE(largest_n[0], largest_n[1]);
  const std::string report = ReadTextFile(folder_ / "run" / "report.html");
  EXPECT_THAT(report, AllOf(HasSubstr("Other patients"), HasSubstr("5 to 95 % of the other")));
}

TEST_F(PatientRangeReplay, WithoutAPatientNothingIsDrawnOrWritten) {
  const auto force_n = ForceOf(0);
  Run("plain", 1, {{"/effects/ultrasound", nullptr}});
  EXPECT_EQ(CsvTable(folder_ / "plain" / "forces.csv").Numbers("force_axial_n"), force_n);
  EXPECT_NE(ForceOf(1), force_n);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "plain" / "other_patients.csv"));
  EXPECT_THAT(ReadTextFile(folder_ / "plain" / "report.html"), Not(HasSubstr("Other patients")));
}

TEST_F(PatientRangeReplay, TheOtherPatientsChangeNothingInTheRun) {
  Run("alone", 1);
  Run("among", 2, {{"/patient/stiffness/others", 2}});
  for (const char* file : {"forces.csv", "events.csv", "metrics.json", "images.igs.mha"}) {
    EXPECT_EQ(ReadTextFile(folder_ / "alone" / file), ReadTextFile(folder_ / "among" / file))
        << file;
  }
}

TEST_F(PatientRangeReplay, NeedsAForceAndNoComplianceOfOnePatient) {
  EXPECT_THAT(
      [&] {
        Run("x", 1, {{"/patient/stiffness/others", 2}, {"/effects/needle_force", nullptr}});
      },
      ThrowsMessage<InputError>(
          AllOf(HasSubstr("/patient/stiffness/others is 2"), HasSubstr("needle_force"))));
  EXPECT_THAT(
      [&] {
        Run("x", 1, {{"/patient/stiffness/others", 2}, {"/effects/tissue/model", "fe_3d"}});
      },
      ThrowsMessage<InputError>(HasSubstr("compliance")));
}

TEST_F(PatientRangeReplay, ATableThatDoesNotVaryIsNamed) {
  Run("other", 1,
      {{"/patient/stiffness/others", 2},
       {"/effects/needle_force/table", "forces/bovine_2021.json"},
       {"/effects/ultrasound", nullptr}});
  EXPECT_THAT(ReadTextFile(folder_ / "other" / "run.json"),
              AllOf(HasSubstr("bovine_2021.json: no row has between_patients")));
}

}  // namespace
}  // namespace acus::replay
