#include "acus/patient/fitting/modes_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "acus/base/core/csv.h"
#include "acus/base/core/error.h"
#include "acus/base/core/text_table.h"
#include "acus/base/math/statistics.h"
#include "acus/patient/fitting/series_fit.h"

namespace acus::fitting {
namespace {

using Law = mechanics::HyperelasticLaw;
using mechanics::LawKind;
using nlohmann::json;

constexpr std::size_t kFewestRows = 12;
constexpr double kLargestStretch = 5.0;
constexpr double kSmallestStretch = 0.2;
constexpr double kLargestShear = 5.0;
constexpr double kLargestModulusMpa = 1e3;
constexpr double kIncompressibleRatio = 0.49;  ///< Poisson's ratio of the rows that are proposed.

LoadMode ModeOf(const std::string& text, double amount, const std::string& where) {
  if (text == "shear") return LoadMode::kShear;
  ACUS_REQUIRE(text == "axial" || text == "tension" || text == "compression", where, ": mode is '",
               text, "'; axial, tension, compression or shear is allowed");
  const LoadMode mode = amount < 1.0 ? LoadMode::kCompression : LoadMode::kTension;
  ACUS_REQUIRE(amount == 1.0 || text == "axial" || text == NameOf(mode), where, ": a stretch of ",
               amount, " is ", NameOf(mode), ", but its mode is '", text,
               "'; stretch is 1 at rest and below 1 in compression");
  return mode;
}

void RequirePlausible(LoadMode mode, double amount, const std::string& where) {
  if (mode == LoadMode::kShear) {
    ACUS_REQUIRE(std::abs(amount) <= kLargestShear, where, ": a shear of ", amount, "; at most ",
                 kLargestShear, " is allowed. Is it in percent?");
    return;
  }
  ACUS_REQUIRE(amount >= kSmallestStretch && amount <= kLargestStretch, where, ": a stretch of ",
               amount, "; ", kSmallestStretch, " to ", kLargestStretch,
               " is allowed. Stretch is 1 at rest: is it a strain, or in percent?");
}

std::vector<double> StressesMpa(const CsvTable& table) {
  constexpr std::pair<const char*, double> kStressColumns[] = {
      {"stress_kpa", 1e-3}, {"stress_mpa", 1.0}, {"stress_pa", 1e-6}};
  for (const auto& [column, factor] : kStressColumns) {
    if (!table.Has(column)) continue;
    std::vector<double> stress = table.Numbers(column);
    for (double& value : stress) value *= factor;
    return stress;
  }
  throw InputError(Message(table.path().string(),
                           ": has no column stress_kpa (nor stress_mpa or stress_pa); the columns "
                           "must be mode, stretch_or_shear, stress_kpa"));
}

/// A law as it is fitted: which parameters, and what law they make.
struct Candidate {
  std::string name;
  LawKind kind = LawKind::kNeoHookean;
  int num_exponents = 0;  ///< ogden.
  bool has_fibres = false;

  std::vector<std::string> Names() const {
    std::vector<std::string> names{"mu_mpa"};
    const auto add = [&names](std::initializer_list<const char*> more) {
      names.insert(names.end(), more.begin(), more.end());
    };
    if (kind == LawKind::kYeoh) add({"c2_mpa", "c3_mpa"});
    if (kind == LawKind::kFung) add({"b"});
    if (kind == LawKind::kKnowles) add({"b", "power"});
    if (kind == LawKind::kOgden) add({"exponent_1"});
    if (num_exponents == 2) add({"exponent_2", "share_2"});
    if (has_fibres) add({"fibres_k1_mpa", "fibres_k2"});
    return names;
  }

  Law LawOf(std::span<const double> p) const {
    Law law{.kind = kind};
    std::size_t n = 1;
    if (kind == LawKind::kYeoh) {
      law.c2_mpa = p[n++];
      law.c3_mpa = p[n++];
    } else if (kind == LawKind::kFung) {
      law.exponent_b = p[n++];
    } else if (kind == LawKind::kKnowles) {
      law.exponent_b = p[n++];
      law.power_n = p[n++];
    } else if (kind == LawKind::kOgden) {
      law.ogden[0] = {1.0, p[n++]};
      if (num_exponents == 2) {
        law.ogden[1] = {p[n + 1], p[n]};
        law.ogden[0].share = 1.0 - p[n + 1];
        n += 2;
      }
    }
    if (has_fibres) law.fibres = {.k1_mpa = p[n], .k2 = p[n + 1]};
    return law;
  }

