// What each sequence of a data set is: drawn by seed and number, before anything is simulated.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "acus/assess/dataset/dataset_config.h"

namespace acus::dataset {

/// One insertion by a virtual trainee, in one patient.
struct SequencePlan {
  int number = 0;
  std::size_t patient = 0;  ///< Place in DatasetConfig::patients.
  std::filesystem::path scenario;
  std::filesystem::path probe;  ///< Empty: that of the scenario; so the next two.
  std::filesystem::path needle;
  std::filesystem::path display;
  ProbeChange probe_change;
  std::filesystem::path trainee;
  std::uint64_t motion_seed = 0;
  std::uint64_t speckle_seed = 0;  ///< Below 2^32.

  /// "00017": its folder, and the code of its trainee.
  std::string Name() const;
};

/// For each patient the place of its split in kSplitNames. Patients are shuffled by the seed;
/// numbers follow the shares by largest remainders, at least one for each share above 0.
std::vector<std::size_t> SplitPatients(const DatasetConfig& config, std::uint64_t seed);

/// Sequence n depends on the config, the seed and n only. Patients take turns.
SequencePlan DrawSequence(const DatasetConfig& config, std::uint64_t seed, int number);

}  // namespace acus::dataset
