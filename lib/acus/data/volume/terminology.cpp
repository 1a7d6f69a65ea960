#include "acus/data/volume/terminology.h"

#include <algorithm>
#include <array>

#include "acus/base/core/error.h"

namespace acus::volume {
namespace {

struct Code {
  std::string_view value;  ///< SNOMED CT.
  std::string_view meaning;
};

constexpr Code kTissue = {"85756007", "Tissue"};
constexpr Code kStructure = {"123037004", "Anatomical Structure"};
constexpr Code kSubstance = {"91720002", "Body Substance"};
constexpr Code kAltered = {"49755003", "Morphologically Altered Structure"};
constexpr std::string_view kSlicerList =
    "Segmentation category and type - 3D Slicer General Anatomy list";
constexpr std::string_view kDicomList = "Segmentation category and type - DICOM master list";

struct Term {
  std::string_view name;
  Code category;
  Code type;
  std::string_view list = kSlicerList;
};

constexpr std::array kTerms = {
    Term{"skin", kTissue, {"39937001", "Skin"}},
    Term{"fat", kTissue, {"248300009", "Body fat"}},
    Term{"muscle", kTissue, {"71616004", "Muscle"}},
    Term{"bone", kTissue, {"272673000", "Bone"}},
    Term{"ligament", kTissue, {"52082005", "Ligament"}},
    Term{"cartilage", kTissue, {"309312004", "Cartilage"}},
    Term{"tendon", kTissue, {"13024002", "Tendon"}},
    Term{"bowel", kTissue, {"113343008", "Organ"}},
    Term{"gland", kTissue, {"113343008", "Organ"}},
    Term{"vessel", kTissue, {"59820001", "Blood vessel"}, kDicomList},
    Term{"lung", kStructure, {"39607008", "Lung"}},
    Term{"liver", kStructure, {"10200004", "Liver"}},
    Term{"kidney", kStructure, {"64033007", "Kidney"}},
    Term{"spleen", kStructure, {"78961009", "Spleen"}},
    Term{"heart", kStructure, {"80891009", "Heart"}},
    Term{"pancreas", kStructure, {"15776009", "Pancreas"}},
    Term{"stomach", kStructure, {"69695003", "Stomach"}},
    Term{"bladder", kStructure, {"89837001", "Bladder"}},
    Term{"gallbladder", kStructure, {"28231008", "Gallbladder"}},
    Term{"gas", kSubstance, {"74947009", "Gas"}},
    Term{"lesion", kAltered, {"4147007", "Mass"}},
};

std::string TextOf(const Code& code) {
  return Message("SCT^", code.value, "^", code.meaning);
}

std::vector<std::string_view> FieldsOf(std::string_view text, char separator) {
  std::vector<std::string_view> fields;
  for (;;) {
    const std::size_t at = text.find(separator);
    fields.push_back(text.substr(0, at));
    if (at == text.npos) return fields;
    text.remove_prefix(at + 1);
  }
}

/// The value of "scheme^value^meaning"; empty for other schemes than SNOMED CT's.
std::string SnomedCode(std::string_view code) {
  const auto parts = FieldsOf(code, '^');
  const bool is_snomed = parts.size() == 3 && (parts[0] == "SCT" || parts[0] == "SRT");
  return is_snomed ? std::string(parts[1]) : std::string();
}

}  // namespace

std::string SideOfCode(std::string_view code) {
  if (code == "24028007" || code == "G-A100") return "right";
  return code == "7771000" || code == "G-A101" ? "left" : "";
}

ValueName TermsFrom(std::string_view tags) {
  constexpr std::string_view kKey = "TerminologyEntry:";
  ValueName name;
  const std::size_t begin = tags.find(kKey);
  if (begin == tags.npos) return name;
  tags.remove_prefix(begin + kKey.size());
  const auto fields = FieldsOf(tags.substr(0, tags.find('|')), '~');
  // List, category, type, its modifier, list of regions, region, its modifier.
  for (const std::size_t at : {std::size_t{2}, std::size_t{5}}) {
    if (at + 1 >= fields.size()) break;
    const std::string code = SnomedCode(fields[at]);
    if (!code.empty()) name.codes.push_back(code);
    const std::string side = SideOfCode(SnomedCode(fields[at + 1]));
    if (!side.empty()) name.side = side;
  }
  return name;
}

std::string TerminologyEntry(std::string_view name) {
  const auto found = std::ranges::find(kTerms, name, &Term::name);
  const Term term = found != kTerms.end() ? *found : Term{name, kTissue, kTissue};
  return Message(term.list, "~", TextOf(term.category), "~", TextOf(term.type),
                 "~^^~Anatomic codes - DICOM master list~^^~^^");
}

}  // namespace acus::volume
