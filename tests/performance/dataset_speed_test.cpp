// A thousand labelled frames of 256 x 256 pixels take at most a minute on two cores.
#include <cstdio>
#include <gtest/gtest.h>

#include "acus/assess/dataset/dataset.h"
#include "acus/base/core/atomic_file.h"
#include "acus/base/core/cpu_time.h"
#include "support/layered_folder.h"
#include "support/temporary_folder.h"

namespace acus::dataset {
namespace {

TEST(DatasetSpeed, AThousandFramesTakeAMinuteOnTwoCores) {
  const testing_support::TemporaryFolder temporary;
  const std::filesystem::path folder = temporary.path();
  testing_support::WriteLayeredFolder(
      folder, R"({"needle_force": {}, "ultrasound": {"model": "beams"}})", 10);
  WriteTextFile(folder / "corridor.csv", "name,x_mm,y_mm,z_mm\nentry,3,-5,0\ntarget,3,5,25\n");
  WriteTextFile(folder / "exercise.json",
                R"({"format": "acus-exercise/1", "name": "Layers", "goals": []})");
  WriteTextFile(folder / "dataset.json", R"({
    "format": "acus-dataset/1", "patients": [{"id": "a", "corridor": "corridor.csv"}],
    "scenarios": ["scene.json"], "exercise": "exercise.json",
    "probes": ["probes/curvilinear_c5_2.json", "probes/linear_l14.json"],
    "sequences": 4, "frames_per_sequence": 25,
    "splits": {"train": 1, "validation": 0, "test": 0}})");
  const DatasetConfig config = ReadDatasetConfig(folder / "dataset.json");
  RunContext context;
  const double begin_s = ProcessCpuSeconds();
  WriteDataset(config, replay::LabelFormat::kPng, folder / "made", context);
  const double cpu_s = 10.0 * (ProcessCpuSeconds() - begin_s);
  std::printf("1000 labelled frames: %.1f s of CPU time\n", cpu_s);
  EXPECT_LT(cpu_s, 2.0 * 60.0);
  EXPECT_TRUE(std::filesystem::exists(folder / "made/sequences/00003/labels/00024.png"));
}

}  // namespace
}  // namespace acus::dataset
