#include "acus/patient/breathing_registration/phase_files.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <functional>
#include <regex>
#include <set>

#include "acus/base/core/csv.h"
#include "acus/base/core/number_text.h"
#include "acus/base/core/words.h"
#include "acus/data/volume/scalar_file.h"
#include "acus/data/volume/volume_io.h"
#include "acus/physics/breathing/breathing_pattern.h"

namespace acus::breathing_registration {
namespace {

namespace fs = std::filesystem;
using breathing::Breath;

constexpr std::size_t kFewestPhases = 4;

PhaseFiles FromTable(const fs::path& folder) {
  const CsvTable table(folder / "phases.csv");
  const auto files = table.Texts("file");
  const auto cycle = table.Numbers("cycle");
  const auto level = table.Numbers("level");
  const auto rate = table.Numbers("level_per_s");
  const auto use =
      table.Has("use") ? table.Texts("use") : std::vector<std::string>(files.size(), "phase");
  PhaseFiles out;
  for (std::size_t n = 0; n < files.size(); ++n) {
    const fs::path path = folder / files[n];
    ACUS_REQUIRE(fs::exists(path), table.Where(n), ": the phase ", path.string(),
                 " is missing; put it there or take its row out");
    ACUS_REQUIRE(use[n] == "phase" || use[n] == "deeper", table.Where(n), ": use is '", use[n],
                 "'; it must be phase or deeper");
    ACUS_REQUIRE(cycle[n] >= 0.0 && cycle[n] < 1.0, table.Where(n), ": cycle is ", cycle[n],
                 "; it must be in [0, 1)");
    PhaseFile phase{.name = files[n],
                    .path = path,
                    .series = {},
                    .breath = {.cycle = cycle[n], .level = level[n], .level_per_s = rate[n]}};
    if (use[n] == "deeper") {
      out.deeper = std::move(phase);
    } else {
      out.phases.push_back(std::move(phase));
    }
  }
  std::ranges::stable_sort(out.phases, {}, [](const PhaseFile& p) { return p.breath.cycle; });
  return out;
}

/// The number of a phase in a name, as scanners write it: before "%" or "pct" ("20.0%A", "33,3 %",
/// "CT_20_pct_ex"), or after "T=" or "phase".
std::optional<double> StatedNumber(const std::string& name) {
  static const std::regex kPercent("([0-9]{1,3})([.,]([0-9]{1,6}))?[ _]*(%|pct|percent|prct)",
                                   std::regex::icase);
  static const std::regex kNamed("(t ?=|phase|\\bph)[ _]*([0-9]{1,9})", std::regex::icase);
  std::smatch found;
  if (std::regex_search(name, found, kPercent)) {
    return ParseFinite(found[1].str() + "." + (found[3].length() > 0 ? found[3].str() : "0"));
  }
  if (std::regex_search(name, found, kNamed)) return std::stod(found[2]);
  return std::nullopt;
}

/// The stated number of a phase, else the last one in the name. What a series is split by, in
/// brackets at its end, comes first. Nothing if there is none.
std::optional<double> NumberIn(const std::string& name) {
  const std::size_t open = name.ends_with(']') ? name.rfind('[') : name.npos;
  if (open != name.npos) {
    const auto inside = NumberIn(name.substr(open + 1, name.size() - open - 2));
    if (inside) return inside;
  }
  if (const auto stated = StatedNumber(name)) return stated;
  std::size_t end = name.size();
  while (end > 0 && std::isdigit(static_cast<unsigned char>(name[end - 1])) == 0) --end;
  std::size_t begin = end;
  while (begin > 0 && std::isdigit(static_cast<unsigned char>(name[begin - 1])) != 0) --begin;
  if (begin == end || end - begin > 9) return std::nullopt;
  return std::stod(name.substr(begin, end - begin));
}

/// The volumes of one file over time, in its order.
std::vector<PhaseFile> VolumesOf(const fs::path& file) {
  std::vector<PhaseFile> phases;
  const int count = volume::NumVolumes(file);
  for (int n = 1; n <= count; ++n) {
    phases.push_back({.name = Message("phase ", n),
                      .path = file,
                      .series = count == 1 ? "" : std::to_string(n),
                      .breath = {}});
  }
  return phases;
}

/// Averages and projections over the breath are no phases of it.
bool IsOverAllPhases(const volume::DicomSeries& series) {
  static const std::regex kOver("(^|[^a-z])(avg|ave|average|mean|mip|minip)([^a-z]|$)",
                                std::regex::icase);
  return std::regex_search(series.description, kOver);
}

/// In the order of the numbers in the names, which must be evenly spaced; by name without numbers.
/// @throws InputError if some names have numbers and others none, such as a CT for planning.
void SortByNumber(std::vector<PhaseFile>& phases, const fs::path& folder) {
  const auto is_numbered = [](const PhaseFile& phase) { return NumberIn(phase.name).has_value(); };
  const auto other = std::ranges::find_if_not(phases, is_numbered);
  const auto numbered = std::ranges::find_if(phases, is_numbered);
  if (numbered == phases.end()) {
    std::ranges::sort(phases, {}, &PhaseFile::name);
    return;
  }
  ACUS_REQUIRE(other == phases.end(), folder.string(), ": '", other->name,
               "' has no number of a phase, '", numbered->name,
               "' has; is it a phase? Keep it elsewhere if it is none, otherwise say in phases.csv "
               "where in the breath each phase lies");
  std::ranges::stable_sort(phases, {}, [](const PhaseFile& p) { return *NumberIn(p.name); });
  constexpr double kRounding = 0.11;  // Of "33.3%".
  double step = 0.0;
  for (std::size_t n = 1; n < phases.size(); ++n) {
    const double here = *NumberIn(phases[n].name) - *NumberIn(phases[n - 1].name);
    step = n == 1 ? here : std::min(step, here);
  }
  for (std::size_t n = 1; n < phases.size(); ++n) {
    const double here = *NumberIn(phases[n].name) - *NumberIn(phases[n - 1].name);
    ACUS_REQUIRE(
        here - step <= kRounding && step > 2.0 * kRounding, folder.string(), ": between ",
        phases[n - 1].name, " and ", phases[n].name,
        " a phase is missing or given twice: the numbers are not evenly spaced; add it, or "
        "say in phases.csv where in the breath each phase lies");
  }
}

std::vector<PhaseFile> VolumesIn(const fs::path& folder) {
  std::vector<PhaseFile> phases;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const fs::path& path = entry.path();
    if (!entry.is_regular_file() || !volume::IsScalarFileName(path)) continue;
    const std::string name = path.filename().string();
    if (name.starts_with('.') || name.find(".seg.") != std::string::npos) continue;
    phases.push_back({.name = volume::VolumeStem(path), .path = path, .series = {}, .breath = {}});
  }
  if (phases.size() == 1) return VolumesOf(phases.front().path);
  SortByNumber(phases, folder);
  return phases;
}

/// Removes series that state no number of a phase, if four or more do. @returns their names.
std::string WithoutOthers(std::vector<volume::DicomSeries>& series) {
  const auto is_stated = [](const volume::DicomSeries& s) {
    return StatedNumber(s.description).has_value() || s.temporal_position > 0;
  };
  const auto stated = static_cast<std::size_t>(std::ranges::count_if(series, is_stated));
  if (stated < kFewestPhases) return {};
  std::vector<std::string> others;
  for (const volume::DicomSeries& s : series) {
    if (!is_stated(s)) others.push_back(s.description.empty() ? s.uid : s.description);
  }
  std::erase_if(series, std::not_fn(is_stated));
  return Joined(others);
}

std::vector<PhaseFile> DicomIn(const fs::path& folder, std::string& omitted) {
  auto series = volume::ListDicomSeries(folder);
  std::erase_if(series, IsOverAllPhases);
  ACUS_REQUIRE(!series.empty(), folder.string(),
               ": holds only averages and projections over the breath, and no phase");
  const std::size_t slices = series.front().files.size();
  // Scouts and dose reports have fewer slices.
  std::erase_if(series, [&](const volume::DicomSeries& s) { return 2 * s.files.size() < slices; });
  omitted = WithoutOthers(series);
  for (const volume::DicomSeries& s : series) {
    ACUS_REQUIRE(s.files.size() == slices, folder.string(), ": series ", s.uid, " has ",
                 s.files.size(), " slices, another ", slices,
                 "; slices of a phase are missing, export the whole study again");
  }
  std::set<int> positions;
  for (const volume::DicomSeries& s : series) positions.insert(s.temporal_position);
  const bool timed = *positions.begin() > 0 && positions.size() == series.size();
  std::vector<PhaseFile> phases;
  for (const volume::DicomSeries& s : series) {
    std::string name = Message("phase ", s.temporal_position);
    if (!timed) name = s.description.empty() ? s.uid : s.description;
    phases.push_back({.name = name, .path = folder, .series = s.uid, .breath = {}});
  }
  SortByNumber(phases, folder);
  return phases;
}

/// Means of level and rate of the recorded breaths about one place in the cycle.
Breath MeanBreath(const breathing::RecordedBreath& recorded, double cycle, double half_width) {
  double level = 0.0, rate = 0.0, count = 0.0;
  for (double t = 0.0; t < recorded.duration_s(); t += 0.02) {
    const Breath breath = recorded.At(t);
    const double off = breath.cycle - cycle - std::round(breath.cycle - cycle);
    if (std::abs(off) > half_width) continue;
    level += breath.level;
    rate += breath.level_per_s;
    count += 1.0;
  }
  ACUS_REQUIRE(count > 0.0, "the signal has no breath at ", cycle, " of a cycle");
  return {.cycle = cycle, .level = level / count, .level_per_s = rate / count};
}

void SpreadOverBreath(std::vector<PhaseFile>& phases,
                      const std::optional<breathing::BreathSignal>& signal) {
  const auto count = static_cast<double>(phases.size());
  std::optional<breathing::RecordedBreath> recorded;
  if (signal) recorded.emplace(*signal, breathing::RecordedBreathSettings{});
  const breathing::BreathingPattern pattern(breathing::PatternSettings{});
  for (std::size_t n = 0; n < phases.size(); ++n) {
    const double cycle = static_cast<double>(n) / count;
    Breath& breath = phases[n].breath;
    breath = recorded ? MeanBreath(*recorded, cycle, 0.25 / count)
                      : pattern.At((1.0 + cycle) * pattern.settings().period_s);
    breath.cycle = cycle;
  }
}

}  // namespace

