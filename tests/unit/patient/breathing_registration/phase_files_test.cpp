#include "acus/patient/breathing_registration/phase_files.h"

#include <cmath>
#include <fstream>
#include <gmock/gmock.h>

#include "acus/base/core/atomic_file.h"
#include "acus/data/volume/volume_io.h"
#include "support/dicom_writer.h"
#include "support/temporary_folder.h"

namespace acus::breathing_registration {
namespace {

using testing_support::TemporaryFolder;

void Touch(const std::filesystem::path& path) {
  std::ofstream(path) << "x";
}

TEST(FindPhases, TakesVolumesInTheOrderOfTheirNumbers) {
  const TemporaryFolder folder;
  for (const char* name : {"p10.nrrd", "p0.nrrd", "p5.nrrd", "p15.nrrd"}) Touch(folder / name);
  const PhaseFiles files = FindPhases(folder.path(), {});
  ASSERT_EQ(files.phases.size(), 4);
  EXPECT_EQ(files.phases[1].name, "p5");
  EXPECT_EQ(files.phases[2].name, "p10");
  EXPECT_EQ(files.phases[2].breath.cycle, 0.5);
  // A regular breath: 1 at end inspiration, 0 at end expiration.
  EXPECT_NEAR(files.phases[0].breath.level, 1.0, 1e-9);
  EXPECT_NEAR(files.phases[2].breath.level, 0.0, 1e-9);
  EXPECT_LT(files.phases[1].breath.level_per_s, 0.0);
}

// A belt whose level is a cosine, from end inspiration, with a period of 4 s; in its own unit.
TEST(FindPhases, TakesLevelsAndRatesOfTheRecordedBreaths) {
  const TemporaryFolder folder;
  for (int n = 0; n < 10; ++n) Touch(folder / Message("p", n, ".nrrd"));
  breathing::BreathSignal signal{.start_s = 0.0, .step_s = 0.02, .level = {}};
  for (int n = 0; n <= 3000; ++n) signal.level.push_back(7.0 + std::cos(M_PI / 2.0 * 0.02 * n));
  const PhaseFiles files = FindPhases(folder.path(), signal);
  ASSERT_EQ(files.phases.size(), 10);
  for (int n = 0; n < 10; ++n) {
    const auto& breath = files.phases[static_cast<std::size_t>(n)].breath;
    const double angle_rad = 2.0 * M_PI * n / 10.0;
    EXPECT_EQ(breath.cycle, n / 10.0);
    EXPECT_NEAR(breath.level, 7.0 + std::cos(angle_rad), 0.04) << n;
    EXPECT_NEAR(breath.level_per_s, -M_PI / 2.0 * std::sin(angle_rad), 0.06) << n;
  }
}

TEST(FindPhases, SaysWhichIsMissing) {
  const TemporaryFolder folder;
  for (const char* name : {"p0.nrrd", "p1.nrrd", "p2.nrrd", "p4.nrrd"}) Touch(folder / name);
  EXPECT_THROW(FindPhases(folder.path(), {}), InputError);
  const TemporaryFolder empty;
  EXPECT_THROW(FindPhases(empty.path() / "none", {}), InputError);
}

TEST(FindPhases, GoesByItsTable) {
  const TemporaryFolder folder;
  for (const char* name : {"a.nrrd", "b.nrrd", "c.nrrd", "d.nrrd", "e.nrrd"}) Touch(folder / name);
  WriteTextFile(folder / "phases.csv",
                "file,use,cycle,level,level_per_s\na.nrrd,phase,0.5,0,0\nb.nrrd,phase,0.1,0.9,-1\n"
                "c.nrrd,phase,0.3,0.2,-1\nd.nrrd,phase,0.8,0.4,1\ne.nrrd,deeper,0,1.5,0\n");
  const PhaseFiles files = FindPhases(folder.path(), {});
  ASSERT_EQ(files.phases.size(), 4);
  EXPECT_EQ(files.phases[0].name, "b.nrrd");
  EXPECT_EQ(files.phases[2].breath.level, 0.0);
  ASSERT_TRUE(files.deeper);
  EXPECT_EQ(files.deeper->breath.level, 1.5);
  for (const char* row : {"a.nrrd,phase,1.5,0,0", "a.nrrd,what,0.5,0,0", "z.nrrd,phase,0.5,0,0"}) {
    WriteTextFile(folder / "phases.csv", Message("file,use,cycle,level,level_per_s\n", row, "\n"));
    EXPECT_THROW(FindPhases(folder.path(), {}), InputError) << row;
  }
}

TEST(FindPhases, ReportsDicomPhasesOfOneSeriesByTheirTime) {
  const TemporaryFolder folder;
  for (int phase = 0; phase < 4; ++phase) {
    for (int k = 0; k < 4; ++k) {
      testing_support::DicomSlice slice;
      slice.position_mm.z() = 2.0 * k;
      slice.temporal_position = phase + 1;
      slice.stored.assign(16 * 12, static_cast<std::int16_t>(100 * (phase + 1)));
      slice.stored.front() = 7;
      testing_support::WriteDicomSlice(folder / Message("s", 4 * k + phase, ".dcm"), slice);
    }
  }
  const PhaseFiles files = FindPhases(folder.path(), {});
  ASSERT_EQ(files.phases.size(), 4);
  for (int phase = 0; phase < 4; ++phase) {
    const auto ct = ReadPhase(files.phases[static_cast<std::size_t>(phase)], {});
    EXPECT_EQ(ct.geometry.size[2], 4);
    EXPECT_EQ(ct.At(3, 3, 2), 100 * (phase + 1));
  }
  std::filesystem::remove(folder / "s5.dcm");
  EXPECT_THROW(FindPhases(folder.path(), {}), InputError);
}

}  // namespace
}  // namespace acus::breathing_registration
