#include "acus/run/launcher/workplaces.h"

#include <algorithm>
#include <regex>

#include "acus/base/config/json_file.h"
#include "acus/base/core/error.h"
#include "acus/run/training/assessment.h"

namespace acus::launcher {
namespace {

namespace fs = std::filesystem;

std::vector<fs::path> Sorted(const fs::path& folder) {
  std::error_code error;
  std::vector<fs::path> entries;
  for (const auto& entry : fs::directory_iterator(folder, error)) entries.push_back(entry.path());
  std::ranges::sort(entries);
  return entries;
}

void ReadExercises(Workplace& workplace) {
  for (const fs::path& file : Sorted(workplace.folder / "exercises")) {
    if (file.extension() != ".json") continue;
    const training::Exercise exercise = training::ReadExercise(file);
    workplace.exercises.push_back({file.stem().string(), exercise.name, exercise.instructions});
  }
  ACUS_REQUIRE(!workplace.exercises.empty(), (workplace.folder / "exercises").string(),
               ": there is no exercise; copy one from the presets (acus list exercises)");
}

Workplace ReadWorkplace(const fs::path& folder) {
  Workplace workplace;
  workplace.folder = folder;
  workplace.name = folder.filename().string();
  for (const fs::path& sessions : Sorted(folder / "sessions")) {
    if (fs::is_directory(sessions)) workplace.trainees.push_back(sessions.filename().string());
  }
  try {
    workplace.patient = config::ReadJson(folder / "scenario.json").value("name", workplace.name);
    ReadExercises(workplace);
  } catch (const InputError& error) {
    workplace.trouble = error.what();
  } catch (const nlohmann::json::exception&) {
    workplace.trouble = (folder / "scenario.json").string() + ": is no scenario";
  }
  return workplace;
}

/// "2026-11-28 17:20" from "2026-11-28_17-20-00", or "2026-11-28_17-20-00.2".
std::string TimeText(std::string name) {
  std::ranges::replace(name, '_', ' ');
  std::replace(name.begin() + 11, name.end(), '-', ':');
  return name.substr(0, 16);
}

}  // namespace

std::vector<Workplace> FindWorkplaces(const fs::path& folder) {
  std::vector<Workplace> workplaces;
  const auto add = [&](const fs::path& place) {
    if (fs::exists(place / "scenario.json")) workplaces.push_back(ReadWorkplace(place));
  };
  add(fs::absolute(folder).lexically_normal());
  for (const fs::path& place : Sorted(folder)) add(fs::absolute(place).lexically_normal());
  return workplaces;
}

std::vector<Trial> TrialsOf(const Workplace& workplace, const std::string& trainee,
                            const std::string& exercise) {
  static const std::regex kName(R"((\d{4}-\d{2}-\d{2}_\d{2}-\d{2}-\d{2}(?:\.\d+)?)_(.+))");
  std::vector<Trial> trials;
  for (const fs::path& folder : Sorted(workplace.folder / "sessions" / trainee)) {
    std::smatch match;
    const std::string name = folder.filename().string();
    const fs::path report = folder / "report" / "training.json";
    if (!std::regex_match(name, match, kName) || match[2] != exercise || !fs::exists(report) ||
        fs::exists(folder / "discarded.json")) {
      continue;
    }
    try {
      const training::Assessment assessment = training::ReadAssessment(report);
      trials.push_back({folder, TimeText(match[1]), assessment.NumMet(), assessment.goals.size(),
                        assessment.Passed()});
    } catch (const InputError&) {
      continue;  // A report that is being written, or of another version.
    }
  }
  return trials;
}

fs::path ProgressPage(const Workplace& workplace, const std::string& trainee,
                      const std::string& exercise) {
  return workplace.folder / "sessions" / trainee / ("progress_" + exercise) / "progress.html";
}

bool IsTraineeCode(const std::string& code) {
  const auto is_allowed = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' ||
           c == '_';
  };
  return !code.empty() && std::ranges::all_of(code, is_allowed);
}

}  // namespace acus::launcher
