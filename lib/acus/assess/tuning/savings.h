// What each cheaper setting saves in time and loses in accuracy: the first plot and table of a
// page.
#pragma once

#include <string>
#include <vector>

#include "acus/assess/tuning/sweep_result.h"
#include "acus/base/report/svg_plot.h"

namespace acus::tuning {

/// One quantity, force or image, of one setting against the reference of its sweep.
struct Saving {
  const SettingResult* setting = nullptr;
  const SettingResult* reference = nullptr;
  bool is_image = false;
  /// Another model, or other speckle: what differs is another image of the tissue and no error.
  bool is_difference = false;
  Estimate saved_percent;     ///< Of the CPU time of a step or an image; negative: it takes longer.
  Estimate loss;              ///< RMS difference from the reference: N, or grey levels of 255.
  double loss_percent = 0.0;  ///< Of the RMS force felt, or of 255 grey levels.

  /// True if the interval of the time does not contain 0, or there was one run only.
  bool SavesTime() const;
};

/// Savings of all usable settings except the references, the largest first; those whose time is not
/// distinguishable from the reference's last. They point into `result`.
std::vector<Saving> SavingsOf(const SweepResult& result);

/// Setting, time saved, loss, what is noticed of it; a row for each.
struct SavingsTable {
  std::vector<std::string> header;
  std::vector<std::vector<std::string>> rows;
};
/// Table of the savings that are differences between models, or of the others.
SavingsTable TableOf(const std::vector<Saving>& savings, bool differences);

/// "42 % +- 3", "42 % in one run", or "not distinguishable".
std::string SavedText(const Saving& saving);
/// "0.013 N +- 0.002", "at most 33 grey levels; not distinguishable from 0", "none".
std::string LossText(const Saving& saving);
/// What a hand or an eye notices of the loss, by rule of thumb.
std::string NoticedText(const Saving& saving);

/// Time saved over loss, both in percent; without series where nothing was lost or saved.
/// Differences are not in it.
report::Plot SavingsPlot(const std::vector<Saving>& savings);

}  // namespace acus::tuning
