#include "acus/data/volume/label_map_content.h"

#include "acus/data/volume/labels.h"

namespace acus::volume {

std::string NameOfLabel(Label label) {
  const auto standard = StandardLabels();
  return label < standard.size() ? std::string(standard[label].name)
                                 : "label_" + std::to_string(label);
}

std::string NameOfLabel(const LabelMap& labels, Label label) {
  const auto named = labels.names.find(label);
  return named != labels.names.end() ? named->second : NameOfLabel(label);
}

std::array<std::size_t, 256> CountsByLabel(const LabelMap& labels) {
  std::array<std::size_t, 256> counts{};
  for (const Label label : labels.voxels) ++counts[label];
  return counts;
}

}  // namespace acus::volume