  /// Starts of the parameters with their bounds. @param mu_mpa  About that of the specimen.
  std::vector<std::vector<SeriesParameter>> Starts(double mu_mpa) const {
    const std::vector<std::string> names = Names();
    std::vector<std::vector<SeriesParameter>> all{{{names[0], mu_mpa, 1e-7, kLargestModulusMpa}}};
    const auto add = [&](const char* parameter, std::initializer_list<double> starts, double low,
                         double high) {
      std::vector<std::vector<SeriesParameter>> more;
      for (const auto& before : all) {
        for (const double start : starts) {
          more.push_back(before);
          more.back().push_back({parameter, start, low, high});
        }
      }
      all = std::move(more);
    };
    if (kind == LawKind::kYeoh) {
      add("c2_mpa", {0.0, mu_mpa}, 0.0, kLargestModulusMpa);
      add("c3_mpa", {mu_mpa}, 0.0, kLargestModulusMpa);
    }
    if (kind == LawKind::kFung) add("b", {1.0, 10.0}, 1e-3, 1e3);
    if (kind == LawKind::kKnowles) {
      add("b", {10.0, 1000.0}, 1e-3, 1e6);
      add("power", {0.7}, mechanics::kLeastPower, 1.0);
    }
    if (kind == LawKind::kOgden) AddExponents(all);
    if (has_fibres) {
      add("fibres_k1_mpa", {mu_mpa}, 0.0, kLargestModulusMpa);
      add("fibres_k2", {0.1, 10.0}, 0.0, 1e3);
    }
    return all;
  }

