// The folder of a sweep: what is to be run, and what has been run, so that it can be stopped at any
// moment and taken up again, by several processes at once.
//
//   plan.json               what is swept, over what: a folder belongs to one plan
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
  /// Makes the folder, or takes up what is there.
  /// @param plan       What identifies the sweep; compared as a whole.
  /// @param overwrite  What an earlier sweep left is removed first.
  /// @throws InputError if the folder holds another plan (saying what differs), runs of another
  /// build of Acus (the plan's "build"), or something else.
  RunStore(std::filesystem::path folder, const nlohmann::json& plan, bool overwrite);

  const std::filesystem::path& folder() const { return folder_; }

  /// A finished run. Nothing if there is none, or if its file is damaged: then it is to be run
  /// again.
  std::optional<Measured> Find(const std::string& case_name) const;

  /// Keeps a finished run. Two processes may keep the same one: one of the files stays.
  void Keep(const std::string& case_name, const Measured& measured) const;

  /// Removes a run, if it is there.
  void Forget(const std::string& case_name) const;

  /// Removes what processes of this machine that were killed left half written. To be called when
  /// all is there: another machine's process might still be writing.
  void Tidy() const;

  /// Where the series of a reference is or will be.
  std::filesystem::path ReferenceFile(const std::string& reference_name) const;

 private:
  std::filesystem::path folder_;
};

/// The text of a run's file: one line of JSON, and its check sum.
std::string RunText(const Measured& measured);

/// Nothing if the text is damaged: cut, changed, or something else.
std::optional<Measured> RunFromText(const std::string& text);

}  // namespace acus::tuning
