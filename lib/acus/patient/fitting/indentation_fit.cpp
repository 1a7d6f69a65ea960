#include "acus/patient/fitting/indentation_fit.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "acus/base/core/error.h"
#include "acus/base/core/text_table.h"
#include "acus/patient/fitting/csv_number.h"
#include "acus/patient/fitting/series_fit.h"

namespace acus::fitting {
namespace {

using forces::ForceRelaxation;
using nlohmann::json;

constexpr std::size_t kFewestIndentSamples = 40;
constexpr double kStillMm = 0.02;       // A tool that has moved by less is at rest.
constexpr double kLeastStretch = 0.05;  // Of the column.
constexpr double kMostShape = 1e3;      // Of the law's parameters, by its first one.
constexpr int kNumTerms = ForceRelaxation::kMostTerms;
constexpr const char* kIndentColumns = "time_s,force_n,indentation_mm,tool_gap_mm";

/// Samples [0, size) of which [hold, size) rest at the greatest depth.
std::size_t HoldBegin(const IndentationTest& test) {
  const double end_mm = std::ranges::max(test.depth_mm) - kStillMm;
  const auto hold = std::ranges::find_if(test.depth_mm, [&](double d) { return d > end_mm; });
  return static_cast<std::size_t>(hold - test.depth_mm.begin());
}

/// The factor by which `unit` follows the force best.
double BestScale(const std::vector<double>& unit, const std::vector<double>& force) {
  double product = 0.0;
  double square = 0.0;
  for (std::size_t i = 0; i < unit.size(); ++i) {
    product += unit[i] * force[i];
    square += unit[i] * unit[i];
  }
  return square > 0.0 ? std::max(0.0, product / square) : 0.0;
}

/// The law's parameters beyond the first, then shares of what the terms before leave, logarithms of
/// times.
std::vector<SeriesParameter> ShapeParameters(HyperelasticLaw law) {
  std::vector<SeriesParameter> parameters;
  for (std::size_t k = 1; k < ParametersOf(law).size(); ++k) {
    parameters.push_back({ParametersOf(law)[k], 0.5, 0.0, kMostShape});
  }
  const double starts_s[kNumTerms] = {0.3, 2.0, 12.0};
  for (int k = 0; k < kNumTerms; ++k) {
    parameters.push_back({"share", 0.25, 0.0, 0.9});
    // Between the terms' bounds there is no other order.
    parameters.push_back({"log_time", std::log(starts_s[k]), std::log(starts_s[k] / 3.0),
                          std::log(starts_s[k] * (k + 1 < kNumTerms ? 2.0 : 5.0))});
  }
  return parameters;
}

IndentationShape ShapeOf(HyperelasticLaw law, std::span<const double> p) {
  IndentationShape shape{.law = law, .parameters = {1.0}, .relaxation = {}};
  const std::size_t extra = ParametersOf(law).size() - 1;
  shape.parameters.insert(shape.parameters.end(), p.begin(),
                          p.begin() + static_cast<std::ptrdiff_t>(extra));
  double left = 1.0;
  shape.relaxation.num_terms = kNumTerms;
  for (int k = 0; k < kNumTerms; ++k) {
    shape.relaxation.share[k] = p[extra + 2 * k] * left;
    left -= shape.relaxation.share[k];
    shape.relaxation.time_s[k] = std::exp(p[extra + 2 * k + 1]);
  }
  return shape;
}

SeriesParameter ContactParameter(const IndentationTest& test) {
  const double deepest_mm = std::ranges::max(test.depth_mm);
  const double loud_n = 0.02 * std::ranges::max(test.force_n);
  const auto felt = std::ranges::find_if(test.force_n, [&](double f) { return f > loud_n; });
  const double felt_mm = test.depth_mm[static_cast<std::size_t>(felt - test.force_n.begin())];
  return {"contact_mm", std::clamp(felt_mm, 0.0, 0.7 * deepest_mm), -0.5 * deepest_mm,
          0.8 * deepest_mm};
}

/// What a fit says of a specimen, from its own contact and shape.
void Describe(const IndentationTest& test, IndentationFit& fit) {
  const std::vector<double> unit = ReplayIndentation(fit.shape, test, fit.contact_mm.value);
  fit.stiffness_n = BestScale(unit, test.force_n);
  const double largest_n = std::ranges::max(test.force_n);
  const std::size_t hold = HoldBegin(test);
  double all = 0.0;
  double held = 0.0;
  for (std::size_t i = 0; i < unit.size(); ++i) {
    const double off = (fit.stiffness_n * unit[i] - test.force_n[i]) / largest_n;
    all += off * off;
    if (i >= hold) held += off * off;
  }
  fit.relative_rms = std::sqrt(all / static_cast<double>(unit.size()));
  fit.relative_rms_hold = std::sqrt(held / static_cast<double>(unit.size() - hold));
}

/// Contact and what `shape_of` takes of the parameters behind it.
template <typename ShapeOfParameters>
IndentationFit FitContact(const IndentationTest& test, std::vector<SeriesParameter> parameters,
                          const ShapeOfParameters& shape_of, const SeriesOptions& options) {
  const SeriesModel model = [&](std::span<const double> p, std::span<double> predicted) {
    const std::vector<double> unit = ReplayIndentation(shape_of(p.subspan(1)), test, p[0]);
    const double scale = BestScale(unit, test.force_n);
    for (std::size_t i = 0; i < unit.size(); ++i) predicted[i] = scale * unit[i];
  };
  parameters.insert(parameters.begin(), ContactParameter(test));
  const SeriesFit series = FitSeries(model, test.force_n, parameters, options);
  IndentationFit fit;
  fit.converged = series.converged;
  fit.message = series.message;
  if (!series.converged) return fit;
  fit.shape = shape_of(std::span<const double>(series.parameters).subspan(1));
  fit.contact_mm = series.Of(0);
  fit.aic = series.aic;
  Describe(test, fit);
  return fit;
}

IndentationFit FitLawTo(const IndentationTest& test, HyperelasticLaw law) {
  return FitContact(test, ShapeParameters(law),
                    [law](std::span<const double> p) { return ShapeOf(law, p); },
                    {.most_iterations = 150});
}

}  // namespace

IndentationTest ReadIndentationTest(const std::filesystem::path& path) {
  std::ifstream file(path);
  ACUS_REQUIRE(file, path.string(), ": cannot be read");
  IndentationTest test;
  test.name = path.stem().string();
  std::string line;
  std::getline(file, line);
  ACUS_REQUIRE(line.starts_with(kIndentColumns), path.string(), ":1: is '", line,
               "'; the columns must be ", kIndentColumns);
  for (int row = 2; std::getline(file, line); ++row) {
    if (line.empty()) continue;
    const std::string where = Message(path.string(), ":", row);
    std::istringstream cells(line);
    std::string cell[4];
    for (std::string& c : cell) {
      ACUS_REQUIRE(std::getline(cells, c, ','), where,
                   ": has fewer than 4 cells; complete the row, or remove it");
    }
    const double time_s = NumberAt(cell[0], where, "time_s");
    ACUS_REQUIRE(test.time_s.empty() || time_s > test.time_s.back(), where, ": time_s is ", time_s,
                 " after ", test.time_s.back(), "; time must increase");
    test.time_s.push_back(time_s);
    test.force_n.push_back(NumberAt(cell[1], where, "force_n"));
    test.depth_mm.push_back(NumberAt(cell[2], where, "indentation_mm"));
    if (row == 2) test.thickness_mm = NumberAt(cell[3], where, "tool_gap_mm");
  }
  ACUS_REQUIRE(test.time_s.size() >= kFewestIndentSamples, path.string(), ": has ",
               test.time_s.size(), " samples; at least ", kFewestIndentSamples, " are needed");
  const double deepest_mm = std::ranges::max(test.depth_mm);
  ACUS_REQUIRE(test.thickness_mm > deepest_mm, path.string(), ": tool_gap_mm begins with ",
               test.thickness_mm, " mm, and the tool goes ", deepest_mm,
               " mm in; the gap must be larger: is it in mm?");
  double offset_n = 0.0;
  double count = 0.0;
  for (std::size_t i = 0; i < test.force_n.size() && test.depth_mm[i] < kStillMm; ++i) {
    offset_n += test.force_n[i];
    count += 1.0;
  }
  for (double& force : test.force_n) force -= count > 0.0 ? offset_n / count : 0.0;
  return test;
}

std::vector<double> ReplayIndentation(const IndentationShape& shape, const IndentationTest& test,
                                      double contact_mm) {
  const ForceRelaxation& relaxation = shape.relaxation;
  const double elastic = relaxation.ElasticShare();
  std::vector<double> force(test.time_s.size());
  double branch[kNumTerms] = {};
  double before = 0.0;
  for (std::size_t i = 0; i < force.size(); ++i) {
    const double column_mm = test.thickness_mm - contact_mm;
    const double stretch =
        std::clamp((test.thickness_mm - test.depth_mm[i]) / column_mm, kLeastStretch, 1.0);
    const double stress = CompressiveStressMpa(shape.law, shape.parameters, stretch);
    force[i] = elastic * stress;
    for (int k = 0; k < relaxation.num_terms; ++k) {
      const double step =
          i > 0 ? (test.time_s[i] - test.time_s[i - 1]) / relaxation.time_s[k] : 0.0;
      const double rising = step > 0.0 ? -std::expm1(-step) / step : 1.0;
      branch[k] = branch[k] * std::exp(-step) + (stress - before) * rising;
      force[i] += relaxation.share[k] * branch[k];
    }
    before = stress;
  }
  return force;
}

IndentationFit FitIndentation(const IndentationTest& test) {
  IndentationFit best;
  const std::size_t hold = HoldBegin(test);
  if (!(std::ranges::max(test.force_n) > 0.0) || hold < 10 || test.time_s.size() < hold + 10) {
    best.message = Message("the tool presses over ", hold, " samples and rests over ",
                           test.time_s.size() - hold, "; 10 of each and a force are needed");
    return best;
  }
  for (const HyperelasticLaw law : kHyperelasticLaws) {
    IndentationFit fit = FitLawTo(test, law);
    if (fit.converged && (!best.converged || fit.aic < best.aic)) best = std::move(fit);
  }
  if (!best.converged) best.message = "no law follows the indentation";
  return best;
}

IndentationShape FitSharedShape(std::span<const IndentationTest> tests,
                                std::span<const IndentationFit> fits) {
  std::vector<double> measured;
  for (std::size_t i = 0; i < tests.size(); ++i) {
    if (!fits[i].converged) continue;
    const double largest_n = std::ranges::max(tests[i].force_n);
    for (const double force : tests[i].force_n) measured.push_back(force / largest_n);
  }
  ACUS_ASSERT(!measured.empty());
  SeriesFit best;
  HyperelasticLaw best_law = HyperelasticLaw::kNeoHookean;
  for (const HyperelasticLaw law : kHyperelasticLaws) {
    const SeriesModel model = [&](std::span<const double> p, std::span<double> predicted) {
      const IndentationShape shape = ShapeOf(law, p);
      std::size_t at = 0;
      for (std::size_t i = 0; i < tests.size(); ++i) {
        if (!fits[i].converged) continue;
        const std::vector<double> unit =
            ReplayIndentation(shape, tests[i], fits[i].contact_mm.value);
        const double scale = BestScale(unit, tests[i].force_n) / std::ranges::max(tests[i].force_n);
        for (const double force : unit) predicted[at++] = scale * force;
      }
    };
    SeriesFit fit = FitSeries(model, measured, ShapeParameters(law), {.most_iterations = 100});
    if (!fit.converged || (best.converged && fit.rms_n >= best.rms_n)) continue;
    best = std::move(fit);
    best_law = law;
  }
  if (!best.converged) throw NoAnswerError("no law follows the indentations together");
  return ShapeOf(best_law, best.parameters);
}

IndentationFit FitWithShape(const IndentationTest& test, const IndentationShape& shape) {
  return FitContact(test, {},
                    [&](std::span<const double>) -> const IndentationShape& { return shape; }, {});
}

json ShapeJson(const IndentationShape& shape) {
  json terms = json::array();
  for (int k = 0; k < shape.relaxation.num_terms; ++k) {
    terms.push_back({{"share", shape.relaxation.share[k]}, {"time_s", shape.relaxation.time_s[k]}});
  }
  return {{"law", std::string(NameOf(shape.law))},
          {"parameters", shape.parameters},
          {"relaxation", terms}};
}

IndentationShape ShapeFromJson(const json& document, const std::string& label) {
  try {
    IndentationShape shape;
    const std::string name = document.at("law");
    const auto law = std::ranges::find_if(kHyperelasticLaws,
                                          [&](HyperelasticLaw l) { return NameOf(l) == name; });
    ACUS_REQUIRE(law != std::end(kHyperelasticLaws), label, ": /shared/law is '", name,
                 "'; allowed: neo_hookean, yeoh, fung");
    shape.law = *law;
    shape.parameters = document.at("parameters").get<std::vector<double>>();
    const json& terms = document.at("relaxation");
    ACUS_REQUIRE(shape.parameters.size() == ParametersOf(shape.law).size() &&
                     terms.size() <= static_cast<std::size_t>(kNumTerms),
                 label, ": /shared has other numbers of parameters or terms than its law");
    for (const json& term : terms) {
      shape.relaxation.share[shape.relaxation.num_terms] = term.at("share");
      shape.relaxation.time_s[shape.relaxation.num_terms++] = term.at("time_s");
    }
    return shape;
  } catch (const json::exception& error) {
    throw InputError(Message(label, ": /shared is not a fit of indentations (", error.what(),
                             "); make it with acus-fit --models indentation"));
  }
}

json IndentationJson(const IndentationTest& test, const IndentationFit& fit) {
  json result = {
      {"name", test.name}, {"thickness_mm", test.thickness_mm}, {"answered", fit.converged}};
  if (!fit.converged) {
    result["why_not"] = fit.message;
    return result;
  }
  result.update(ShapeJson(fit.shape));
  result["stiffness_n"] = fit.stiffness_n;
  result["contact_mm"] = {{"value", fit.contact_mm.value},
                          {"low_95", fit.contact_mm.low},
                          {"high_95", fit.contact_mm.high}};
  result["relative_rms"] = fit.relative_rms;
  result["relative_rms_hold"] = fit.relative_rms_hold;
  return result;
}

report::Plot IndentationPlot(const IndentationTest& test, const IndentationFit& fit) {
  report::Plot plot{.title = test.name, .x_label = "time [s]", .y_label = "force [N]"};
  plot.series.push_back({.name = "measured", .x = test.time_s, .y = test.force_n});
  if (!fit.converged) return plot;
  std::vector<double> force = ReplayIndentation(fit.shape, test, fit.contact_mm.value);
  for (double& f : force) f *= fit.stiffness_n;
  plot.series.push_back({.name = std::string(NameOf(fit.shape.law)) + " with relaxation",
                         .x = test.time_s,
                         .y = std::move(force)});
  return plot;
}

std::string IndentationTable(std::span<const IndentationTest> tests,
                             std::span<const IndentationFit> fits) {
  std::vector<std::vector<std::string>> rows;
  for (std::size_t i = 0; i < tests.size(); ++i) {
    const IndentationFit& fit = fits[i];
    if (!fit.converged) {
      rows.push_back({tests[i].name, "no answer: " + fit.message, "-", "-", "-", "-"});
      continue;
    }
    std::string relaxing;
    for (int k = 0; k < fit.shape.relaxation.num_terms; ++k) {
      relaxing += Message(k > 0 ? ", " : "", FixedText(fit.shape.relaxation.share[k], 2), " in ",
                          FixedText(fit.shape.relaxation.time_s[k], 1), " s");
    }
    rows.push_back({tests[i].name, std::string(NameOf(fit.shape.law)),
                    FixedText(fit.stiffness_n, 3), relaxing, FixedText(100.0 * fit.relative_rms, 2),
                    FixedText(100.0 * fit.relative_rms_hold, 2)});
  }
  return TextTable({"specimen", "law", "stiffness [N]", "relaxing shares", "RMS [% of the largest]",
                    "in the hold [%]"},
                   rows);
}

}  // namespace acus::fitting
