#include "acus/patient/segmentation/voxels/label_names.h"

#include <algorithm>
#include <cctype>

#include "acus/base/config/json_file.h"
#include "acus/base/core/error.h"
#include "acus/base/core/spelling.h"
#include "acus/base/core/words.h"
#include "acus/data/volume/labels.h"

namespace acus::segmentation {
namespace {

namespace fs = std::filesystem;

/// "kidneys" is "kidney", but "pelvis" and "platysma" stay.
std::string WithoutPlural(std::string word) {
  const bool is_plural = word.size() > 3 && word.ends_with('s') && !word.ends_with("ss") &&
                         !word.ends_with("us") && !word.ends_with("is");
  if (is_plural) word.pop_back();
  return word;
}

/// What two spellings of one name have in common: its words in alphabetical order. "Left Kidney"
/// and "kidney_left" are one.
struct NameKey {
  std::string text;  ///< Without the side.
  Side side = Side::kNone;
};

/// Words in lower case. @param by_capitals  "LeftKidney" is two words.
std::vector<std::string> WordsOf(std::string_view name, bool by_capitals) {
  std::vector<std::string> words(1);
  bool was_lower = false;
  for (const char c : name) {
    const auto letter = static_cast<unsigned char>(c);
    const bool begins = by_capitals && was_lower && std::isupper(letter) != 0;
    if (!words.back().empty() && (begins || std::isalnum(letter) == 0)) words.emplace_back();
    if (std::isalnum(letter) != 0) words.back() += static_cast<char>(std::tolower(letter));
    was_lower = std::islower(letter) != 0;
  }
  return words;
}

/// @param is_short  Words are divided at capitals, and a side may be short, as in names of
///     radiotherapy (AAPM TG-263): "Kidney_L", "Lt Kidney", "SpinalCanal".
NameKey KeyOf(std::string_view name, bool is_short = false) {
  NameKey key;
  std::vector<std::string> kept;
  for (const std::string& word : WordsOf(name, is_short)) {
    const bool is_left = word == "left" || (is_short && (word == "l" || word == "lt"));
    const bool is_right = word == "right" || (is_short && (word == "r" || word == "rt"));
    if (is_left) key.side = Side::kLeft;
    if (is_right) key.side = Side::kRight;
    const bool is_filler = word.empty() || word == "of" || word == "the" || word == "and" ||
                           word == "in" || is_left || is_right;
    if (!is_filler) kept.push_back(WithoutPlural(word));
  }
  std::ranges::sort(kept);
  key.text = Joined(kept, "_");
  return key;
}

Side SideFrom(std::string_view text) {
  if (text == "left") return Side::kLeft;
  return text == "right" ? Side::kRight : Side::kNone;
}

volume::Label TissueIn(const nlohmann::json& row, const fs::path& path) {
  try {
    return volume::LabelOf(row.at("tissue").get<std::string>());
  } catch (const InputError& error) {
    throw InputError(Message(path.string(), ": ", row.value("names", nlohmann::json()).dump(), ": ",
                             error.what()));
  }
}

Structure StructureFrom(const nlohmann::json& row, const fs::path& path) {
  Structure structure;
  structure.name = row.at("names").at(0).get<std::string>();
  structure.tissue = TissueIn(row, path);
  structure.least_ml = row.at("least_ml");
  structure.most_ml = row.at("most_ml");
  structure.is_paired = row.at("paired");
  structure.half = SideFrom(row.at("half").get<std::string>());
  structure.is_midline = row.at("midline");
  if (row.contains("height_mm")) structure.height_mm = row.at("height_mm").get<double>();
  structure.order = row.at("order");
  return structure;
}

}  // namespace

LabelNames::LabelNames(const fs::path& path) {
  const nlohmann::json document = config::ReadConfig(path, "acus-label-names");
  document.at("covers_body").get_to(covers_body_);
  document.at("all_bones").get_to(all_bones_);
  for (const auto& row : document.at("hu")) {
    hu_[TissueIn(row, path)] = {row.at("least").get<double>(), row.at("most").get<double>()};
  }
  for (const auto& row : document.at("structures")) {
    const std::size_t index = structures_.size();
    for (const auto& name : row.at("names")) {
      const auto spelling = name.get<std::string>();
      ACUS_REQUIRE(by_key_.try_emplace(KeyOf(spelling).text, index).second, path.string(),
                   ": the name '", spelling, "' is given twice");
      spellings_.push_back(spelling);
    }
    for (const auto& code : row.at("codes")) {
      ACUS_REQUIRE(by_code_.try_emplace(code.get<std::string>(), index).second, path.string(),
                   ": the code '", code.get<std::string>(), "' is given twice");
    }
    structures_.push_back(StructureFrom(row, path));
  }
}

std::optional<NamedStructure> LabelNames::Find(const volume::ValueName& name) const {
  const NameKey key = KeyOf(name.text);
  const Side side = key.side != Side::kNone ? key.side : SideFrom(name.side);
  const auto with_side = [&](std::size_t index) {
    const Structure& structure = structures_[index];
    return NamedStructure{structure, structure.is_paired ? side : Side::kNone};
  };
  if (const auto found = by_key_.find(key.text); found != by_key_.end()) {
    return with_side(found->second);
  }
  for (const std::string& code : name.codes) {
    if (const auto found = by_code_.find(code); found != by_code_.end()) {
      return with_side(found->second);
    }
  }
  const NameKey shorter = KeyOf(name.text, /*is_short=*/true);
  const auto found = by_key_.find(shorter.text);
  if (found == by_key_.end()) return std::nullopt;
  const Structure& structure = structures_[found->second];
  // A single letter is a side only of what has two.
  if (shorter.side != key.side && !structure.is_paired) return std::nullopt;
  return NamedStructure{structure, structure.is_paired ? shorter.side : Side::kNone};
}

std::optional<std::string> LabelNames::Nearest(const std::string& name) const {
  return NearestSpelling(name, spellings_);
}

bool LabelNames::ListsOneOf(const Alternatives& rows, const volume::ValueNames& listed) const {
  std::set<std::string> keys;
  for (const auto& [value, name] : listed) keys.insert(KeyOf(name.text).text);
  return std::ranges::any_of(rows, [&](const std::vector<std::string>& row) {
    return std::ranges::all_of(
        row, [&](const std::string& name) { return keys.contains(KeyOf(name).text); });
  });
}

bool LabelNames::CoversBody(const volume::ValueNames& listed) const {
  return ListsOneOf(covers_body_, listed);
}

bool LabelNames::HasAllBones(const volume::ValueNames& listed) const {
  return ListsOneOf(all_bones_, listed);
}

std::optional<HuRange> LabelNames::HuOf(volume::Label tissue) const {
  const auto found = hu_.find(tissue);
  return found == hu_.end() ? std::nullopt : std::optional(found->second);
}

}  // namespace acus::segmentation