PhaseFiles FindPhases(const fs::path& folder,
                      const std::optional<breathing::BreathSignal>& signal) {
  const bool is_file = fs::is_regular_file(folder) && volume::IsScalarFileName(folder);
  ACUS_REQUIRE(is_file || fs::is_directory(folder), folder.string(),
               ": is not a folder; give the folder with one file, folder or series for each phase, "
               "or a NIfTI file of all");
  PhaseFiles out;
  if (is_file) {
    out.phases = VolumesOf(folder);
    SpreadOverBreath(out.phases, signal);
  } else if (fs::exists(folder / "phases.csv")) {
    out = FromTable(folder);
  } else {
    out.phases = VolumesIn(folder);
    if (out.phases.empty()) out.phases = DicomIn(folder, out.omitted);
    SpreadOverBreath(out.phases, signal);
  }
  ACUS_REQUIRE(out.phases.size() >= kFewestPhases, folder.string(), ": ", out.phases.size(),
               " phases are found; at least ", kFewestPhases, " are needed");
  for (std::size_t n = 1; n < out.phases.size(); ++n) {
    ACUS_REQUIRE(out.phases[n].breath.cycle > out.phases[n - 1].breath.cycle, folder.string(), ": ",
                 out.phases[n - 1].name, " and ", out.phases[n].name,
                 " have the same place in the breath");
  }
  return out;
}

volume::CtVolume ReadPhase(const PhaseFile& phase, const RunContext& context) {
  return volume::ReadCt(phase.path, phase.series, context);
}

}  // namespace acus::breathing_registration