 private:
  /// Each exponent stays on its side of 0, where the law is convex.
  void AddExponents(std::vector<std::vector<SeriesParameter>>& all) const {
    const SeriesParameter below{"exponent_1", -10.0, -200.0, -mechanics::kLeastOgdenExponent};
    const SeriesParameter above{"exponent_1", 10.0, mechanics::kLeastOgdenExponent, 200.0};
    std::vector<std::vector<SeriesParameter>> more;
    for (const auto& before : all) {
      for (const SeriesParameter& first : {below, above}) {
        more.push_back(before);
        more.back().push_back(first);
        if (num_exponents < 2) continue;
        SeriesParameter second = first.start < 0.0 ? above : below;
        second.name = "exponent_2";
        second.start *= 3.0;
        more.back().push_back(second);
        more.back().push_back({"share_2", 0.1, 0.0, 0.5});
      }
    }
    all = std::move(more);
  }
};

std::vector<Candidate> Candidates() {
  std::vector<Candidate> all;
  for (const bool has_fibres : {false, true}) {
    const std::string with = has_fibres ? " with fibres" : "";
    for (const LawKind kind :
         {LawKind::kNeoHookean, LawKind::kYeoh, LawKind::kFung, LawKind::kKnowles}) {
      all.push_back({std::string(mechanics::LawName(kind)) + with, kind, 0, has_fibres});
    }
    all.push_back(
        {"ogden, 1 exponent" + (has_fibres ? "," + with : ""), LawKind::kOgden, 1, has_fibres});
    all.push_back(
        {"ogden, 2 exponents" + (has_fibres ? "," + with : ""), LawKind::kOgden, 2, has_fibres});
  }
  return all;
}

/// RMS of the stress by mode; 0 where there is none.
std::array<double, 3> RmsByMode(const ModesTest& test, std::span<const double> values) {
  std::array<double, 3> sum{};
  std::array<double, 3> count{};
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto mode = static_cast<std::size_t>(test.mode[i]);
    sum[mode] += values[i] * values[i];
    count[mode] += 1.0;
  }
  for (std::size_t k = 0; k < 3; ++k) sum[k] = count[k] > 0.0 ? std::sqrt(sum[k] / count[k]) : 0.0;
  return sum;
}

/// Each mode counts the same, however many rows it has and however large its stresses are.
std::vector<double> WeightsOf(const ModesTest& test) {
  const std::array<double, 3> rms = RmsByMode(test, test.stress_mpa);
  std::vector<double> weight;
  for (const LoadMode mode : test.mode) {
    const double scale_mpa = std::max(rms[static_cast<std::size_t>(mode)], 1e-9);
    weight.push_back(1.0 / (scale_mpa * scale_mpa * static_cast<double>(test.CountOf(mode))));
  }
  const double mean = math::Mean(weight);
  for (double& value : weight) value /= mean;
  return weight;
}

/// Shear modulus by the steepest secants near rest.
double ModulusNearRestMpa(const ModesTest& test) {
  double largest_mpa = 1e-6;
  for (std::size_t i = 0; i < test.amount.size(); ++i) {
    const bool is_shear = test.mode[i] == LoadMode::kShear;
    const double strain = is_shear ? test.amount[i] : 3.0 * (test.amount[i] - 1.0);
    if (std::abs(strain) > 1e-3) {
      largest_mpa = std::max(largest_mpa, test.stress_mpa[i] / strain);
    }
  }
  return largest_mpa;
}

void Judge(const ModesTest& test, ModesLawFit& fit) {
  std::vector<double> off_mpa;
  for (std::size_t i = 0; i < test.amount.size(); ++i) {
    off_mpa.push_back(ModeStressMpa(fit.law, fit.shear_modulus_mpa, test.mode[i], test.amount[i]) -
                      test.stress_mpa[i]);
  }
  const auto off = RmsByMode(test, off_mpa);
  const auto whole = RmsByMode(test, test.stress_mpa);
  for (std::size_t k = 0; k < 3; ++k) {
    fit.relative_rms_of[k] = whole[k] > 0.0 ? off[k] / whole[k] : 0.0;
  }
  fit.relative_rms = math::RootMeanSquare(off_mpa) / math::RootMeanSquare(test.stress_mpa);
}

ModesLawFit FitLaw(const Candidate& candidate, const ModesTest& test,
                   std::span<const double> weight) {
  const SeriesModel model = [&](std::span<const double> p, std::span<double> predicted) {
    const Law law = candidate.LawOf(p);
    for (std::size_t i = 0; i < predicted.size(); ++i) {
      predicted[i] = ModeStressMpa(law, p[0], test.mode[i], test.amount[i]);
    }
  };
  ModesLawFit out;
  out.name = candidate.name;
  out.parameter_names = candidate.Names();
  SeriesFit best;
  double least = 0.0;
  for (const auto& start : candidate.Starts(ModulusNearRestMpa(test))) {
    SeriesFit fit = FitSeries(model, test.stress_mpa, start,
                              {.weight = {weight.begin(), weight.end()}, .most_iterations = 300});
    if (!fit.converged) continue;
    std::vector<double> predicted(test.amount.size());
    model(fit.parameters, predicted);
    double cost = 0.0;
    for (std::size_t i = 0; i < predicted.size(); ++i) {
      cost += weight[i] * std::pow(predicted[i] - test.stress_mpa[i], 2);
    }
    if (best.converged && cost >= least) continue;
    least = cost;
    best = std::move(fit);
  }
  if (!best.converged) {
    out.message = "the law follows the modes from no start";
    return out;
  }
  out.converged = true;
  out.shear_modulus_mpa = best.parameters[0];
  out.law = candidate.LawOf(best.parameters);
  for (std::size_t k = 0; k < best.parameters.size(); ++k) {
    out.parameters.push_back(best.Bounded(k));
  }
  out.weighted_rms_mpa = std::sqrt(least / static_cast<double>(test.amount.size()));
  out.independent_rows = best.effective_samples;
  Judge(test, out);
  return out;
}

/// The block "law" of an elasticity table.
json LawBlock(const Law& law) {
  json block = {{"model", std::string(mechanics::LawName(law.kind))}, {"source", "acus-fit"}};
  switch (law.kind) {
    case LawKind::kNeoHookean:
      break;
    case LawKind::kYeoh:
      block["c2_kpa"] = 1e3 * law.c2_mpa;
      block["c3_kpa"] = 1e3 * law.c3_mpa;
      break;
    case LawKind::kKnowles:
      block["power"] = law.power_n;
      [[fallthrough]];
    case LawKind::kFung:
      block["b"] = law.exponent_b;
      break;
    case LawKind::kOgden:
      block["exponents"] = json::array();
      block["shares"] = json::array();
      for (const mechanics::OgdenTerm& term : law.ogden) {
        if (term.share == 0.0) continue;
        block["exponents"].push_back(term.exponent);
        block["shares"].push_back(term.share);
      }
      break;
  }
  if (law.fibres.k1_mpa > 0.0) {
    block["fibres"] = {
        {"k1_kpa", 1e3 * law.fibres.k1_mpa}, {"k2", law.fibres.k2}, {"direction", {0, 0, 1}}};
  }
  return block;
}

std::string Percent(double share) {
  return FixedText(100.0 * share, 1);
}

}  // namespace

