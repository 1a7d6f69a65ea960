// A probe that PLUS recorded over a real patient.
#include <algorithm>
#include <gtest/gtest.h>

#include "acus/base/core/atomic_file.h"
#include "acus/base/math/rigid.h"
#include "acus/data/session/plus_config.h"
#include "acus/data/session/sequence_file.h"
#include "acus/data/session/session_import.h"
#include "acus/data/transforms/transform_file.h"
#include "acus/data/volume/volume_io.h"
#include "acus/run/replay/replay.h"
#include "support/shared_data.h"
#include "support/temporary_folder.h"

namespace acus::replay {
namespace {

namespace fs = std::filesystem;
using testing_support::SharedData;

/// Where a line along +y (from the front to the back of a patient) first meets the skin.
Eigen::Vector3d SkinFromTheFront(const volume::CtVolume& ct) {
  const Eigen::Array3i size = ct.geometry.size;
  for (int j = 0; j < size[1]; ++j) {
    if (ct.At(size[0] / 2, j, size[2] / 2) > -300) {
      return ct.geometry.ct_from_index() * Eigen::Vector3d(size[0] / 2, j, size[2] / 2);
    }
  }
  throw std::runtime_error("no body on the line");
}

TEST(ReplayOnRealData, PlusFreehandSweepOverAnAbdomen) {
  const auto ct_path = SharedData("ct/ircadb01_dicom");
  const auto session_path = SharedData("sessions/plus/SpinePhantomFreehand.igs.mha");
  const auto plus_config =
      SharedData("sessions/plus/PlusDeviceSet_Server_SimulatedUltrasound_3DSlicer.xml");
  if (!ct_path || !session_path || !plus_config)
    GTEST_SKIP() << "the public data sets are not here";

  const testing_support::TemporaryFolder temporary;
  const fs::path& folder = temporary.path();
  setenv("ACUS_CONFIGS", (fs::path(ACUS_SOURCE_DIR) / "configs").c_str(), 1);

  // The middle of the sweep is put on the skin, looking straight in.
  RunContext context;
  session::ImportOptions import;
  import.calibrations = session::ReadPlusCalibrations(*plus_config);
  import.probe_frames = {"Image"};
  import.face_px = Eigen::Vector2d(410, 0);
  const auto sweep = session::ReadPlusSession(*session_path, import, context).session.probe;
  ASSERT_EQ(sweep.size(), 21U);
  const volume::CtVolume ct = volume::ReadCt(*ct_path, "", context);
  Eigen::Isometry3d ct_from_probe = Eigen::Isometry3d::Identity();
  ct_from_probe.translation() = SkinFromTheFront(ct);
  const Eigen::Isometry3d ct_from_reference =
      ct_from_probe * sweep[10].reference_from_tool.inverse();
  transforms::WriteTransform(folder / "ct_from_reference.tfm", ct_from_reference, "");

  const auto scenario = scenario::ReadScenario(
      fs::path(ACUS_SOURCE_DIR) / "configs/scenarios/tracked_probe.json",
      std::vector<scenario::Override>{
          {"/patient/ct", ct_path->string()},
          {"/patient/ct_from_reference_file", (folder / "ct_from_reference.tfm").string()},
          {"/session/plus_config", plus_config->string()},
          {"/session/probe_frames", {"Image"}},
          {"/session/face_px", {410, 0}}});
  ReplayOptions options;
  options.run_folder = folder / "run";
  context.num_threads = 2;
  ReplaySession(scenario, *session_path, options, context);

  session::SequenceFile images(options.run_folder / "images.igs.mha");
  const double span_s = 1e-9 * static_cast<double>(sweep.back().time_ns - sweep.front().time_ns);
  EXPECT_EQ(images.num_frames(), static_cast<std::size_t>(span_s * 30.0) + 1);
  // Where the sweep lies on the skin there is an image; near its middle it must.
  const auto middle = images.ReadImage(images.num_frames() / 2);
  const auto bright = std::ranges::count_if(middle, [](std::uint8_t v) { return v > 20; });
  EXPECT_GT(static_cast<double>(bright), 0.05 * static_cast<double>(middle.size()));
  // The probe's poses are those of the recording.
  const auto written = session::ReadPlusSession(options.run_folder / "images.igs.mha", {}, context);
  const auto& first = written.session.probe.front().reference_from_tool;
  EXPECT_LT((first.translation() - sweep.front().reference_from_tool.translation()).norm(), 1e-6);
}

}  // namespace
}  // namespace acus::replay
