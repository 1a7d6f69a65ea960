#include "acus/assess/study/study_export.h"

#include <algorithm>
#include <cctype>
#include <set>

#include "acus/base/config/json_file.h"
#include "acus/base/core/atomic_file.h"
#include "acus/base/core/csv.h"
#include "acus/base/core/error.h"
#include "acus/base/core/text_table.h"

namespace acus::study {
namespace {

namespace fs = std::filesystem;

/// Letters and digits only, as labels of BIDS: "Liver biopsy" is LiverBiopsy.
std::string BidsLabel(const std::string& text) {
  std::string label;
  bool upper = true;
  for (const char c : text) {
    const auto code = static_cast<unsigned char>(c);
    if (std::isalnum(code) == 0) {
      upper = true;
      continue;
    }
    label += upper ? static_cast<char>(std::toupper(code)) : c;
    upper = false;
  }
  return label;
}

std::string ParticipantsTsv(const Study& study) {
  std::string tsv = "participant_id\tgroup\thand\n";
  std::set<std::string> labels;
  for (const Participant& person : study.participants) {
    if (!person.consent) continue;
    const std::string label = BidsLabel(person.code);
    ACUS_REQUIRE(labels.insert(label).second, study.file.string(), ": the code ", person.code,
                 " is that of another participant without its underscores");
    tsv += "sub-" + label + "\t" + person.group + "\t" + person.hand + "\n";
  }
  return tsv;
}

/// name_with_unit, as columns of BIDS are named.
std::string ColumnName(const MetricKey& metric) {
  std::string name = metric.name;
  std::ranges::replace_if(
      name, [](char c) { return std::isalnum(static_cast<unsigned char>(c)) == 0; }, '_');
  return name;
}

std::string MetricsTsv(const TrialRecord& trial) {
  std::string header, row;
  for (const auto& [metric, value] : trial.metrics) {
    header += (header.empty() ? "" : "\t") + ColumnName(metric);
    row += (row.empty() ? "" : "\t") + NumberText(value);
  }
  return header + "\n" + row + "\n";
}

std::string EventsTsv(const fs::path& events) {
  const CsvTable table(events);
  const auto time = table.Numbers("time_s"), depth = table.Numbers("depth_mm"),
             force = table.Numbers("force_axial_n");
  const auto event = table.Texts("event"), tissue = table.Texts("tissue");
  std::string tsv = "onset\tduration\ttrial_type\ttissue\tdepth_mm\tforce_axial_n\n";
  for (std::size_t row = 0; row < table.num_rows(); ++row) {
    tsv += NumberText(time[row]) + "\t0\t" + event[row] + "\t" + tissue[row] + "\t" +
           NumberText(depth[row]) + "\t" + NumberText(force[row]) + "\n";
  }
  return tsv;
}

}  // namespace

void WriteBids(const fs::path& folder, const Study& study, std::span<const TrialRecord> trials,
               const RunContext& context) {
  config::WriteJson(folder / "dataset_description.json",
                    {{"Name", study.name},
                     {"BIDSVersion", "1.8.0"},
                     {"DatasetType", "raw"},
                     {"GeneratedBy", {{{"Name", "acus-study"}}}}});
  WriteTextFile(folder / "participants.tsv", ParticipantsTsv(study));
  std::map<std::string, nlohmann::json> units;
  for (const TrialRecord& trial : trials) {
    const std::string label = BidsLabel(trial.code);
    const std::string task = BidsLabel(trial.exercise);
    const fs::path beh = folder / ("sub-" + label) / "beh";
    fs::create_directories(beh);
    const std::string run = Message(trial.trial < 10 ? "0" : "", trial.trial);
    const std::string stem = "sub-" + label + "_task-" + task + "_run-" + run;
    WriteTextFile(beh / (stem + "_beh.tsv"), MetricsTsv(trial));
    for (const auto& [metric, value] : trial.metrics) {
      units[task][ColumnName(metric)] = {{"LongName", metric.name}, {"Units", metric.unit}};
    }
    const fs::path events = trial.folder / "events.csv";
    if (!trial.folder.empty() && fs::exists(events)) {
      WriteTextFile(beh / (stem + "_events.tsv"), EventsTsv(events));
    }
  }
  for (const auto& [task, columns] : units) {
    config::WriteJson(folder / ("task-" + task + "_beh.json"), columns);
  }
  config::WriteJson(folder / "provenance.json", context.provenance.ToJson());
}

}  // namespace acus::study
