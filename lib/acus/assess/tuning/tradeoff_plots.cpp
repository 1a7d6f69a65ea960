#include "acus/assess/tuning/tradeoff_plots.h"

#include <algorithm>
#include <cmath>

#include "acus/assess/tuning/pareto.h"
#include "acus/base/core/text_table.h"

namespace acus::tuning {
namespace {

/// Errors below this share of the largest are rounding: they would stretch the axis over many empty
/// decades. Tables contain them.
constexpr double kShownShare = 1e-5;

/// A number of a setting, and the scale of its error in the plot.
struct Quantity {
  const char* title;
  const char* label;
  Estimate SettingResult::*error;
  bool is_image;
  bool is_log;
};

constexpr Quantity kForce = {"force: error against the time of a step", "RMS error [N]",
                             &SettingResult::force_rms_n, false, true};
constexpr Quantity kPsnr = {"images: PSNR against the time of an image", "PSNR [dB]",
                            &SettingResult::image_psnr_db, true, false};
constexpr Quantity kSsim = {"images: 1 \u2212 SSIM against the time of an image", "1 \u2212 SSIM",
                            &SettingResult::image_ssim, true, true};

/// Mean and ends of the 95 % interval, in the plot.
struct Value {
  double mean;
  double low;
  double high;
};

Value ValueOf(const Estimate& estimate) {
  const double half = std::isfinite(estimate.half_width) ? estimate.half_width : 0.0;
  return {estimate.mean, estimate.mean - half, estimate.mean + half};
}

/// A logarithmic axis cannot show intervals that reach zero or below.
Value OnLogAxis(Value value) {
  value.low = std::max(value.low, 0.1 * value.mean);
  return value;
}

struct Point {
  const SettingResult* setting;
  Value cost;
  Value error;
};

class Drawing {
 public:
  Drawing(const SweepResult& result, const PlotRemarks& remarks, const Quantity& quantity)
      : result_(result), remarks_(remarks), quantity_(quantity) {}

  /// Without series if there are fewer than two points.
  report::Plot Draw() {
    report::Plot plot;
    plot.title = quantity_.title;
    plot.x_label = CostLabel();
    plot.y_label = quantity_.label;
    plot.log_x = true;
    plot.log_y = quantity_.is_log;
    plot.height_px = 380;
    TakePoints();
    if (points_.size() < 2) return plot;
    DrawLimits(plot);
    if (OneReference()) {
      plot.series.push_back(Front(points_, "Pareto front"));
      plot.series.back().colour = report::Colour::kInk;
    }
    for (const std::string& knob : KnobsShown()) DrawKnob(knob, plot);
    DrawMarked(plot);
    return plot;
  }

 private:
  bool OneReference() const { return remarks_.goal.has_value() || result_.jointly; }

  bool IsBudget() const { return remarks_.goal && remarks_.goal->kind == GoalKind::kBudget; }

  std::string CostLabel() const {
    if (quantity_.is_image) {
      return IsBudget() ? "CPU time of an image, 95th percentile [ms]"
                        : "median CPU time of an image [ms]";
    }
    return IsBudget() ? "CPU time of a step, 99.9th percentile [\u00B5s]"
                      : "median CPU time of a step [\u00B5s]";
  }

  const Estimate& CostOf(const SettingResult& setting) const {
    if (quantity_.is_image) return IsBudget() ? setting.image_ms_p95 : setting.image_ms_median;
    return IsBudget() ? setting.step_us_p999 : setting.step_us_median;
  }

  Value ErrorOf(const SettingResult& setting) const {
    const Value value = ValueOf(setting.*quantity_.error);
    if (quantity_.error != &SettingResult::image_ssim) return value;
    return {1.0 - value.mean, 1.0 - value.high, 1.0 - value.low};
  }

  void TakePoints() {
    double largest = 0.0;
    for (const SettingResult& setting : result_.settings) {
      const double error = ErrorOf(setting).mean;
      if (setting.unusable.empty() && std::isfinite(error)) largest = std::max(largest, error);
    }
    for (const SettingResult& setting : result_.settings) {
      if (remarks_.knob && setting.knob != *remarks_.knob) continue;
      const Value cost = OnLogAxis(ValueOf(CostOf(setting)));
      Value error = ErrorOf(setting);
      if (!setting.unusable.empty() || !(cost.mean > 0.0) || !std::isfinite(error.mean)) continue;
      if (quantity_.is_log) {
        if (!(error.mean > kShownShare * largest)) continue;
        error = OnLogAxis(error);
      }
      points_.push_back({&setting, cost, error});
    }
  }

