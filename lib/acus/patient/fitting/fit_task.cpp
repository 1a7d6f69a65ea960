#include "acus/patient/fitting/fit_task.h"

#include <algorithm>
#include <cctype>
#include <nlohmann/json.hpp>
#include <optional>

#include "acus/base/config/json_file.h"
#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "acus/data/volume/labels.h"
#include "acus/patient/fitting/fit_models.h"
#include "acus/patient/fitting/fit_report.h"
#include "acus/patient/fitting/fitted_table.h"
#include "acus/patient/fitting/indentation_fit.h"
#include "acus/patient/fitting/measured_fit.h"
#include "acus/patient/fitting/modes_fit.h"
#include "acus/patient/fitting/tension_fit.h"

namespace acus::fitting {
namespace {

namespace fs = std::filesystem;

void WritePlots(const fs::path& folder, const FittedCurve& fitted) {
  const std::string& name = fitted.curve.name;
  report::WriteSvg(folder / (name + "_over_time.svg"),
                   PuncturePlots(fitted, fitted.curve.time_s, "time [s]"));
  if (!fitted.gaussians && !fitted.mechanical && !fitted.lugre) return;
  report::WriteSvg(folder / (name + "_models.svg"), DepthPlots(fitted));
  report::WriteSvg(folder / (name + "_replay.svg"), TimePlots(fitted));
}

forces::ForceColumn ColumnFrom(const nlohmann::json& row) {
  std::string unit = row.at("unit");
  std::ranges::transform(unit, unit.begin(), [](unsigned char c) { return std::tolower(c); });
  return {.column = row.at("column"), .unit = unit, .sign = row.at("sign").get<double>()};
}

forces::ForceColumns ColumnsFrom(const fs::path& file) {
  if (file.empty()) return {};
  const auto mapping = config::ReadConfig(config::FindConfig(file, "."), "acus-force-columns");
  return {.time = ColumnFrom(mapping.at("time")),
          .depth = ColumnFrom(mapping.at("depth")),
          .force = ColumnFrom(mapping.at("force"))};
}

/// Reads one recording; two of a name would overwrite each other's plots.
/// @param taken  Takes a line on what was read, where the file is not in the plain form.
ForceCurve ReadNamed(const fs::path& input, const FitTask& task, std::vector<std::string>& names,
                     std::string& taken) {
  ForceCurve curve = forces::ReadForceCurve(input, ColumnsFrom(task.columns), task.as_it_is);
  if (!curve.how_read.empty()) taken += Message(input.string(), ": ", curve.how_read, "\n");
  ACUS_REQUIRE(std::ranges::find(names, curve.name) == names.end(), input.string(),
               ": another curve is named '", curve.name, "' too; rename one");
  names.push_back(curve.name);
  return curve;
}

/// Files that are broken, and recordings without an answer: the others are predicted without them.
class Missing {
 public:
  /// Runs what may throw for one input. False if it did.
  template <typename Action>
  bool Try(const fs::path& input, const Action& action) {
    try {
      action();
      return true;
    } catch (const InputError& error) {
      if (!broken_) broken_ = error;
      text_ += Message("\n  ", error.what());
    } catch (const NoAnswerError& error) {
      text_ += Message("\n  ", input.string(), ": ", error.what());
    }
    return false;
  }

  /// @throws InputError or NoAnswerError if nothing was predicted.
  void Report(bool any_predicted, RunContext& context) const {
    if (!any_predicted && broken_) throw InputError(*broken_);
    if (!any_predicted) {
      throw NoAnswerError("no recording could be predicted, nothing is written:" + text_);
    }
    if (!text_.empty()) context.Warn("the others are predicted, but not these:" + text_);
  }