std::string_view NameOf(LoadMode mode) noexcept {
  switch (mode) {
    case LoadMode::kTension:
      return "tension";
    case LoadMode::kCompression:
      return "compression";
    case LoadMode::kShear:
      return "shear";
  }
  return "";
}

std::size_t ModesTest::CountOf(LoadMode wanted) const {
  return static_cast<std::size_t>(std::ranges::count(mode, wanted));
}

ModesTest ReadModesTest(const std::filesystem::path& path) {
  const CsvTable table(path);
  ModesTest test;
  test.name = path.stem().string();
  const std::vector<std::string> modes = table.Texts("mode");
  test.amount = table.Numbers("stretch_or_shear");
  test.stress_mpa = StressesMpa(table);
  for (std::size_t row = 0; row < test.amount.size(); ++row) {
    test.mode.push_back(ModeOf(modes[row], test.amount[row], table.Where(row)));
    RequirePlausible(test.mode[row], test.amount[row], table.Where(row));
  }
  ACUS_REQUIRE(test.amount.size() >= kFewestRows, path.string(), ": has ", test.amount.size(),
               " rows; at least ", kFewestRows, " are needed");
  const auto num_modes =
      std::ranges::count_if(kLoadModes, [&test](LoadMode mode) { return test.CountOf(mode) > 1; });
  ACUS_REQUIRE(num_modes > 1, path.string(),
               ": holds a single mode; a law for several modes needs two of tension, compression "
               "and shear. For tension alone: --models hyperelastic");
  return test;
}

double ModeStressMpa(const Law& law, double shear_modulus_mpa, LoadMode mode,
                     double amount) noexcept {
  Eigen::Matrix3d f = Eigen::Matrix3d::Identity();
  if (mode == LoadMode::kShear) {
    f(0, 2) = amount;
    return mechanics::ShapeStressMpa(law, shear_modulus_mpa, f)(0, 2);
  }
  const double across = 1.0 / std::sqrt(amount);
  f.diagonal() << across, across, amount;
  const Eigen::Matrix3d stress = mechanics::ShapeStressMpa(law, shear_modulus_mpa, f);
  // The pressure is such that the sides are free.
  return stress(2, 2) - stress(0, 0) * across / amount;
}

ModesFit FitModes(const ModesTest& test) {
  ModesFit out;
  const std::vector<double> weight = WeightsOf(test);
  const ModesLawFit* closest = nullptr;
  for (const Candidate& candidate : Candidates()) {
    out.laws.push_back(FitLaw(candidate, test, weight));
  }
  for (const ModesLawFit& law : out.laws) {
    if (!law.converged) continue;
    if (closest == nullptr || law.weighted_rms_mpa < closest->weighted_rms_mpa) closest = &law;
  }
  for (std::size_t k = 0; k < out.laws.size(); ++k) {
    ModesLawFit& law = out.laws[k];
    if (!law.converged) continue;
    // All with the number of the law that leaves the least structure.
    law.aic = 2.0 * closest->independent_rows * std::log(std::max(law.weighted_rms_mpa, 1e-12)) +
              2.0 * static_cast<double>(law.parameters.size() + 1);
    if (!out.best || law.aic < out.laws[*out.best].aic) out.best = k;
  }
  out.converged = out.best.has_value();
  if (!out.converged) out.message = "no law follows the modes";
  return out;
}

