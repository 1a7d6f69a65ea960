#include "acus/assess/study/study_data.h"

#include <algorithm>
#include <cctype>
#include <set>
#include <tuple>

#include "acus/assess/study/csv_cell.h"
#include "acus/base/core/csv.h"
#include "acus/base/core/error.h"
#include "acus/base/core/number_text.h"
#include "acus/run/training/discarded.h"
#include "acus/run/training/score.h"

namespace acus::study {
namespace {

namespace fs = std::filesystem;

std::vector<fs::path> AssessmentsIn(const fs::path& folder) {
  std::vector<fs::path> files;
  if (training::IsDiscarded(folder)) return files;
  for (fs::recursive_directory_iterator entry(folder), end; entry != end; ++entry) {
    const fs::path& path = entry->path();
    if (entry->is_directory() && fs::exists(path / training::kDiscardedFile)) {
      entry.disable_recursion_pending();
    } else if (path.filename() == "training.json") {
      files.push_back(path);
    }
  }
  std::ranges::sort(files, [](const fs::path& a, const fs::path& b) {
    return NaturallyBefore(a.string(), b.string());
  });
  return files;
}

TrialRecord RecordIn(const fs::path& file) {
  TrialRecord record = RecordOf(training::ReadAssessment(file));
  record.folder = file.parent_path();
  return record;
}

/// @throws InputError with the position in the file.
void RequireListed(const TrialRecord& record, const Study& study, const std::string& where) {
  ACUS_REQUIRE(study.Find(record.code) != nullptr, where, ": the code \"", record.code,
               "\" is not among the participants of ", study.file.string());
  const bool listed = std::ranges::any_of(study.exercises, [&](const std::string& name) {
    return CsvCell(name) == CsvCell(record.exercise);
  });
  ACUS_REQUIRE(listed, where, ": the exercise \"", record.exercise, "\" is not one of ",
               study.file.string());
}

int WholeNumber(const std::string& text, const std::string& where, const char* what) {
  const auto value = ParseNumber<int>(text);
  ACUS_REQUIRE(value, where, ": ", what, " \"", text, "\" is not a whole number");
  return *value;
}

std::vector<TrialRecord> RecordsOfTable(const fs::path& path, const Study& study) {
  const CsvTable table(path);
  const auto code = table.Texts("code"), exercise = table.Texts("exercise"),
             trial = table.Texts("trial"), metric = table.Texts("metric"),
             unit = table.Texts("unit");
  const auto value = table.Numbers("value");
  // Tables of earlier versions do not have it.
  const auto is_virtual =
      table.Has("virtual") ? table.Numbers("virtual") : std::vector<double>(value.size(), 0.0);
  std::map<std::tuple<std::string, std::string, int>, TrialRecord> records;
  for (std::size_t row = 0; row < table.num_rows(); ++row) {
    const int number = WholeNumber(trial[row], table.Where(row), "the trial");
    TrialRecord& record = records[{code[row], exercise[row], number}];
    record.code = code[row];
    record.exercise = exercise[row];
    record.trial = number;
    record.by_virtual_trainee = is_virtual[row] != 0.0;
    RequireListed(record, study, table.Where(row));
    ACUS_REQUIRE(record.metrics.emplace(MetricKey{metric[row], unit[row]}, value[row]).second,
                 table.Where(row), ": this metric of this trial is there twice");
  }
  std::vector<TrialRecord> list;
  for (auto& [key, record] : records) list.push_back(std::move(record));
  return list;
}

/// Takes over the names of the study: those of a table may lack commas.
void TakeNamesOf(const Study& study, TrialRecord& record) {
  for (const std::string& name : study.exercises) {
    if (CsvCell(name) == CsvCell(record.exercise)) record.exercise = name;
  }
}

void SortAsStudy(const Study& study, std::vector<TrialRecord>& trials) {
  const auto place = [&](const TrialRecord& t) {
    return std::tuple(study.Find(t.code) - study.participants.data(),
                      std::ranges::find(study.exercises, t.exercise) - study.exercises.begin(),
                      t.trial);
  };
  std::ranges::stable_sort(trials, {}, place);
}

}  // namespace

std::string WithUnit(const MetricKey& metric) {
  return metric.name + (metric.unit.empty() ? "" : " [" + metric.unit + "]");
}

TrialRecord RecordOf(const training::Assessment& assessment) {
  TrialRecord record;
  record.code = assessment.trainee;
  record.exercise = assessment.exercise;
  record.passed = assessment.Passed();
  record.by_virtual_trainee = assessment.by_virtual_trainee;
  for (const training::Metric& metric : assessment.metrics) {
    record.metrics[{CsvCell(metric.name), metric.unit}] = metric.value;
  }
  if (!assessment.goals.empty()) {
    record.metrics[{kGoalsMet, "%"}] = 100.0 * static_cast<double>(assessment.NumMet()) /
                                       static_cast<double>(assessment.goals.size());
    record.metrics[{kScore, "%"}] = 100.0 * training::ScoreOf(assessment);
  }
  return record;
}

bool NaturallyBefore(const std::string& a, const std::string& b) {
  const auto digit = [](char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; };
  std::size_t i = 0, j = 0;
  while (i < a.size() && j < b.size()) {
    if (digit(a[i]) && digit(b[j])) {
      const auto number_end = [&digit](const std::string& text, std::size_t from) {
        while (from < text.size() && digit(text[from])) ++from;
        return from;
      };
      const std::size_t end_a = number_end(a, i), end_b = number_end(b, j);
      std::size_t first_a = i, first_b = j;
      while (first_a + 1 < end_a && a[first_a] == '0') ++first_a;
      while (first_b + 1 < end_b && b[first_b] == '0') ++first_b;
      if (end_a - first_a != end_b - first_b) return end_a - first_a < end_b - first_b;
      const int order = a.compare(first_a, end_a - first_a, b, first_b, end_b - first_b);
      if (order != 0) return order < 0;
      i = end_a;
      j = end_b;
      continue;
    }
    if (a[i] != b[j]) return a[i] < b[j];
    ++i;
    ++j;
  }
  return a.size() - i < b.size() - j;
}

std::vector<TrialRecord> ReadTrials(std::span<const fs::path> paths, const Study& study,
                                    RunContext& context) {
  std::vector<TrialRecord> trials;
  std::map<std::pair<std::string, std::string>, int> counted;
  std::set<std::string> without_consent;
  const auto keep = [&](TrialRecord record) {
    TakeNamesOf(study, record);
    if (study.Find(record.code)->consent) {
      trials.push_back(std::move(record));
    } else {
      without_consent.insert(record.code);
    }
  };
  for (const fs::path& path : paths) {
    if (!fs::is_directory(path)) {
      context.provenance.AddInput(path);
      for (TrialRecord& record : RecordsOfTable(path, study)) keep(std::move(record));
      continue;
    }
    for (const fs::path& file : AssessmentsIn(path)) {
      context.provenance.AddInput(file);
      TrialRecord record = RecordIn(file);
      RequireListed(record, study, file.string());
      record.trial = ++counted[{record.code, record.exercise}];
      keep(std::move(record));
    }
  }
  for (const std::string& code : without_consent) {
    context.Warn(Message("participant ", code, " has not given consent: the trials are not used"));
  }
  ACUS_REQUIRE(!trials.empty(),
               "no trial was found; give run folders of acus-replay --exercise, a folder of "
               "acus-training simulate, or a trials.csv");
  SortAsStudy(study, trials);
  for (std::size_t i = 1; i < trials.size(); ++i) {
    const TrialRecord &a = trials[i - 1], &b = trials[i];
    ACUS_REQUIRE(a.code != b.code || a.exercise != b.exercise || a.trial != b.trial, "trial ",
                 b.trial, " of ", b.code, " in \"", b.exercise, "\" is given twice");
  }
  return trials;
}

std::vector<TrialRecord> FindTrials(std::span<const fs::path> folders, RunContext& context) {
  std::vector<TrialRecord> trials;
  std::map<std::pair<std::string, std::string>, int> counted;
  for (const fs::path& folder : folders) {
    for (const fs::path& file : AssessmentsIn(folder)) {
      context.provenance.AddInput(file);
      trials.push_back(RecordIn(file));
      trials.back().trial = ++counted[{trials.back().code, trials.back().exercise}];
    }
  }
  return trials;
}

std::string TrialsCsv(const Study& study, std::span<const TrialRecord> trials) {
  std::string csv = "code,group,exercise,trial,metric,unit,value,virtual\n";
  for (const TrialRecord& t : trials) {
    for (const auto& [metric, value] : t.metrics) {
      csv += Message(t.code, ",", CsvCell(study.Find(t.code)->group), ",", CsvCell(t.exercise), ",",
                     t.trial, ",", metric.name, ",", metric.unit, ",", NumberText(value), ",",
                     t.by_virtual_trainee ? 1 : 0, "\n");
    }
  }
  return csv;
}

std::vector<Answer> ReadAnswers(const fs::path& path, const Study& study, RunContext& context) {
  const CsvTable table(path);
  context.provenance.AddInput(path);
  const auto code = table.Texts("code"), key = table.Texts("questionnaire"),
             item = table.Texts("item"), text = table.Texts("answer");
  std::vector<Answer> answers;
  std::set<std::tuple<std::string, std::string, std::string>> seen;
  for (std::size_t row = 0; row < table.num_rows(); ++row) {
    const std::string where = table.Where(row);
    const Participant* person = study.Find(code[row]);
    ACUS_REQUIRE(person != nullptr, where, ": the code \"", code[row],
                 "\" is not among the participants");
    const auto asked = std::ranges::find(study.questionnaires, key[row], &Questionnaire::key);
    ACUS_REQUIRE(asked != study.questionnaires.end(), where, ": the study has no questionnaire \"",
                 key[row], "\"");
    ACUS_REQUIRE(
        std::ranges::find(asked->items, item[row], &QuestionItem::key) != asked->items.end(), where,
        ": \"", key[row], "\" has no item \"", item[row], "\"");
    if (text[row].empty() || !person->consent) continue;
    const int answer = WholeNumber(text[row], where, "the answer");
    ACUS_REQUIRE(answer >= 1 && answer <= static_cast<int>(asked->scale.size()), where,
                 ": the answer ", answer, " is off the scale of 1 to ", asked->scale.size());
    ACUS_REQUIRE(seen.insert({code[row], key[row], item[row]}).second, where,
                 ": this answer is given twice");
    answers.push_back({code[row], key[row], item[row], answer});
  }
  return answers;
}

void ReadConsents(const fs::path& path, Study& study, RunContext& context) {
  const CsvTable table(path);
  context.provenance.AddInput(path);
  const auto code = table.Texts("code"), consent = table.Texts("consent");
  for (std::size_t row = 0; row < table.num_rows(); ++row) {
    ACUS_REQUIRE(consent[row] == "yes" || consent[row] == "no", table.Where(row),
                 ": the consent must be yes or no, got \"", consent[row], "\"");
    const auto person = std::ranges::find(study.participants, code[row], &Participant::code);
    if (person != study.participants.end()) person->consent = consent[row] == "yes";
  }
}

}  // namespace acus::study