 private:
  std::string text_;
  std::optional<InputError> broken_;
};

void Advance(const char* what, std::size_t i, const FitTask& task, RunContext& context) {
  context.Checkpoint(what, static_cast<double>(i) / static_cast<double>(task.inputs.size()));
  context.provenance.AddInput(task.inputs[i]);
}

std::string RunPrediction(const FitTask& task, RunContext& context) {
  const SavedFit fit = ReadSavedFit(task.predict);
  const bool is_folder = fs::is_directory(task.predict);
  context.provenance.AddInput(is_folder ? task.predict / "measured.json" : task.predict);
  AtomicFolder folder(task.output, context.overwrite);
  std::vector<PredictedCurve> predicted;
  std::vector<std::string> names;
  nlohmann::json curves = nlohmann::json::array();
  Missing missing;
  std::string taken;
  for (std::size_t i = 0; i < task.inputs.size(); ++i) {
    Advance("predicting", i, task, context);
    const bool is_predicted = missing.Try(task.inputs[i], [&] {
      predicted.push_back(Predict(fit, ReadNamed(task.inputs[i], task, names, taken)));
    });
    if (!is_predicted) continue;
    curves.push_back(PredictionJson(predicted.back()));
    report::WriteSvg(folder.path() / (predicted.back().curve.name + "_predicted.svg"),
                     PredictionPlot(predicted.back()));
  }
  missing.Report(!predicted.empty(), context);
  config::WriteJson(folder.path() / "prediction.json", {{"fitted_recordings", fit.band.recordings},
                                                        {"factor", fit.band.factor},
                                                        {"curves", curves}});
  config::WriteJson(folder.path() / "provenance.json", context.provenance.ToJson());
  folder.Commit();
  return taken + PredictionTable(predicted);
}

/// A file that only some recordings allow: without it the rest is written all the same.
template <typename Make>
void WriteIfAny(const fs::path& file, nlohmann::json& document, RunContext& context,
                const Make& make) {
  const std::string key = file.filename().string();
  try {
    config::WriteJson(file, make());
    document["files"][key] = {{"written", true}};
  } catch (const NoAnswerError& error) {
    document["files"][key] = {{"written", false}, {"why_not", error.what()}};
    context.Warn(Message(key, " is not written: ", error.what()));
  }
}

bool AnythingAnswers(std::span<const FittedCurve> fits) {
  return std::ranges::any_of(fits, [](const FittedCurve& fit) {
    return std::ranges::any_of(AnswersOf(fit), &ModelAnswer::has_answer);
  });
}

std::string RunFits(const FitTask& task, RunContext& context) {
  if (!task.tissue.empty()) volume::LabelOf(task.tissue);
  const FitModels models = FitModels::FromNames(task.models);
  AtomicFolder folder(task.output, context.overwrite);
  std::vector<FittedCurve> fits;
  std::vector<PunctureCurveFit> punctures;
  std::vector<std::string> names;
  std::vector<report::Plot> overview;
  nlohmann::json results = nlohmann::json::array();
  std::string missing, taken;
  for (std::size_t i = 0; i < task.inputs.size(); ++i) {
    Advance("fitting", i, task, context);
    const FittedCurve& fit =
        fits.emplace_back(FitModelsTo(ReadNamed(task.inputs[i], task, names, taken), models));
    punctures.push_back(fit.puncture);
    missing += MissingAnswers(task.inputs[i].string(), fit);
    results.push_back(CurveJson(fit));
    const auto plots = PuncturePlots(fit, fit.curve.depth_mm, "depth [mm]");
    overview.insert(overview.end(), plots.begin(), plots.end());
    WritePlots(folder.path(), fit);
  }
  if (!AnythingAnswers(fits)) {
    throw NoAnswerError("no model has an answer for any curve, nothing is written:" + missing);
  }
  if (!missing.empty()) {
    context.Warn("all else is fitted, but these models have no answer:" + missing);
  }
  nlohmann::json document = TogetherJson(fits, models);
  document["curves"] = results;
  if (models.mechanical) {
    WriteIfAny(folder.path() / "measured.json", document, context, [&] {
      nlohmann::json measured = MeasuredJson(fits, task.diameter_mm);
      measured["provenance"] = context.provenance.ToJson();
      return measured;
    });
  }
  if (!task.tissue.empty()) {
    const auto base = config::ReadJson(config::FindConfig("forces/default.json", "."));
    WriteIfAny(folder.path() / "forces.json", document, context, [&] {
      std::vector<const ForceCurve*> curves;
      for (const FittedCurve& fit : fits) curves.push_back(&fit.curve);
      return FittedTable(base, task.tissue, curves, punctures, task.diameter_mm);
    });
  }
  config::WriteJson(folder.path() / "fit.json", document);
  report::WriteSvg(folder.path() / "fit.svg", overview);
  config::WriteJson(folder.path() / "provenance.json", context.provenance.ToJson());
  folder.Commit();
  return taken + FitTable(punctures) + ModelTable(fits);
}

/// What was read and fitted, one after the other.
template <typename Test, typename Fit>
struct Specimens {
  std::vector<Test> tests;
  std::vector<Fit> fits;
  nlohmann::json documents = nlohmann::json::array();
};

/// How specimens of one kind are read, described and drawn.
template <typename Test, typename Fit>
struct SpecimenKind {
  Test (*read)(const fs::path&);
  nlohmann::json (*describe)(const Test&, const Fit&);
  report::Plot (*draw)(const Test&, const Fit&);
  const char* plot_ending;
};

constexpr SpecimenKind<TensionTest, TensionFit> kTensions{ReadTensionTest, TensionJson, TensionPlot,
                                                          "_tension.svg"};
constexpr SpecimenKind<IndentationTest, IndentationFit> kIndentations{
    ReadIndentationTest, IndentationJson, IndentationPlot, "_indentation.svg"};
constexpr SpecimenKind<ModesTest, ModesFit> kModes{ReadModesTest, ModesJson, ModesPlot,
                                                   "_modes.svg"};

/// Reads, fits and draws every specimen into the folder. @param fit_one  a Fit of a test.
/// @param needs_all  A file that is broken stops it; otherwise the others are used without it.
/// @throws NoAnswerError if no specimen has an answer.
template <typename Test, typename Fit, typename FitOne>
Specimens<Test, Fit> FitSpecimens(const FitTask& task, RunContext& context,
                                  const AtomicFolder& folder, const SpecimenKind<Test, Fit>& kind,
                                  const FitOne& fit_one, bool needs_all) {
  Specimens<Test, Fit> out;
  Missing missing;
  std::vector<std::string> names;
  for (std::size_t i = 0; i < task.inputs.size(); ++i) {
    Advance("fitting", i, task, context);
    const auto read = [&] { out.tests.push_back(kind.read(task.inputs[i])); };
    if (needs_all) {
      read();
    } else if (!missing.Try(task.inputs[i], read)) {
      continue;
    }
    const Test& test = out.tests.back();
    ACUS_REQUIRE(std::ranges::find(names, test.name) == names.end(), task.inputs[i].string(),
                 ": another specimen is named '", test.name, "' too; rename one");
    names.push_back(test.name);
    const Fit& fit = out.fits.emplace_back(fit_one(test));
    out.documents.push_back(kind.describe(test, fit));
    report::WriteSvg(folder.path() / (test.name + kind.plot_ending), kind.draw(test, fit));
    if (!fit.converged) {
      context.Warn(Message(task.inputs[i].string(), ": no answer: ", fit.message));
    }
  }
  missing.Report(!out.tests.empty(), context);
  if (!std::ranges::any_of(out.fits, &Fit::converged)) {
    throw NoAnswerError("no law has an answer for any specimen, nothing is written: " +
                        out.fits.front().message);
  }
  return out;
}

/// --models of specimens that no needle pierced. @param what  "tension tests".
void RequireAlone(const FitTask& task, const char* model, const char* what) {
  ACUS_REQUIRE(task.models.size() == 1 && task.tissue.empty(), "--models ", model, " is for ", what,
               ", not for recordings of a needle; give it alone, without --tissue");
}

/// Each specimen by itself. @param fit_one  a Fit of a Test. @returns the table.
template <typename Test, typename Fit>
std::string RunSpecimens(const FitTask& task, RunContext& context,
                         const SpecimenKind<Test, Fit>& kind, Fit (*fit_one)(const Test&),
                         std::string (*table)(std::span<const Test>, std::span<const Fit>)) {
  AtomicFolder folder(task.output, context.overwrite);
  const auto specimens = FitSpecimens(task, context, folder, kind, fit_one, true);
  config::WriteJson(folder.path() / "fit.json", {{"specimens", specimens.documents}});
  config::WriteJson(folder.path() / "provenance.json", context.provenance.ToJson());
  folder.Commit();
  return table(specimens.tests, specimens.fits);
}

std::string RunTensions(const FitTask& task, RunContext& context) {
  RequireAlone(task, "hyperelastic", "tension tests");
  return RunSpecimens(task, context, kTensions, FitTension, TensionTable);
}

std::string RunModes(const FitTask& task, RunContext& context) {
  RequireAlone(task, "modes", "tests of one tissue in tension, compression and shear");
  return RunSpecimens(task, context, kModes, FitModes, ModesTable);
}

/// @param fit_one  an IndentationFit of a test.
template <typename FitOne>
std::string RunIndentationTests(const FitTask& task, RunContext& context, const FitOne& fit_one,
                                bool is_shared) {
  AtomicFolder folder(task.output, context.overwrite);
  const auto specimens = FitSpecimens(task, context, folder, kIndentations, fit_one, is_shared);
  nlohmann::json document = {{"specimens", specimens.documents}};
  if (is_shared) document["shared"] = ShapeJson(FitSharedShape(specimens.tests, specimens.fits));
  config::WriteJson(folder.path() / (is_shared ? "fit.json" : "prediction.json"), document);
  config::WriteJson(folder.path() / "provenance.json", context.provenance.ToJson());
  folder.Commit();
  return IndentationTable(specimens.tests, specimens.fits);
}

std::string RunIndentations(const FitTask& task, RunContext& context) {
  RequireAlone(task, "indentation", "indentations");
  return RunIndentationTests(task, context, FitIndentation, true);
}

/// The shared shape of a saved fit of indentations; empty for fits of needles.
std::optional<IndentationShape> SavedShape(const fs::path& fit, RunContext& context) {
  const fs::path file = fs::is_directory(fit) ? fit / "fit.json" : fit;
  if (fs::exists(fit / "measured.json") || !fs::exists(file)) return {};
  const nlohmann::json document = config::ReadJson(file);
  if (!document.contains("shared")) return {};
  context.provenance.AddInput(file);
  return ShapeFromJson(document["shared"], file.string());
}

}  // namespace

std::string RunFit(const FitTask& task, RunContext& context) {
  if (!task.predict.empty()) {
    const auto shape = SavedShape(task.predict, context);
    if (!shape) return RunPrediction(task, context);
    return RunIndentationTests(
        task, context, [&](const IndentationTest& test) { return FitWithShape(test, *shape); },
        false);
  }
  const auto asks_for = [&](const char* model) {
    return std::ranges::find(task.models, model) != task.models.end();
  };
  if (asks_for("hyperelastic")) return RunTensions(task, context);
  if (asks_for("modes")) return RunModes(task, context);
  return asks_for("indentation") ? RunIndentations(task, context) : RunFits(task, context);
}

}  // namespace acus::fitting
