// The whole of acus-fit: recordings to a folder of results.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "acus/base/core/run_context.h"

namespace acus::fitting {

struct FitTask {
  std::vector<std::filesystem::path> inputs;  ///< Recordings.
  std::filesystem::path output;               ///< Folder to make.
  std::vector<std::string> models;            ///< As FitModels::FromNames, or "hyperelastic",
                                              ///< "modes" or "indentation" alone.
  std::string tissue;                         ///< Also a force table with this tissue; or empty.
  std::filesystem::path predict;              ///< A saved fit: predicts the inputs; or empty.
  double diameter_mm = 1.27;                  ///< Of the needle that was used.
  std::filesystem::path columns;  ///< Which columns are what (acus-force-columns/1); or empty.
  bool as_it_is = false;          ///< Forces that no needle takes are not refused.
};

/// Fits, or predicts, and writes the folder. A model that has no answer for a recording is reported
/// in a warning, in fit.json and in the table; the others are written.
/// @return the table for the terminal.
/// @throws InputError, and NoAnswerError if nothing at all has an answer: then nothing is written.
std::string RunFit(const FitTask& task, RunContext& context);

}  // namespace acus::fitting