json ModesJson(const ModesTest& test, const ModesFit& fit) {
  json laws = json::array();
  for (const ModesLawFit& law : fit.laws) {
    json& block = laws.emplace_back(json{{"name", law.name}, {"answered", law.converged}});
    if (!law.converged) {
      block["why_not"] = law.message;
      continue;
    }
    for (std::size_t k = 0; k < law.parameters.size(); ++k) {
      block["parameters"][law.parameter_names[k]] = EstimateJson(law.parameters[k]);
    }
    block["relative_rms"] = law.relative_rms;
    for (const LoadMode mode : kLoadModes) {
      if (test.CountOf(mode) == 0) continue;
      block["relative_rms_of"][std::string(NameOf(mode))] =
          law.relative_rms_of[static_cast<std::size_t>(mode)];
    }
    block["aic"] = law.aic;
    block["elasticity_row"] = {
        {"youngs_modulus_kpa", 2e3 * (1.0 + kIncompressibleRatio) * law.shear_modulus_mpa},
        {"poissons_ratio", kIncompressibleRatio},
        {"law", LawBlock(law.law)}};
  }
  json result = {{"name", test.name}, {"laws", laws}};
  if (fit.best) result["best"] = fit.laws[*fit.best].name;
  if (!fit.converged) result["why_not"] = fit.message;
  return result;
}

report::Plot ModesPlot(const ModesTest& test, const ModesFit& fit) {
  report::Plot plot{.title = test.name,
                    .x_label = "stretch - 1, or amount of shear",
                    .y_label = "nominal stress [kPa]"};
  const auto strain_of = [&test](std::size_t i) {
    return test.mode[i] == LoadMode::kShear ? test.amount[i] : test.amount[i] - 1.0;
  };
  for (const bool is_shear : {false, true}) {
    std::vector<std::size_t> rows;
    for (std::size_t i = 0; i < test.mode.size(); ++i) {
      if ((test.mode[i] == LoadMode::kShear) == is_shear) rows.push_back(i);
    }
    std::ranges::sort(rows, {}, strain_of);
    const std::string of = is_shear ? "shear" : "tension and compression";
    report::Series measured{.name = of + ", measured"};
    report::Series fitted{.name = of + ", best law"};
    for (const std::size_t i : rows) {
      measured.x.push_back(strain_of(i));
      measured.y.push_back(1e3 * test.stress_mpa[i]);
      if (!fit.best) continue;
      const ModesLawFit& law = fit.laws[*fit.best];
      fitted.x.push_back(strain_of(i));
      fitted.y.push_back(
          1e3 * ModeStressMpa(law.law, law.shear_modulus_mpa, test.mode[i], test.amount[i]));
    }
    if (rows.empty()) continue;
    plot.series.push_back(std::move(measured));
    if (fit.best) plot.series.push_back(std::move(fitted));
  }
  return plot;
}

std::string ModesTable(std::span<const ModesTest> tests, std::span<const ModesFit> fits) {
  std::vector<std::vector<std::string>> rows;
  for (std::size_t i = 0; i < tests.size(); ++i) {
    for (std::size_t k = 0; k < fits[i].laws.size(); ++k) {
      const ModesLawFit& law = fits[i].laws[k];
      std::vector<std::string> row{tests[i].name, law.name};
      if (!law.converged) {
        row.insert(row.end(), {"-", "-", "-", "-", "no answer: " + law.message});
        rows.push_back(std::move(row));
        continue;
      }
      row.push_back(Percent(law.relative_rms));
      for (const LoadMode mode : kLoadModes) {
        row.push_back(tests[i].CountOf(mode) > 0
                          ? Percent(law.relative_rms_of[static_cast<std::size_t>(mode)])
                          : "-");
      }
      row.push_back(fits[i].best == k ? "best" : "");
      rows.push_back(std::move(row));
    }
  }
  return TextTable(
             {"specimen", "law", "rms [%]", "tension [%]", "compression [%]", "shear [%]", ""},
             rows) +
         "\nRMS error over the RMS of the measured stress. 'best' is the law with the least "
         "Akaike\ncriterion; fit.json has each law as a row of an elasticity table. Fibres "
         "are taken\nalong the tension.\n";
}

}  // namespace acus::fitting
