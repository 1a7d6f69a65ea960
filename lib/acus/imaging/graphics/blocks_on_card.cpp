#include "acus/imaging/graphics/blocks_on_card.h"

#include <cmath>
#include <vector>

#include "acus/imaging/graphics/blocks_shader.h"

namespace acus::graphics {
namespace {

using volume_rendering::BlockFrame;
using volume_rendering::PressedTissue;
using volume_rendering::VisibleBlocks;

constexpr int kMarkGroup = 64;
constexpr int kSpreadGroup = 4;
constexpr std::uint8_t kUnmarked = 255;

Eigen::Vector4f WithGap(const Eigen::Array3f& values) {
  return {values[0], values[1], values[2], 0.0F};
}

Eigen::Vector4i WithGap(const Eigen::Array3i& values) {
  return {values[0], values[1], values[2], 0};
}

Eigen::Array3i GroupsFor(const Eigen::Array3i& size) {
  return (size + kSpreadGroup - 1) / kSpreadGroup;
}

}  // namespace

BlocksOnCard::BlocksOnCard()
    : mark_({{ShaderStage::kCompute, MarkBlocksSource()}}),
      spread_({{ShaderStage::kCompute, SpreadDistancesSource()}}),
      widen_({{ShaderStage::kCompute, WidenBlocksSource()}}) {}

void BlocksOnCard::Load(const VisibleBlocks& blocks) {
  std::vector<Eigen::Vector4i> rest;
  for (const Eigen::Array3i& block : blocks.visible()) rest.push_back(WithGap(block));
  rest_.Set(rest.data(), rest.size() * sizeof(rest[0]));
  std::vector<Eigen::Vector4f> ranges;
  for (const VisibleBlocks::Range& range : blocks.ranges_mm()) {
    ranges.push_back(WithGap(range.low_mm));
    ranges.push_back(WithGap(range.high_mm));
  }
  ranges_.Set(ranges.data(), ranges.size() * sizeof(Eigen::Vector4f));
  mark_.Set("num_blocks", static_cast<int>(rest.size()));
  mark_.Set("num_components", blocks.num_components());
  const Eigen::Matrix3f& per_mm = blocks.blocks_per_mm();
  mark_.Set("blocks_per_mm_x", WithGap(Eigen::Array3f(per_mm.row(0).transpose())));
  mark_.Set("blocks_per_mm_y", WithGap(Eigen::Array3f(per_mm.row(1).transpose())));
  mark_.Set("blocks_per_mm_z", WithGap(Eigen::Array3f(per_mm.row(2).transpose())));
}

void BlocksOnCard::Spread() {
  for (int axis = 0; axis < 3; ++axis) {
    Eigen::Array3i along = Eigen::Array3i::Zero();
    along[axis] = 1;
    spread_.Set("along", WithGap(along));
    distances_[current_].BindForWriting(0);
    current_ = 1 - current_;
    distances_[current_].BindForWriting(1);
    spread_.Run(GroupsFor(frame_.size));
  }
}

void BlocksOnCard::Widen(const VisibleBlocks& blocks, const PressedTissue& pressed) {
  const Eigen::AlignedBox3f box = pressed.box_in_ct_mm().transformed(frame_.blocks_from_ct);
  const Eigen::Array3i from = box.min().array().floor().cast<int>().max(0);
  const Eigen::Array3i to = box.max().array().ceil().cast<int>().min(frame_.size - 1);
  if ((from > to).any()) return;
  const Eigen::Array3f reach =
      pressed.LargestMm() * blocks.blocks_per_mm().rowwise().norm().array();
  widen_.Set("from", WithGap(from));
  widen_.Set("to", WithGap(to));
  widen_.Set("reach", static_cast<int>(std::ceil(reach.maxCoeff())));
  distances_[current_].BindForWriting(0);
  widen_.Run(GroupsFor(to - from + 1));
  Spread();
}

void BlocksOnCard::Update(const VisibleBlocks& blocks, const BlockFrame& frame,
                          const breathing::MotionMap* motion, const PressedTissue* pressed) {
  frame_ = frame;
  for (Texture& texture : distances_) texture.Resize(TexelFormat::kIndex, frame.size);
  distances_[current_].Fill(kUnmarked);
  Eigen::Vector4i component = Eigen::Vector4i::Zero();
  Eigen::Vector4f weight = Eigen::Vector4f::Zero();
  const int num_weights = motion == nullptr ? 0 : motion->weights().count;
  for (int n = 0; n < num_weights; ++n) {
    component[n] = motion->weights().component[static_cast<std::size_t>(n)];
    weight[n] = motion->weights().weight[static_cast<std::size_t>(n)];
  }
  mark_.Set("num_weights", num_weights);
  mark_.Set("component", component);
  mark_.Set("weight", weight);
  mark_.Set("margin", WithGap(frame.margin));
  mark_.Set("reach", WithGap(frame.reach));
  rest_.Bind(0);
  ranges_.Bind(1);
  distances_[current_].BindForWriting(0);
  const auto count = static_cast<int>(blocks.visible().size());
  mark_.Run({(count + kMarkGroup - 1) / kMarkGroup, 1, 1});
  Spread();
  if (pressed != nullptr && !pressed->empty()) Widen(blocks, *pressed);
}

}  // namespace acus::graphics
