// The settings of a data set of labelled images: configs/schema/acus-dataset.schema.json.
#pragma once

#include <array>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

namespace acus::dataset {

/// Lowest and highest value; equal: a constant.
struct ValueRange {
  double low = 0.0;
  double high = 0.0;
};

/// Paths are absolute; corridor, ct and labels may be empty: those of the scenario then apply.
struct DatasetPatient {
  std::string id;
  std::filesystem::path ct;
  std::filesystem::path labels;
  std::filesystem::path corridor;
  std::vector<std::filesystem::path> scenarios;  ///< At least one.
  std::filesystem::path exercise;
};

/// Names of the splits, in the order of DatasetConfig::split_shares.
inline constexpr std::array kSplitNames = {"train", "validation", "test"};

struct DatasetConfig {
  std::filesystem::path file;
  std::string name;
  std::vector<DatasetPatient> patients;
  std::vector<std::filesystem::path> trainees;
  std::vector<std::filesystem::path> probes;  ///< Empty: the scenario's; so for the next two.
  std::vector<std::filesystem::path> needles;
  std::vector<std::filesystem::path> displays;
  std::optional<ValueRange> gain_offset_db;
  std::optional<ValueRange> depth_mm;
  std::optional<ValueRange> frequency_mhz;
  std::optional<ValueRange> dynamic_range_db;
  int image_width_px = 256;
  int image_height_px = 256;
  int num_sequences = 0;
  int frames_per_sequence = 0;
  double inserted_share = 0.7;
  double step_rate_hz = 1000.0;
  std::array<double, 3> split_shares{};
};

/// Reads and checks the file: also that presets, scenarios and the patients' files exist, that
/// every probe is valid at both ends of the ranges, and that splits are possible.
/// @throws InputError listing or naming the problems.
DatasetConfig ReadDatasetConfig(const std::filesystem::path& path);

/// Changes of a probe preset. Empty values stay.
struct ProbeChange {
  double gain_offset_db = 0.0;
  std::optional<double> depth_mm;
  std::optional<double> frequency_mhz;
  std::optional<double> dynamic_range_db;
  int image_width_px = 256;
  int image_height_px = 256;
};

/// The preset (acus-probe JSON) with the change.
/// @throws InputError if the preset is not readable, or a value is out of the range of its schema.
nlohmann::json ChangedProbe(const std::filesystem::path& preset, const ProbeChange& change);

}  // namespace acus::dataset
