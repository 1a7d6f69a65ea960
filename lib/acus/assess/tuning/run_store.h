// The folder of a sweep: its plan and its finished runs, so that it can be stopped at any time and
// resumed, by several processes at once.
//
//   plan.json               the plan of the sweep: a folder belongs to one plan
//   runs/<case>.json        one file for each finished run, whole or not at all, with a check sum
//   references/<name>.bin   forces and images that runs are compared with
#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "acus/assess/tuning/measured.h"

namespace acus::tuning {

class RunStore {
 public:
  /// Makes the folder, or opens an existing one.
  /// @param plan       The identity of the sweep; compared as a whole.
  /// @param overwrite  The content of an earlier sweep is removed first.
  /// @throws InputError if the folder holds another plan (with the difference), runs of another
  ///     build of Acus (the plan's "build"), or something else.
  RunStore(std::filesystem::path folder, const nlohmann::json& plan, bool overwrite);

  const std::filesystem::path& folder() const { return folder_; }

  /// A finished run. Nothing if there is none, or if its file is damaged: it is then to be
  /// repeated.
  std::optional<Measured> Find(const std::string& case_name) const;

  /// Stores a finished run. Two processes may store the same one: one of the files stays.
  void Keep(const std::string& case_name, const Measured& measured) const;

  /// Removes a run, if it exists.
  void Forget(const std::string& case_name) const;

  /// Removes partial files of killed processes of this machine. To be called after all runs are
  /// complete: a process of another machine might still write.
  void Tidy() const;

  /// The file for the series of a reference.
  std::filesystem::path ReferenceFile(const std::string& reference_name) const;

 private:
  std::filesystem::path folder_;
};

/// The text of a run's file: one line of JSON, and its check sum.
std::string RunText(const Measured& measured);

/// Nothing if the text is damaged: cut, changed, or something else.
std::optional<Measured> RunFromText(const std::string& text);

}  // namespace acus::tuning
