#include "acus/assess/dataset/dataset_config.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "acus/base/config/json_file.h"
#include "acus/base/core/error.h"
#include "acus/scene/scenario/scenario.h"

namespace acus::dataset {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

std::vector<fs::path> Presets(const json& names, const fs::path& folder) {
  std::vector<fs::path> found;
  for (const json& name : names) {
    found.push_back(config::FindConfig(name.get<std::string>(), folder));
  }
  return found;
}

std::optional<ValueRange> RangeAt(const json& ranges, const char* key, const std::string& file) {
  if (!ranges.contains(key)) return std::nullopt;
  const ValueRange range{ranges.at(key).at(0), ranges.at(key).at(1)};
  ACUS_REQUIRE(range.low <= range.high, file, ": /ranges/", key, ": [", range.low, ", ", range.high,
               "] is empty; give the lowest value first");
  return range;
}

/// The file of a key, else that in the patient's folder.
fs::path PatientFile(const json& node, const char* key, const char* in_folder,
                     const fs::path& beside, const std::string& where) {
  fs::path path;
  if (const std::string given = node.at(key); !given.empty()) {
    path = given;
  } else if (const std::string folder = node.at("folder"); !folder.empty()) {
    path = fs::path(folder) / in_folder;
  } else {
    return {};
  }
  path = fs::absolute(beside / path).lexically_normal();
  ACUS_REQUIRE(fs::exists(path), where, "/", key, ": ", path.string(),
               " is not there; make a patient with acus-phantom, or give another file");
  return path;
}

DatasetPatient PatientAt(const json& document, std::size_t n, const fs::path& file) {
  const json& node = document.at("patients").at(n);
  const fs::path beside = fs::absolute(file).parent_path();
  const std::string where = Message(file.string(), ": /patients/", n);
  DatasetPatient patient;
  patient.id = node.at("id");
  patient.ct = PatientFile(node, "ct", "ct.nrrd", beside, where);
  patient.labels = PatientFile(node, "labels", "labels.seg.nrrd", beside, where);
  patient.corridor = PatientFile(node, "corridor", "corridor_ct.csv", beside, where);
  const json& own = node.at("scenarios");
  patient.scenarios = Presets(own.empty() ? document.at("scenarios") : own, beside);
  const std::string exercise = node.at("exercise");
  patient.exercise = config::FindConfig(
      exercise.empty() ? document.at("exercise").get<std::string>() : exercise, beside);
  return patient;
}

void RequireOnce(const std::vector<DatasetPatient>& patients, const std::string& file) {
  std::set<std::string> ids;
  for (std::size_t n = 0; n < patients.size(); ++n) {
    ACUS_REQUIRE(ids.insert(patients[n].id).second, file, ": /patients/", n,
                 "/id: ", patients[n].id,
                 " is there twice; each patient has one id, or images of one "
                 "patient could be in two splits");
  }
}

void RequireSplits(const DatasetConfig& config) {
  const std::string file = config.file.string();
  double sum = 0.0;
  std::size_t used = 0;
  for (const double share : config.split_shares) {
    sum += share;
    if (share > 0.0) ++used;
  }
  ACUS_REQUIRE(std::abs(sum - 1.0) < 1e-6, file, ": /splits: the shares add up to ", sum,
               "; they must add up to 1");
  ACUS_REQUIRE(config.patients.size() >= used, file, ": /splits: ", used, " splits for ",
               config.patients.size(),
               " patients; each needs one of its own: add patients, or set "
               "a share to 0");
  ACUS_REQUIRE(config.num_sequences >= static_cast<int>(config.patients.size()), file,
               ": /sequences: ", config.num_sequences, " for ", config.patients.size(),
               " patients; give at least one for each");
}

/// The presets of the config, or those that its scenarios name.
std::set<fs::path> AllProbes(const DatasetConfig& config) {
  std::set<fs::path> probes(config.probes.begin(), config.probes.end());
  if (!probes.empty()) return probes;
  for (const DatasetPatient& patient : config.patients) {
    for (const fs::path& scenario : patient.scenarios) {
      probes.insert(scenario::ReadScenario(scenario, {}).probe);
    }
  }
  return probes;
}

double EndOf(const std::optional<ValueRange>& range, bool high, double otherwise) {
  if (!range) return otherwise;
  return high ? range->high : range->low;
}

std::optional<double> EndOf(const std::optional<ValueRange>& range, bool high) {
  if (!range) return std::nullopt;
  return high ? range->high : range->low;
}

void RequireProbes(const DatasetConfig& config) {
  for (const fs::path& preset : AllProbes(config)) {
    for (const bool high : {false, true}) {
      try {
        ChangedProbe(preset, {.gain_offset_db = EndOf(config.gain_offset_db, high, 0.0),
                              .depth_mm = EndOf(config.depth_mm, high),
                              .frequency_mhz = EndOf(config.frequency_mhz, high),
                              .dynamic_range_db = EndOf(config.dynamic_range_db, high),
                              .image_width_px = config.image_width_px,
                              .image_height_px = config.image_height_px});
      } catch (const InputError& error) {
        throw InputError(Message(config.file.string(), ": /ranges: the ",
                                 high ? "highest" : "lowest", " values do not suit the probe ",
                                 preset.filename().string(), ": ", error.what()));
      }
    }
  }
}

}  // namespace

json ChangedProbe(const fs::path& preset, const ProbeChange& change) {
  json document = config::ReadConfig(preset, "acus-probe");
  document["gain_db"] = document.at("gain_db").get<double>() + change.gain_offset_db;
  const auto set = [&document](const char* key, const std::optional<double>& value) {
    if (value) document[key] = *value;
  };
  set("depth_mm", change.depth_mm);
  set("frequency_mhz", change.frequency_mhz);
  set("dynamic_range_db", change.dynamic_range_db);
  document["image_width_px"] = change.image_width_px;
  document["image_height_px"] = change.image_height_px;
  return config::CheckedConfig(document, "acus-probe", preset.string());
}

DatasetConfig ReadDatasetConfig(const fs::path& path) {
  const json document = config::ReadConfig(path, "acus-dataset");
  const fs::path beside = fs::absolute(path).parent_path();
  DatasetConfig config;
  config.file = path;
  config.name = document.at("name");
  for (std::size_t n = 0; n < document.at("patients").size(); ++n) {
    config.patients.push_back(PatientAt(document, n, path));
  }
  config.trainees = Presets(document.at("trainees"), beside);
  config.probes = Presets(document.at("probes"), beside);
  config.needles = Presets(document.at("needles"), beside);
  config.displays = Presets(document.at("displays"), beside);
  const json& ranges = document.at("ranges");
  config.gain_offset_db = RangeAt(ranges, "gain_offset_db", path.string());
  config.depth_mm = RangeAt(ranges, "depth_mm", path.string());
  config.frequency_mhz = RangeAt(ranges, "frequency_mhz", path.string());
  config.dynamic_range_db = RangeAt(ranges, "dynamic_range_db", path.string());
  config.image_width_px = document.at("image_width_px");
  config.image_height_px = document.at("image_height_px");
  config.num_sequences = document.at("sequences");
  config.frames_per_sequence = document.at("frames_per_sequence");
  config.inserted_share = document.at("inserted_share");
  config.step_rate_hz = document.at("step_rate_hz");
  for (std::size_t n = 0; n < kSplitNames.size(); ++n) {
    config.split_shares[n] = document.at("splits").at(kSplitNames[n]);
  }
  RequireOnce(config.patients, path.string());
  RequireSplits(config);
  RequireProbes(config);
  return config;
}

}  // namespace acus::dataset
