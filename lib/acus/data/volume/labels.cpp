#include "acus/data/volume/labels.h"

#include "acus/base/core/spelling.h"

namespace acus::volume {
namespace {

constexpr StandardLabel kLabels[] = {
    {0, "outside", {0, 0, 0}},
    {1, "skin", {238, 190, 160}},
    {2, "fat", {245, 220, 120}},
    {3, "muscle", {190, 70, 60}},
    {4, "soft_tissue", {200, 120, 110}},
    {5, "bone", {240, 236, 220}},
    {6, "lung", {150, 190, 220}},
    {7, "gas", {90, 110, 140}},
    {8, "liver", {150, 60, 45}},
    {9, "kidney", {175, 95, 60}},
    {10, "spleen", {140, 70, 110}},
    {11, "vessel", {60, 90, 200}},
    {12, "lesion", {120, 200, 80}},
    {13, "ligament", {200, 200, 170}},
    {14, "spinal_canal", {110, 200, 220}},
    {15, "bowel", {210, 150, 100}},
    {16, "cartilage", {170, 220, 210}},
    {17, "tendon", {225, 215, 200}},
    {18, "bursa", {100, 170, 160}},
    {19, "heart", {205, 60, 90}},
    {20, "disc", {180, 205, 170}},
    {21, "pancreas", {230, 170, 110}},
    {22, "stomach", {215, 130, 140}},
    {23, "bladder", {225, 215, 90}},
    {24, "gallbladder", {110, 150, 60}},
    {25, "gland", {190, 160, 200}},
    {26, "cut", {255, 0, 200}},
};

}  // namespace

std::span<const StandardLabel> StandardLabels() {
  return kLabels;
}

std::optional<Label> FindLabel(std::string_view name) {
  for (const StandardLabel& label : kLabels) {
    if (label.name == name) return label.label;
  }
  return std::nullopt;
}

Label LabelOf(std::string_view name) {
  if (const auto found = FindLabel(name)) return *found;
  std::vector<std::string> known;
  for (const StandardLabel& label : kLabels) known.emplace_back(label.name);
  const auto nearest = NearestSpelling(name, known);
  throw InputError(Message("no tissue is named '", name, "'",
                           nearest ? Message("; did you mean '", *nearest, "'?") : std::string()));
}

std::array<std::uint8_t, 3> ColourOf(Label label) {
  return label < std::size(kLabels) ? kLabels[label].colour
                                    : std::array<std::uint8_t, 3>{128, 128, 128};
}

}  // namespace acus::volume
