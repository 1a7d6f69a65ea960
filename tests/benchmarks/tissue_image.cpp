#include "benchmarks/tissue_image.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "acus/base/core/cpu_time.h"
#include "acus/physics/mechanics/condensation/compliance_file.h"
#include "acus/physics/mechanics/condensation/condensation.h"
#include "acus/physics/tissue/displacement_functions.h"
#include "acus/physics/tissue/fem_field.h"
#include "acus/physics/tissue/needle_contact.h"
#include "benchmarks/tissue_run.h"

namespace acus::benchmarks {
namespace {

using Eigen::Vector3d;

constexpr double kSideMm = 60.0;
constexpr double kVisibleMm = 30.0;  ///< acus-mesh: condense/image_radius_mm.
constexpr int kImages = 5;

/// The samples until the tip is in the middle of the muscle.
std::size_t NumUntilShown(const std::vector<tissue::ToolSample>& samples) {
  constexpr double kShownMm = -30.0;
  const auto shown = std::ranges::find_if(
      samples, [](const tissue::ToolSample& sample) { return sample.tip_in_ct_mm[2] <= kShownMm; });
  return static_cast<std::size_t>(shown - samples.begin()) + 1;
}

template <typename Model>
tissue::TissueLoad LoadWhenShown(const Model& model,
                                 const std::vector<tissue::ToolSample>& samples) {
  auto state = model.NewState();
  for (std::size_t n = 0; n < NumUntilShown(samples); ++n) model.Step(state, samples[n]);
  tissue::TissueLoad load;
  model.LoadOf(state, load);
  return load;
}

/// Columns along x, rows down from 5 mm above the skin, through where the needle went in.
Vector3d PixelMm(int row, int column, const std::vector<tissue::ToolSample>& samples) {
  const double step_mm = kSideMm / TissueImage::kPixels;
  const Vector3d& above = samples.front().tip_in_ct_mm;
  return {above.x() + (column + 0.5) * step_mm - 0.5 * kSideMm, above.y(),
          5.0 - (row + 0.5) * step_mm};
}

template <typename Field>
void Show(Field& field, const tissue::TissueLoad& load,
          const std::vector<tissue::ToolSample>& samples, TissueImage& out) {
  for (int n = 0; n < kImages; ++n) {
    out.moved_mm.clear();
    const double begin_s = ThreadCpuSeconds();
    field.Update(load);
    for (int row = 0; row < TissueImage::kPixels; ++row) {
      for (int column = 0; column < TissueImage::kPixels; ++column) {
        const Vector3d place = PixelMm(row, column, samples);
        out.moved_mm.push_back(place.z() < 0.0 ? field.DisplacementMm(place)
                                               : Vector3d(Vector3d::Zero()));
      }
    }
    out.image_us.push_back(1e6 * (ThreadCpuSeconds() - begin_s));
  }
}

}  // namespace

TissueImage ImageOfFem(double element_mm, const TissueBlockTables& tables,
                       const std::vector<tissue::ToolSample>& samples, const RunContext& context) {
  const FemSetting setting;
  const mesh::TetraMesh mesh = TissueBlock::Mesh(element_mm);
  const mechanics::FreeNodes free = mechanics::FindFreeNodes(mesh);
  mechanics::Condensation condensation(
      mesh, free, tables.elasticity, setting.element,
      mechanics::CorridorNodes(mesh, free, WayOf(samples, setting.corridor_radius_mm)),
      mechanics::kDefaultMemoryMib, context);
  const mechanics::Compliance compliance = condensation.Compliance(setting.storage);
  tissue::FemContactSettings contact;
  contact.contact_spacing_mm = setting.contact_spacing_mm;
  const tissue::FemNeedleModel model(mesh, compliance, tables.elasticity, tables.forces,
                                     tables.needle, contact);
  const tissue::TissueLoad load = LoadWhenShown(model, samples);

  TissueImage out;
  const double begin_s = ThreadCpuSeconds();
  std::vector<int> visible = mechanics::NodesInside(mesh, free, WayOf(samples, kVisibleMm));
  condensation.SetVisible(visible);
  const int columns = 3 * static_cast<int>(condensation.nodes().size());
  Eigen::MatrixXf block(3 * static_cast<Eigen::Index>(visible.size()), columns);
  constexpr int kAtOnce = 100;
  for (int first = 0; first < columns; first += kAtOnce) {
    context.Checkpoint("solving for the image", static_cast<double>(first) / columns);
    condensation.ImageColumns(first, std::min(kAtOnce, columns - first), block.col(first).data());
  }
  const tissue::FemImage image(
      mesh, {compliance, mechanics::ImageBlock::FromMatrix(std::move(visible), block)});
  out.preparation_s = ThreadCpuSeconds() - begin_s;
  out.memory_mb = 1e-6 * static_cast<double>(block.size() * sizeof(float));
  tissue::FemField field(image);
  Show(field, load, samples, out);
  return out;
}

TissueImage ImageOfPlane(const TissueBlockTables& tables,
                         const std::vector<tissue::ToolSample>& samples) {
  const tissue::PlaneModel2010 model = PlaneOf(90.0 / 18.0, 90.0, 78.0, tables, samples);
  TissueImage out;
  tissue::PlaneField2010 field(model);
  Show(field, LoadWhenShown(model, samples), samples, out);
  return out;
}

TissueImage ImageOfSprings(const TissueBlockTables& tables,
                           const std::vector<tissue::ToolSample>& samples) {
  const tissue::SpringModel model = SpringsOf(2.0, tables);
  TissueImage out;
  tissue::SpringField field(model);
  Show(field, LoadWhenShown(model, samples), samples, out);
  return out;
}

TissueImage ImageOfFunctions(const TissueBlockTables& tables,
                             const std::vector<tissue::ToolSample>& samples) {
  const tissue::DisplacementFunctions functions({}, [&tables](const Vector3d& rest_mm) {
    const volume::Label tissue = TissueBlock::TissueAt(rest_mm);
    return tissue == 0 ? 0.0 : tables.elasticity.At(tissue).youngs_modulus_mpa;
  });
  const tissue::SpringModel springs = SpringsOf(2.0, tables);
  TissueImage out;
  tissue::DisplacementFunctionsField field(functions);
  Show(field, LoadWhenShown(springs, samples), samples, out);
  return out;
}

double RmsDifferenceMm(const TissueImage& image, const TissueImage& reference) {
  double largest_mm = 0.0;
  for (const Vector3d& moved : reference.moved_mm) largest_mm = std::max(largest_mm, moved.norm());
  double sum = 0.0;
  int count = 0;
  for (std::size_t n = 0; n < reference.moved_mm.size(); ++n) {
    if (reference.moved_mm[n].norm() < 0.01 * largest_mm) continue;
    sum += (image.moved_mm[n] - reference.moved_mm[n]).squaredNorm();
    ++count;
  }
  return std::sqrt(sum / std::max(1, count));
}

}  // namespace acus::benchmarks
