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

}  // namespace

std::string TerminologyEntry(std::string_view name) {
  const auto found = std::ranges::find(kTerms, name, &Term::name);
  const Term term = found != kTerms.end() ? *found : Term{name, kTissue, kTissue};
  return Message(term.list, "~", TextOf(term.category), "~", TextOf(term.type),
                 "~^^~Anatomic codes - DICOM master list~^^~^^");
}

}  // namespace acus::volume