  std::vector<std::string> KnobsShown() const {
    std::vector<std::string> knobs;
    for (const Point& point : points_) {
      if (std::ranges::find(knobs, point.setting->knob) == knobs.end()) {
        knobs.push_back(point.setting->knob);
      }
    }
    return knobs;
  }

  report::Series Front(const std::vector<Point>& points, std::string name) const {
    std::vector<CostAndError> settings;
    for (const Point& point : points) {
      // A higher PSNR is better.
      const double error = quantity_.is_log ? point.error.mean : -point.error.mean;
      settings.push_back({point.cost.mean, error});
    }
    report::Series front{.name = std::move(name)};
    for (const std::size_t i : ParetoFront(settings)) {
      front.x.push_back(points[i].cost.mean);
      front.y.push_back(points[i].error.mean);
    }
    return front;
  }

  void DrawKnob(const std::string& knob, report::Plot& plot) const {
    report::Series dots{.name = knob, .style = report::Style::kPoints};
    std::vector<Point> own;
    for (const Point& point : points_) {
      if (point.setting->knob != knob) continue;
      own.push_back(point);
      dots.x.push_back(point.cost.mean);
      dots.y.push_back(point.error.mean);
      dots.low.push_back(point.error.low);
      dots.high.push_back(point.error.high);
      dots.x_low.push_back(point.cost.low);
      dots.x_high.push_back(point.cost.high);
      dots.labels.push_back(LabelOf(*point.setting));
    }
    const std::size_t place = plot.series.size();
    plot.series.push_back(std::move(dots));
    if (OneReference() || own.size() < 2) return;
    report::Series front = Front(own, "");
    front.colour_of = place;
    if (front.x.size() > 1) plot.series.push_back(std::move(front));
  }

  /// The value of the swept parameter; none for a joint setting, which has too many.
  static std::string LabelOf(const SettingResult& setting) {
    const auto own = setting.setting.find(setting.knob);
    if (own == setting.setting.end()) return "";
    std::string text = ValueText(own->second);
    const std::size_t slash = text.find_last_of('/', text.size() - 2);
    if (slash != text.npos) text = text.substr(slash + 1);  // The name of a folder.
    return text;
  }

  void DrawMarked(report::Plot& plot) const {
    report::Series ours{.name = OneReference() ? "as the scenario has it" : "default",
                        .style = report::Style::kPoints,
                        .symbol = report::Symbol::kRing,
                        .colour = report::Colour::kInk};
    report::Series papers{.name = "paper",
                          .style = report::Style::kPoints,
                          .symbol = report::Symbol::kDiamond,
                          .colour = report::Colour::kInk};
    report::Series chosen{.name = "chosen",
                          .style = report::Style::kPoints,
                          .symbol = report::Symbol::kStar,
                          .colour = report::Colour::kInk};
    const auto mark = [](report::Series& series, const Point& point) {
      series.x.push_back(point.cost.mean);
      series.y.push_back(point.error.mean);
    };
    for (const Point& point : points_) {
      const SettingResult& setting = *point.setting;
      if (OneReference() ? setting.is_scenario : setting.is_default) mark(ours, point);
      if (setting.is_paper) mark(papers, point);
      if (remarks_.chosen && setting.setting == *remarks_.chosen) mark(chosen, point);
    }
    for (report::Series* series : {&ours, &papers, &chosen}) {
      if (!series->x.empty()) plot.series.push_back(std::move(*series));
    }
  }

  void DrawLimits(report::Plot& plot) const {
    if (!remarks_.goal) return;
    const Goal& goal = *remarks_.goal;
    const std::optional<double>& limit = quantity_.is_image ? goal.image : goal.force;
    if (!limit) return;
    if (IsBudget()) {
      plot.marks.push_back(
          {*limit, "budget: " + RoundedText(quantity_.is_image ? *limit : 1e-3 * *limit, 4) + " ms",
           true});
    } else if (quantity_.error == &SettingResult::force_rms_n) {
      plot.limits.push_back({*limit, "asked: " + RoundedText(*limit, 4) + " N"});
    } else if (quantity_.error == &SettingResult::image_psnr_db) {
      plot.limits.push_back({*limit, "asked: " + RoundedText(*limit, 4) + " dB"});
    }
  }

  const SweepResult& result_;
  const PlotRemarks& remarks_;
  const Quantity& quantity_;
  std::vector<Point> points_;
};

}  // namespace

std::vector<report::Plot> TradeoffPlots(const SweepResult& result, const PlotRemarks& remarks) {
  std::vector<report::Plot> plots;
  for (const Quantity& quantity : {kForce, kPsnr, kSsim}) {
    report::Plot plot = Drawing(result, remarks, quantity).Draw();
    if (!plot.series.empty()) plots.push_back(std::move(plot));
  }
  return plots;
}

}  // namespace acus::tuning
