#include "benchmarks/page_data.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <set>

#include "acus/base/config/json_file.h"
#include "acus/base/core/csv.h"
#include "acus/base/core/error.h"
#include "acus/base/core/words.h"

namespace acus::benchmarks {
namespace {

namespace fs = std::filesystem;

/// NaN unless the whole text is a number.
double NumberOf(std::string_view text) {
  double value = kNotMeasured;
  const char* const end = text.data() + text.size();
  const auto result = std::from_chars(text.data(), end, value);
  return result.ec == std::errc() && result.ptr == end ? value : kNotMeasured;
}

double CellNumber(const CsvTable& table, const std::string& text, std::size_t row) {
  if (text.empty()) return kNotMeasured;
  const double value = NumberOf(text);
  ACUS_REQUIRE(std::isfinite(value), table.Where(row), ": '", text, "' is not a number");
  return value;
}

template <typename Map>
std::string Names(const Map& map) {
  std::vector<std::string> names;
  for (const auto& [name, value] : map) names.push_back(name);
  return Joined(names);
}

bool HasValue(const Row& row, const std::string& value) {
  if (value == "default") return row.is_default;
  if (value == "paper") return row.is_paper;
  if (value == "*") return row.unusable.empty();
  return row.value == value;
}

}  // namespace

RowField::RowField(std::string_view text) {
  const auto star = text.find('*');
  if (star != text.npos) {
    factor_ = NumberOf(Trimmed(text.substr(0, star)));
    ACUS_REQUIRE(std::isfinite(factor_), "'", text, "': before * there must be a number");
    text = text.substr(star + 1);
  }
  name_ = Trimmed(text);
  if (name_.starts_with("error ")) {
    unit_ = Trimmed(std::string_view(name_).substr(6));
    name_ = "error";
    return;
  }
  constexpr std::string_view kNames[] = {"step_us_median", "step_us_p999", "preparation_s",
                                         "memory_mb", "value"};
  ACUS_REQUIRE(std::ranges::find(kNames, name_) != std::end(kNames), "'", name_,
               "' is no field of a row; there are: error UNIT, step_us_median, step_us_p999, "
               "preparation_s, memory_mb, value");
}

bool RowField::IsOf(const Row& row) const {
  return unit_.empty() || row.error_unit == unit_;
}

double RowField::Of(const Row& row) const {
  if (name_ == "error") return factor_ * row.error;
  if (name_ == "step_us_median") return factor_ * row.step_us_median;
  if (name_ == "step_us_p999") return factor_ * row.step_us_p999;
  if (name_ == "preparation_s") return factor_ * row.preparation_s;
  if (name_ == "memory_mb") return factor_ * row.memory_mb;
  return factor_ * NumberOf(row.value);
}

std::vector<std::string> Parts(std::string_view text, char separator) {
  std::vector<std::string> parts;
  while (true) {
    const auto end = text.find(separator);
    parts.emplace_back(Trimmed(text.substr(0, end)));
    if (end == text.npos) return parts;
    text = text.substr(end + 1);
  }
}

std::vector<Row> ReadRows(const fs::path& csv) {
  const CsvTable table(csv);
  // Where a text has a comma, its cell has a semicolon.
  const auto cells = [&](const char* column) {
    auto texts = table.Texts(column);
    for (std::string& text : texts) std::ranges::replace(text, ';', ',');
    return texts;
  };
  const auto knob = cells("knob"), value = cells("value"), model = cells("model");
  const auto error = cells("error"), unit = cells("error_unit"), reference = cells("reference");
  const auto median = cells("step_us_median"), p999 = cells("step_us_p999");
  const auto preparation = cells("preparation_s"), memory = cells("memory_mb");
  const auto ours = cells("is_default"), papers = cells("is_paper"), unusable = cells("unusable");
  std::vector<Row> rows(table.num_rows());
  for (std::size_t n = 0; n < rows.size(); ++n) {
    rows[n] = {.knob = knob[n],
               .value = value[n],
               .model = model[n],
               .error = CellNumber(table, error[n], n),
               .error_unit = unit[n],
               .reference = reference[n],
               .step_us_median = CellNumber(table, median[n], n),
               .step_us_p999 = CellNumber(table, p999[n], n),
               .preparation_s = CellNumber(table, preparation[n], n),
               .memory_mb = CellNumber(table, memory[n], n),
               .is_default = ours[n] == "1",
               .is_paper = papers[n] == "1",
               .unusable = unusable[n]};
  }
  return rows;
}

PageData PageData::Read(const fs::path& folder) {
  ACUS_REQUIRE(fs::is_directory(folder), folder.string(), ": no such folder");
  PageData data;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().stem().string();
    if (entry.path().extension() == ".csv") data.sweeps[name] = ReadRows(entry.path());
    if (entry.path().extension() == ".json") data.facts[name] = config::ReadJson(entry.path());
  }
  ACUS_REQUIRE(!data.sweeps.empty(), folder.string(),
               ": there is no table of a sweep; run pipelines/accuracy-and-time");
  return data;
}

const std::vector<Row>& PageData::Sweep(const std::string& name) const {
  const auto found = sweeps.find(name);
  ACUS_REQUIRE(found != sweeps.end(), "there is no sweep '", name, "'; there are: ", Names(sweeps));
  return found->second;
}

std::vector<double> PageData::Numbers(std::string_view selector) const {
  const auto parts = Parts(selector);
  if (parts.size() == 2) {
    const auto file = facts.find(parts[0]);
    ACUS_REQUIRE(file != facts.end(), "there is no file of facts '", parts[0],
                 "'; there are: ", Names(facts));
    const auto fact = file->second.find(parts[1]);
    if (fact == file->second.end() || fact->is_null()) return {};
    ACUS_REQUIRE(fact->is_number(), "[", selector, "] is not a number");
    return {fact->get<double>()};
  }
  ACUS_REQUIRE(parts.size() == 4, "[", selector,
               "]: must be FILE | key or SWEEP | knob | value | field");
  const std::vector<Row>& rows = Sweep(parts[0]);
  ACUS_REQUIRE(std::ranges::any_of(rows, [&](const Row& row) { return row.knob == parts[1]; }), "[",
               selector, "]: the sweep has no such knob");
  const RowField field(parts[3]);
  std::vector<double> numbers;
  std::set<std::string> seen;
  for (const Row& row : rows) {
    if (row.knob != parts[1] || !HasValue(row, parts[2]) || !field.IsOf(row)) continue;
    if (!seen.insert(row.value).second) continue;
    if (const double number = field.Of(row); std::isfinite(number)) numbers.push_back(number);
  }
  return numbers;
}

std::string PageData::Text(std::string_view selector) const {
  const auto parts = Parts(selector);
  ACUS_REQUIRE(parts.size() == 2, "[", selector, "]: must be FILE | key");
  const auto file = facts.find(parts[0]);
  ACUS_REQUIRE(file != facts.end() && file->second.contains(parts[1]), "[", selector,
               "]: there is no such fact");
  const nlohmann::json& fact = file->second.at(parts[1]);
  return fact.is_string() ? fact.get<std::string>() : fact.dump();
}

}  // namespace acus::benchmarks
