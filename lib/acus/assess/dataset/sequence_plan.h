// The plan of each sequence of a data set: drawn by seed and number, before any simulation.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "acus/assess/dataset/dataset_config.h"

namespace acus::dataset {

/// One insertion by a virtual trainee, in one patient.
struct SequencePlan {
  int number = 0;
  std::size_t patient = 0;  ///< Index in DatasetConfig::patients.
  std::filesystem::path scenario;
  std::filesystem::path probe;  ///< Empty: the scenario's; so for the next two.
  std::filesystem::path needle;
  std::filesystem::path display;
  ProbeChange probe_change;
  std::filesystem::path trainee;
  std::uint64_t motion_seed = 0;
  std::uint64_t speckle_seed = 0;  ///< Below 2^32.

  /// "00017": its folder, and the code of its trainee.
  std::string Name() const;
};

/// For each patient the index of its split in kSplitNames. Patients are shuffled by the seed;
/// numbers follow the shares by largest remainders, at least one for each share above 0.
std::vector<std::size_t> SplitPatients(const DatasetConfig& config, std::uint64_t seed);

/// Sequence n depends on the config, the seed and n only. Patients alternate.
SequencePlan DrawSequence(const DatasetConfig& config, std::uint64_t seed, int number);

}  // namespace acus::dataset
