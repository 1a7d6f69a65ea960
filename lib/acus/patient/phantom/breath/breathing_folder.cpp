#include "acus/patient/phantom/breath/breathing_folder.h"

#include <fstream>
#include <iomanip>
#include <sstream>

#include "acus/base/config/json_file.h"
#include "acus/base/core/atomic_file.h"
#include "acus/base/core/csv.h"
#include "acus/data/volume/displacement_file.h"
#include "acus/data/volume/volume_io.h"
#include "acus/physics/breathing/breathing_pattern.h"

namespace acus::phantom {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;

struct Moment {
  std::string stem;
  const char* use;
  breathing::Breath breath;
};

std::vector<Moment> Moments(const BreathingFolderSettings& settings) {
  std::vector<Moment> moments;
  for (int n = 0; n < settings.num_phases; ++n) {
    std::ostringstream stem;
    stem << "phase_" << std::setw(2) << std::setfill('0') << n;
    moments.push_back({stem.str(), "phase", BreathOfPhase(n, settings)});
  }
  moments.push_back(
      {"deeper", "deeper", {.cycle = 0.0, .level = settings.deeper_level, .level_per_s = 0.0}});
  return moments;
}

void WriteTruth(const fs::path& path, const volume::Geometry& ct, const BreathingMotion& motion,
                const breathing::Breath& breath, double spacing_mm, int num_threads) {
  volume::DisplacementField field{.geometry = ct, .displacement_in_ct_mm = {}};
  volume::Geometry& g = field.geometry;
  const Eigen::Array3d extent_mm = ct.spacing_mm * (ct.size - 1).cast<double>();
  g.spacing_mm = Eigen::Array3d::Constant(spacing_mm);
  g.size = (extent_mm / spacing_mm).floor().cast<int>() + 1;
  field.displacement_in_ct_mm = DisplacementsOn(g, motion, breath, num_threads);
  volume::WriteDisplacementField(path, field);
}

void WritePhases(const fs::path& path, const std::vector<Moment>& moments) {
  std::string text = "file,use,cycle,level,level_per_s\n";
  for (const Moment& m : moments) {
    text += Message(m.stem, ".nrrd,", m.use, ",", NumberText(m.breath.cycle), ",",
                    NumberText(m.breath.level), ",", NumberText(m.breath.level_per_s), "\n");
  }
  WriteTextFile(path, text);
}

void WriteSignal(const fs::path& path, const BreathingFolderSettings& settings,
                 std::uint64_t seed) {
  const breathing::BreathingPattern pattern({.period_s = settings.motion.period_s,
                                             .exponent = 2,
                                             .period_spread = 0.08,
                                             .speed_spread = 0.1,
                                             .level_spread = 0.05,
                                             .level = 1.0,
                                             .seed = seed});
  std::ofstream out(path);
  CsvWriter csv(out, std::array<std::string_view, 2>{"time_s", "level"});
  const int count = static_cast<int>(25.0 * settings.signal_s);
  for (int n = 0; n <= count; ++n) {
    csv.Row(std::array<double, 2>{n / 25.0, pattern.At(n / 25.0).level});
  }
  ACUS_REQUIRE(out.good(), path.string(), ": cannot be written");
}

void WriteLandmarks(const fs::path& path, const std::vector<TissueLandmark>& landmarks,
                    const BreathingMotion& motion, const std::vector<Moment>& moments) {
  std::string text = "name,tissue,wall_mm,file,x_mm,y_mm,z_mm\n";
  for (const Moment& m : moments) {
    for (const TissueLandmark& landmark : landmarks) {
      const Vector3d p = motion.WorldMm(landmark.rest_mm, m.breath);
      text += Message(landmark.name, ",", landmark.tissue, ",", NumberText(landmark.wall_mm), ",",
                      m.stem, ".nrrd,", NumberText(p.x()), ",", NumberText(p.y()), ",",
                      NumberText(p.z()), "\n");
    }
  }
  WriteTextFile(path, text);
}

nlohmann::json TruthJson(const BreathingMotion& motion, const BreathingFolderSettings& settings,
                         std::uint64_t seed) {
  const Cavity& cavity = motion.cavity();
  return {{"format", "acus-breathing-truth/1"},
          {"seed", seed},
          {"diaphragm_mm", settings.motion.diaphragm_mm},
          {"chest_mm", settings.motion.chest_mm},
          {"hysteresis_mm", settings.motion.hysteresis_mm},
          {"period_s", settings.motion.period_s},
          {"noise_sd_hu", settings.noise_sd_hu},
          {"dome_z_mm", cavity.dome_z_mm},
          {"top_z_mm", cavity.top_z_mm},
          {"middle_x_mm", cavity.middle_x_mm},
          {"spine_front_mm", cavity.spine_front_mm},
          {"skin_front_mm", cavity.skin_front_mm}};
}

}  // namespace

