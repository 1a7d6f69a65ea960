#include "acus/assess/tuning/savings.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "acus/base/core/text_table.h"

namespace acus::tuning {
namespace {

constexpr double kGreyLevels = 255.0;
/// Knobs that give the tissue other scatterers: the images differ as those of two patients do.
constexpr std::array kOtherSpeckle = {"speckle", "fibre_texture", "point_spread"};

/// A choice of models is words or folders; of fidelity numbers, or a part that is on or off.
bool IsDifference(const SweepResult& result, const SettingResult& setting) {
  if (std::ranges::find(kOtherSpeckle, setting.knob) != kOtherSpeckle.end()) return true;
  const auto knob = std::ranges::find(result.knobs, setting.knob, &Knob::name);
  return knob != result.knobs.end() && !knob->values.empty() && knob->values.front().is_string() &&
         !knob->is_folder;
}

/// 100 (1 - now / before), its interval by the relative ones of both.
Estimate SavedPercent(const Estimate& now, const Estimate& before) {
  const double share = now.mean / before.mean;
  return {100.0 * (1.0 - share),
          100.0 * share * std::hypot(now.half_width / now.mean, before.half_width / before.mean),
          std::min(now.count, before.count)};
}

bool HasInterval(const Estimate& estimate) {
  return std::isfinite(estimate.half_width);
}

void AddForce(const SettingResult& now, const SettingResult& reference, bool is_difference,
              std::vector<Saving>& savings) {
  if (now.force_rms_n.count == 0 || !(reference.step_us_median.mean > 0.0)) return;
  const double felt_n = std::max(now.force_felt_n.mean, reference.force_felt_n.mean);
  savings.push_back({.setting = &now,
                     .reference = &reference,
                     .is_difference = is_difference,
                     .saved_percent = SavedPercent(now.step_us_median, reference.step_us_median),
                     .loss = now.force_rms_n,
                     .loss_percent = felt_n > 0.0 ? 100.0 * now.force_rms_n.mean / felt_n : 0.0});
}

void AddImage(const SettingResult& now, const SettingResult& reference, bool is_difference,
              std::vector<Saving>& savings) {
  if (now.image_rms_grey.count == 0 || !(reference.image_ms_median.mean > 0.0)) return;
  savings.push_back({.setting = &now,
                     .reference = &reference,
                     .is_image = true,
                     .is_difference = is_difference,
                     .saved_percent = SavedPercent(now.image_ms_median, reference.image_ms_median),
                     .loss = now.image_rms_grey,
                     .loss_percent = 100.0 * now.image_rms_grey.mean / kGreyLevels});
}

std::string SettingText(const Saving& saving) {
  const Setting& now = saving.setting->setting;
  if (now.size() != 1) return TextOf(now);
  return Message(saving.setting->knob, " ", ValueText(now.begin()->second), " instead of ",
                 ValueText(saving.reference->setting.begin()->second));
}

bool LossIsZero(const Saving& saving) {
  return HasInterval(saving.loss) && saving.loss.half_width >= saving.loss.mean;
}

std::string UnitOf(const Saving& saving) {
  return saving.is_image ? " grey levels" : " N";
}

}  // namespace

bool Saving::SavesTime() const {
  return !HasInterval(saved_percent) || std::abs(saved_percent.mean) > saved_percent.half_width;
}

std::vector<Saving> SavingsOf(const SweepResult& result) {
  std::vector<Saving> savings;
  for (const SettingResult& now : result.settings) {
    if (now.is_reference || !now.unusable.empty()) continue;
    const auto reference =
        std::ranges::find_if(result.settings, [&now](const SettingResult& other) {
          return other.is_reference && other.knob == now.knob;
        });
    if (reference == result.settings.end()) continue;
    const bool is_difference = IsDifference(result, now);
    const auto knob = std::ranges::find(result.knobs, now.knob, &Knob::name);
    const ActsOn acts_on = knob == result.knobs.end() ? ActsOn::kBoth : knob->acts_on;
    if (acts_on != ActsOn::kImage) AddForce(now, *reference, is_difference, savings);
    if (acts_on != ActsOn::kForce) AddImage(now, *reference, is_difference, savings);
  }
  std::ranges::stable_sort(savings, [](const Saving& a, const Saving& b) {
    if (a.SavesTime() != b.SavesTime()) return a.SavesTime();
    return a.SavesTime() && a.saved_percent.mean > b.saved_percent.mean;
  });
  return savings;
}

std::string SavedText(const Saving& saving) {
  if (!saving.SavesTime()) return "not distinguishable";
  std::string text = RoundedText(saving.saved_percent.mean, 2) + " %";
  return HasInterval(saving.saved_percent)
             ? text + " \u00B1 " + RoundedText(saving.saved_percent.half_width, 1)
             : text + " in one run";
}

std::string LossText(const Saving& saving) {
  if (saving.loss.mean == 0.0) return "none";
  if (LossIsZero(saving)) {
    return Message("at most ", RoundedText(saving.loss.mean + saving.loss.half_width, 2),
                   UnitOf(saving), "; not distinguishable from 0");
  }
  std::string text = RoundedText(saving.loss.mean, 2) + UnitOf(saving);
  if (HasInterval(saving.loss) && saving.loss.half_width > 0.0) {
    text += " \u00B1 " + RoundedText(saving.loss.half_width, 1);
  }
  return text;
}

std::string NoticedText(const Saving& saving) {
  if (saving.loss.mean == 0.0) return "nothing";
  if (saving.is_difference) return saving.is_image ? "another image" : "another feel";
  if (saving.is_image) {
    constexpr double kOneLevel = 1.0, kSideBySide = 3.0, kPlain = 10.0;
    if (saving.loss.mean < kOneLevel) return "nothing: less than a grey level";
    if (saving.loss.mean < kSideBySide) return "little, images side by side";
    return saving.loss.mean < kPlain ? "a somewhat different texture" : "a different image";
  }
  constexpr double kNoticed = 10.0,
                   kPlain = 30.0;  // Weber's share for forces at the hand: 7 to 10 %.
  const std::string share = RoundedText(saving.loss_percent, 2) + " % of the force felt: ";
  if (saving.loss_percent < kNoticed) return share + "below what a hand notices";
  return share + (saving.loss_percent < kPlain ? "noticed in a comparison" : "plainly felt");
}

SavingsTable TableOf(const std::vector<Saving>& savings, bool differences) {
  SavingsTable table;
  table.header = {"setting", "of", "time saved", differences ? "difference, RMS" : "loss, RMS",
                  "what is noticed"};
  for (const Saving& saving : savings) {
    if (saving.is_difference != differences) continue;
    table.rows.push_back({SettingText(saving), saving.is_image ? "an image" : "a force step",
                          SavedText(saving), LossText(saving), NoticedText(saving)});
  }
  return table;
}

report::Plot SavingsPlot(const std::vector<Saving>& savings) {
  report::Plot plot;
  plot.title = "What cheaper settings save and lose: the best are at the top left";
  plot.x_label = "loss, RMS [% of the force felt, or of 255 grey levels]";
  plot.y_label = "CPU time saved [%]";
  plot.height_px = 420;
  plot.log_x = true;
  plot.y_from_zero = true;
  report::Series force{.name = "force, a step", .style = report::Style::kPoints};
  report::Series image{
      .name = "image", .style = report::Style::kPoints, .symbol = report::Symbol::kDiamond};
  for (const Saving& saving : savings) {
    if (saving.is_difference || !saving.SavesTime() || !(saving.loss_percent > 0.0)) continue;
    report::Series& series = saving.is_image ? image : force;
    series.x.push_back(saving.loss_percent);
    series.y.push_back(saving.saved_percent.mean);
    const double half = HasInterval(saving.saved_percent) ? saving.saved_percent.half_width : 0.0;
    series.low.push_back(saving.saved_percent.mean - half);
    series.high.push_back(saving.saved_percent.mean + half);
    series.labels.push_back(TextOf(saving.setting->setting));
  }
  for (report::Series* series : {&force, &image}) {
    if (!series->x.empty()) plot.series.push_back(std::move(*series));
  }
  return plot;
}

}  // namespace acus::tuning
