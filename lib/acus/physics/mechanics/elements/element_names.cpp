#include "acus/physics/mechanics/elements/element_names.h"

#include "acus/base/core/error.h"

namespace acus::mechanics {
namespace {

constexpr ElementKind kKinds[] = {ElementKind::kLinear, ElementKind::kAveragedDilatation};

}  // namespace

std::string_view ElementName(ElementKind kind) {
  switch (kind) {
    case ElementKind::kLinear:
      return "linear";
    case ElementKind::kAveragedDilatation:
      return "averaged_dilatation";
  }
  ACUS_ASSERT(false);
}

ElementKind ElementNamed(std::string_view name, const std::string& what) {
  std::string known;
  for (const ElementKind kind : kKinds) {
    if (ElementName(kind) == name) return kind;
    known += Message(known.empty() ? "" : ", ", ElementName(kind));
  }
  throw InputError(Message(what, ": there is no element \"", name, "\"; known: ", known));
}

}  // namespace acus::mechanics