breathing::Breath BreathOfPhase(int n, const BreathingFolderSettings& settings) {
  const breathing::BreathingPattern pattern({.period_s = settings.motion.period_s});
  const double cycle = static_cast<double>(n) / settings.num_phases;
  // One breath on: before time 0 breath is held.
  breathing::Breath breath = pattern.At((1.0 + cycle) * settings.motion.period_s);
  breath.cycle = cycle;
  return breath;
}

void WriteBreathingPatient(const fs::path& folder, const volume::CtVolume& ct,
                           const volume::LabelMap& labels, const BreathingFolderSettings& settings,
                           const RunContext& context) {
  ACUS_REQUIRE(labels.geometry.Matches(ct.geometry),
               "the label map lies on another grid than the CT; segment this CT");
  ACUS_REQUIRE(settings.num_phases >= 4 && settings.num_phases <= 60, "a 4D CT of ",
               settings.num_phases, " phases; 4 to 60 are possible");
  AtomicFolder out(folder, context.overwrite);
  const BreathingMotion motion(FindCavity(labels, context), settings.motion);
  const std::vector<Moment> moments = Moments(settings);
  fs::create_directory(out.path() / "truth");
  for (std::size_t n = 0; n < moments.size(); ++n) {
    const Moment& m = moments[n];
    context.Checkpoint("scanning " + m.stem,
                       static_cast<double>(n) / static_cast<double>(moments.size()));
    volume::WriteCt(out.path() / (m.stem + ".nrrd"),
                    ScanAt(ct, motion, m.breath,
                           {.noise_sd_hu = settings.noise_sd_hu, .noise_index = n}, context));
    WriteTruth(out.path() / "truth" / (m.stem + ".nrrd"), ct.geometry, motion, m.breath,
               settings.truth_spacing_mm, context.num_threads);
  }
  WritePhases(out.path() / "phases.csv", moments);
  WriteSignal(out.path() / "signal.csv", settings, context.seed);
  if (settings.num_landmarks > 0) {
    const auto landmarks =
        RandomLandmarks(labels, motion, moments.back().breath, settings.num_landmarks, context);
    WriteLandmarks(out.path() / "landmarks.csv", landmarks, motion, moments);
  }
  volume::WriteLabelMap(out.path() / "cavity.seg.nrrd", LabelsOf(motion.cavity()));
  config::WriteJson(out.path() / "motion_truth.json", TruthJson(motion, settings, context.seed));
  config::WriteJson(out.path() / "provenance.json", context.provenance.ToJson());
  out.Commit();
}

std::string BreathingFolderText(const BreathingFolderSettings& settings) {
  const BreathingSettings& motion = settings.motion;
  return Message("4D CT: ", settings.num_phases, " phases and a scan at ", settings.deeper_level,
                 " times the breath\nMotion: diaphragm ", motion.diaphragm_mm, " mm, chest ",
                 motion.chest_mm, " mm, hysteresis ", motion.hysteresis_mm, " mm, a breath in ",
                 motion.period_s, " s\nLandmarks: up to ", settings.num_landmarks,
                 " in lung and liver; fields of displacement in truth/\n");
}

}  // namespace acus::phantom
