#include "acus/patient/fitting/tension_fit.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "acus/base/core/error.h"
#include "acus/base/core/text_table.h"
#include "acus/base/math/statistics.h"
#include "acus/patient/fitting/csv_number.h"
#include "acus/patient/fitting/series_fit.h"

namespace acus::fitting {
namespace {

using nlohmann::json;

constexpr std::size_t kMostCurveSamples = 400;
constexpr std::size_t kFewestSamples = 20;
constexpr double kSlopeShare = 0.05;         // Of the elongation, over which the slope is taken.
constexpr double kYieldedShare = 1.0 / 3.0;  // Of the largest slope: no law here softens more.
constexpr double kTornShare = 0.05;          // Of the largest force: a fall by so much is failure.
constexpr double kLargestMpa = 1e3;
constexpr double kLargestExponentRate = 1e3;

double DimensionIn(const std::string& line, const char* key, const std::string& where) {
  const std::string text = std::string(key) + "=";
  const auto at = line.find(text);
  ACUS_REQUIRE(at != line.npos, where, ": has no ", key,
               "=; the first line must be '# length_mm=... width_mm=... thickness_mm=...'");
  const auto begin = at + text.size();
  const double value = NumberAt(line.substr(begin, line.find(' ', begin) - begin), where, key);
  ACUS_REQUIRE(value > 0.0, where, ": ", key, " is ", value, "; it must be above 0");
  return value;
}

/// Where the loading ends: see FitTension.
std::size_t LoadingEnd(const TensionTest& test) {
  const auto& f = test.force_n;
  const auto& e = test.elongation_mm;
  const auto peak = static_cast<std::size_t>(std::ranges::max_element(f) - f.begin());
  const double window_mm = kSlopeShare * (e[peak] - e[0]);
  double top_n = f[0];
  double steepest = 0.0;
  std::size_t back = 0;
  for (std::size_t i = 0; i <= peak; ++i) {
    top_n = std::max(top_n, f[i]);
    if (f[i] < top_n - kTornShare * f[peak]) {
      return static_cast<std::size_t>(
                 std::max_element(f.begin(), f.begin() + static_cast<std::ptrdiff_t>(i)) -
                 f.begin()) +
             1;
    }
    while (e[i] - e[back] > window_mm) ++back;
    if (back == 0 || !(e[i] > e[back - 1])) continue;
    const double slope = (f[i] - f[back - 1]) / (e[i] - e[back - 1]);
    steepest = std::max(steepest, slope);
    if (slope < kYieldedShare * steepest && f[i] > 0.5 * f[peak]) return i + 1;
  }
  return peak + 1;
}

/// The loading, thinned evenly over the elongation.
struct Loading {
  std::vector<double> elongation_mm;
  std::vector<double> stress_mpa;
};

Loading Thin(const TensionTest& test, std::size_t end) {
  const double area_mm2 = test.width_mm * test.thickness_mm;
  const double first_mm = test.elongation_mm[0];
  const double step_mm =
      (test.elongation_mm[end - 1] - first_mm) / static_cast<double>(kMostCurveSamples);
  Loading loading;
  double sum_mm = 0.0;
  double sum_n = 0.0;
  double count = 0.0;
  double next_mm = first_mm + step_mm;
  for (std::size_t i = 0; i < end; ++i) {
    sum_mm += test.elongation_mm[i];
    sum_n += test.force_n[i];
    count += 1.0;
    if (test.elongation_mm[i] < next_mm && i + 1 < end) continue;
    loading.elongation_mm.push_back(sum_mm / count);
    loading.stress_mpa.push_back(sum_n / count / area_mm2);
    sum_mm = sum_n = count = 0.0;
    next_mm = std::max(next_mm + step_mm, test.elongation_mm[i]);
  }
  return loading;
}

/// Starts of the law's parameters for a small-strain modulus of mu.
std::vector<std::vector<double>> StartsOf(HyperelasticLaw law, double mu) {
  switch (law) {
    case HyperelasticLaw::kNeoHookean:
      return {{mu}};
    case HyperelasticLaw::kYeoh:
      return {{0.5 * mu, 0.1 * mu, 0.1 * mu}, {0.1 * mu, mu, mu}};
    case HyperelasticLaw::kFung:
      return {{mu, 0.3}, {0.3 * mu, 2.0}, {0.1 * mu, 10.0}};
  }
  return {};
}

LawFit FitLaw(HyperelasticLaw law, const TensionTest& test, const Loading& loading) {
  const double last_mm = loading.elongation_mm.back();
  const double stretch = 1.0 + std::max(1e-6, last_mm / test.length_mm);
  const double mu =
      std::max(1e-6, loading.stress_mpa.back() / (stretch - 1.0 / (stretch * stretch)));
  const SeriesModel model = [&](std::span<const double> p, std::span<double> predicted) {
    for (std::size_t i = 0; i < predicted.size(); ++i) {
      const double lambda = (test.length_mm + loading.elongation_mm[i]) / (test.length_mm + p[0]);
      predicted[i] = NominalStressMpa(law, p.subspan(1), lambda);
    }
  };
  SeriesFit best;
  for (const std::vector<double>& start : StartsOf(law, mu)) {
    for (const double slack_share : {0.0, 0.3}) {
      std::vector<SeriesParameter> parameters = {
          {"slack_mm", slack_share * last_mm, -0.1 * test.length_mm, 0.9 * last_mm}};
      for (std::size_t k = 0; k < start.size(); ++k) {
        const bool is_rate = law == HyperelasticLaw::kFung && k == 1;
        parameters.push_back(
            {ParametersOf(law)[k], start[k], 0.0, is_rate ? kLargestExponentRate : kLargestMpa});
      }
      SeriesFit fit = FitSeries(model, loading.stress_mpa, parameters, {.most_iterations = 300});
      if (fit.converged && (!best.converged || fit.rms_n < best.rms_n)) best = std::move(fit);
    }
  }
  LawFit result{.law = law,
                .converged = best.converged,
                .message = best.message,
                .parameters = {},
                .slack_mm = {}};
  if (!best.converged) {
    result.message = "the law does not follow the loading from any start";
    return result;
  }
  result.slack_mm = best.Of(0);
  for (std::size_t k = 1; k < best.parameters.size(); ++k) {
    result.parameters.push_back(best.Of(k).AtLeast(0.0));
  }
  result.rms_mpa = best.rms_n;
  result.relative_rms = best.rms_n / std::max(1e-12, std::ranges::max(loading.stress_mpa));
  result.aic = best.effective_samples;  // Until all laws are compared with the same number.
  return result;
}

}  // namespace

TensionTest ReadTensionTest(const std::filesystem::path& path) {
  std::ifstream file(path);
  ACUS_REQUIRE(file, path.string(), ": cannot be read");
  TensionTest test;
  test.name = path.stem().string();
  std::string line;
  std::getline(file, line);
  const std::string first = path.string() + ":1";
  test.length_mm = DimensionIn(line, "length_mm", first);
  test.width_mm = DimensionIn(line, "width_mm", first);
  test.thickness_mm = DimensionIn(line, "thickness_mm", first);
  std::getline(file, line);
  ACUS_REQUIRE(line.starts_with("time_s,elongation_mm,force_n"), path.string(), ":2: is '", line,
               "'; the columns must be time_s,elongation_mm,force_n");
  for (int row = 3; std::getline(file, line); ++row) {
    if (line.empty()) continue;
    const std::string where = Message(path.string(), ":", row);
    std::istringstream cells(line);
    std::string time, elongation, force;
    ACUS_REQUIRE(std::getline(cells, time, ',') && std::getline(cells, elongation, ',') &&
                     std::getline(cells, force, ','),
                 where, ": has fewer than 3 cells; complete the row, or remove it");
    test.time_s.push_back(NumberAt(time, where, "time_s"));
    test.elongation_mm.push_back(NumberAt(elongation, where, "elongation_mm"));
    test.force_n.push_back(NumberAt(force, where, "force_n"));
  }
  ACUS_REQUIRE(test.time_s.size() >= kFewestSamples, path.string(), ": has ", test.time_s.size(),
               " samples; at least ", kFewestSamples, " are needed");
  return test;
}

TensionFit FitTension(const TensionTest& test) {
  TensionFit fit;
  fit.end = LoadingEnd(test);
  const double travel_mm = test.elongation_mm[fit.end - 1] - test.elongation_mm[0];
  if (fit.end < kFewestSamples || !(travel_mm > 0.01 * test.length_mm)) {
    fit.message = Message("the force only rises over ", travel_mm, " mm and ", fit.end,
                          " samples: too short to fit");
    return fit;
  }
  const Loading loading = Thin(test, fit.end);
  if (loading.stress_mpa.size() < kFewestSamples) {
    fit.message = Message("the loading has only ", loading.stress_mpa.size(), " distinct samples");
    return fit;
  }
  double independent = 0.0;
  double least_mpa = 1e300;
  for (const HyperelasticLaw law : kHyperelasticLaws) {
    fit.laws.push_back(FitLaw(law, test, loading));
    if (!fit.laws.back().converged || fit.laws.back().rms_mpa >= least_mpa) continue;
    least_mpa = fit.laws.back().rms_mpa;
    independent = fit.laws.back().aic;
  }
  for (std::size_t k = 0; k < fit.laws.size(); ++k) {
    LawFit& law = fit.laws[k];
    if (!law.converged) continue;
    law.aic = 2.0 * independent * std::log(std::max(law.rms_mpa, 1e-12)) +
              2.0 * (static_cast<double>(law.parameters.size()) + 2.0);
    if (!fit.best || law.aic < fit.laws[*fit.best].aic) fit.best = k;
  }
  fit.converged = fit.best.has_value();
  if (!fit.converged) fit.message = "no law follows the loading";
  return fit;
}

json TensionJson(const TensionTest& test, const TensionFit& fit) {
  json laws = json::object();
  for (const LawFit& law : fit.laws) {
    json& block = laws[std::string(NameOf(law.law))] = {{"answered", law.converged}};
    if (!law.converged) {
      block["why_not"] = law.message;
      continue;
    }
    for (std::size_t k = 0; k < law.parameters.size(); ++k) {
      block["parameters"][ParametersOf(law.law)[k]] = EstimateJson(law.parameters[k]);
    }
    block["slack_mm"] = EstimateJson(law.slack_mm);
    block["rms_mpa"] = law.rms_mpa;
    block["relative_rms"] = law.relative_rms;
    block["aic"] = law.aic;
  }
  json result = {{"name", test.name},
                 {"length_mm", test.length_mm},
                 {"area_mm2", test.width_mm * test.thickness_mm},
                 {"loading_to_mm", test.elongation_mm[std::max<std::size_t>(1, fit.end) - 1]},
                 {"laws", laws}};
  if (fit.best) result["best"] = std::string(NameOf(fit.laws[*fit.best].law));
  if (!fit.converged) result["why_not"] = fit.message;
  return result;
}

report::Plot TensionPlot(const TensionTest& test, const TensionFit& fit) {
  report::Plot plot{.title = test.name, .x_label = "elongation [mm]", .y_label = "stress [MPa]"};
  const double area_mm2 = test.width_mm * test.thickness_mm;
  report::Series measured{.name = "measured", .x = test.elongation_mm};
  for (const double force : test.force_n) measured.y.push_back(force / area_mm2);
  plot.series.push_back(std::move(measured));
  const std::span<const double> loading(test.elongation_mm.data(), fit.end);
  for (const LawFit& law : fit.laws) {
    if (!law.converged) continue;
    std::vector<double> p;
    for (const Estimate& e : law.parameters) p.push_back(e.value);
    report::Series series{.name = std::string(NameOf(law.law))};
    for (const double e : loading) {
      series.x.push_back(e);
      series.y.push_back(NominalStressMpa(
          law.law, p, (test.length_mm + e) / (test.length_mm + law.slack_mm.value)));
    }
    plot.series.push_back(std::move(series));
  }
  return plot;
}

namespace {

/// "mu_kpa 0.2971" of mu_mpa 2.971e-4: fat and fresh organs have tenths of a kPa.
std::string InKpa(std::string name, double value) {
  constexpr std::string_view kMpa = "_mpa";
  if (name.ends_with(kMpa)) {
    name.replace(name.size() - kMpa.size(), kMpa.size(), "_kpa");
    value *= 1e3;
  }
  return Message(name, " ", RoundedText(value, 4));
}

}  // namespace

std::string TensionTable(std::span<const TensionTest> tests, std::span<const TensionFit> fits) {
  std::vector<std::vector<std::string>> rows;
  for (std::size_t i = 0; i < tests.size(); ++i) {
    for (std::size_t k = 0; k < fits[i].laws.size(); ++k) {
      const LawFit& law = fits[i].laws[k];
      std::vector<std::string> row = {tests[i].name, std::string(NameOf(law.law))};
      std::string values;
      for (std::size_t n = 0; n < law.parameters.size(); ++n) {
        values += (n > 0 ? ", " : "") + InKpa(ParametersOf(law.law)[n], law.parameters[n].value);
      }
      row.push_back(law.converged ? values : "no answer: " + law.message);
      row.push_back(law.converged ? FixedText(100.0 * law.relative_rms, 2) : "-");
      row.push_back(fits[i].best == k ? "best" : "");
      rows.push_back(std::move(row));
    }
    if (fits[i].laws.empty()) {
      rows.push_back({tests[i].name, "-", "no answer: " + fits[i].message, "-", ""});
    }
  }
  return TextTable({"specimen", "law", "parameters", "rms [% of the largest stress]", ""}, rows) +
         "\nA law describes its own strip. Tension does not transfer between animals: the stress "
         "of "
         "one tissue\ndiffered by a factor of 3.7 between three pigs (geometric standard deviation "
         "at a stretch of 1.3).\n";
}

}  // namespace acus::fitting
