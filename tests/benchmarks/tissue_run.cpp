#include "benchmarks/tissue_run.h"

#include <bitset>
#include <cmath>

#include "acus/data/volume/labels.h"
#include "acus/physics/forces/models/needle_force.h"
#include "acus/physics/mechanics/condensation/condensation.h"
#include "acus/physics/mechanics/condensation/reachable.h"
#include "acus/physics/tissue/needle_contact.h"
#include "acus/physics/tissue/plane_model_2010.h"
#include "acus/physics/tissue/spring_model.h"

namespace acus::benchmarks {
namespace {

constexpr double kTissueRunBytesPerMb = 1e6;

/// The laws along the path, with the block's tissue looked up as a label map's would be.
struct RigidPath {
  forces::NeedleForceModel model;

  forces::NeedleForceState NewState() const { return {}; }
  forces::NeedleForce Step(forces::NeedleForceState& state,
                           const tissue::ToolSample& sample) const noexcept {
    forces::NeedleInput input;
    input.time_s = sample.time_s;
    input.tip_in_ct_mm = sample.tip_in_ct_mm;
    input.axis_in_ct = sample.axis_in_ct;
    input.tissue_at_tip = TissueBlock::TissueAt(sample.tip_in_ct_mm);
    input.valid = sample.needle_valid;
    return model.Step(state, input);
  }
};

}  // namespace

mechanics::Capsule WayOf(const std::vector<tissue::ToolSample>& samples, double radius_mm) {
  mechanics::Capsule out;
  out.from_mm = samples.front().tip_in_ct_mm;
  out.to_mm = out.from_mm;
  for (const tissue::ToolSample& sample : samples) {
    if (sample.tip_in_ct_mm[2] < out.to_mm[2]) out.to_mm = sample.tip_in_ct_mm;
  }
  out.radius_mm = radius_mm;
  return out;
}

MeasuredRun RunFem(const FemSetting& setting, const TissueBlockTables& tables,
                   const std::vector<tissue::ToolSample>& samples, const RunContext& context) {
  const double before_s = ThreadCpuSeconds();
  const mesh::TetraMesh mesh = TissueBlock::Mesh(setting.element_mm);
  const mechanics::FreeNodes free = mechanics::FindFreeNodes(mesh);
  mechanics::Compliance compliance;
  {
    const mechanics::Condensation condensation(
        mesh, free, tables.elasticity, setting.element,
        mechanics::NeedleNodes(mesh, free, WayOf(samples, setting.corridor_radius_mm),
                               setting.tip_reach_mm),
        mechanics::kDefaultMemoryMib, context);
    compliance = condensation.Compliance(setting.storage);
  }
  tissue::FemContactSettings settings;
  const double default_mm = settings.contact_spacing_mm;
  settings.contact_spacing_mm = setting.contact_spacing_mm;
  settings.strain = setting.strain;
  if (setting.contact_spacing_mm < default_mm) {
    // Room for the whole needle: with less, the model would space points wider than asked for.
    settings.max_points =
        2 + static_cast<int>(tables.needle.length_mm / setting.contact_spacing_mm);
  }
  const tissue::FemNeedleModel model(mesh, compliance, tables.elasticity, tables.forces,
                                     tables.needle, settings);
  MeasuredRun out;
  out.preparation_s = ThreadCpuSeconds() - before_s;
  const double value_bytes = setting.storage == mechanics::Storage::kFloat ? 4.0 : 8.0;
  out.memory_mb = std::pow(3.0 * compliance.num_nodes(), 2) * value_bytes / kTissueRunBytesPerMb;
  out.num_nodes = static_cast<int>(mesh.nodes_mm.cols());
  out.run = Insert(model, samples);
  return out;
}

tissue::PlaneModel2010 PlaneOf(double spacing_mm, double width_mm, double depth_mm,
                               const TissueBlockTables& tables,
                               const std::vector<tissue::ToolSample>& samples) {
  tissue::PlaneSettings settings;
  settings.spacing_mm = spacing_mm;
  settings.width_mm = width_mm;
  settings.depth_mm = depth_mm;
  tissue::PlanePlacement placement;
  placement.axis_in_ct = samples.front().axis_in_ct;
  placement.entry_in_ct_mm = samples.front().tip_in_ct_mm;
  placement.entry_in_ct_mm -=
      placement.axis_in_ct * (placement.entry_in_ct_mm[2] / placement.axis_in_ct[2]);
  placement.across_in_ct = Eigen::Vector3d::UnitY();  // The needle is pushed aside along y.
  return {settings,      placement,         tables.forces,
          tables.needle, tables.elasticity, TissueBlock::TissueAt};
}

MeasuredRun RunPlane(double spacing_mm, double width_mm, double depth_mm,
                     const TissueBlockTables& tables,
                     const std::vector<tissue::ToolSample>& samples) {
  const double before_s = ThreadCpuSeconds();
  const tissue::PlaneModel2010 model = PlaneOf(spacing_mm, width_mm, depth_mm, tables, samples);
  MeasuredRun out;
  out.preparation_s = ThreadCpuSeconds() - before_s;
  out.memory_mb = static_cast<double>(model.planes().compliance().size()) * sizeof(double) /
                  kTissueRunBytesPerMb;
  out.num_nodes = model.planes().num_free_nodes();
  out.run = Insert(model, samples);
  return out;
}

tissue::SpringModel SpringsOf(double node_spacing_mm, const TissueBlockTables& tables) {
  std::bitset<256> labels;
  for (const char* name : {"skin", "fat", "muscle", "liver"}) labels.set(volume::LabelOf(name));
  tissue::SpringSettings settings;
  settings.node_spacing_mm = node_spacing_mm;
  return {settings, tables.forces, tables.needle, tables.elasticity, labels, TissueBlock::TissueAt};
}

MeasuredRun RunSprings(double node_spacing_mm, const TissueBlockTables& tables,
                       const std::vector<tissue::ToolSample>& samples) {
  const double before_s = ThreadCpuSeconds();
  const tissue::SpringModel model = SpringsOf(node_spacing_mm, tables);
  MeasuredRun out;
  out.preparation_s = ThreadCpuSeconds() - before_s;
  out.memory_mb =
      static_cast<double>(sizeof(model) + sizeof(tissue::SpringState)) / kTissueRunBytesPerMb;
  out.run = Insert(model, samples);
  return out;
}

MeasuredRun RunRigid(const TissueBlockTables& tables,
                     const std::vector<tissue::ToolSample>& samples) {
  const double before_s = ThreadCpuSeconds();
  const RigidPath model{forces::NeedleForceModel(tables.forces, tables.needle)};
  MeasuredRun out;
  out.preparation_s = ThreadCpuSeconds() - before_s;
  out.memory_mb =
      static_cast<double>(sizeof(model) + sizeof(forces::NeedleForceState)) / kTissueRunBytesPerMb;
  out.run = Insert(model, samples);
  return out;
}

double DimpleErrorPercent(double element_mm, mechanics::ElementKind element,
                          const TissueBlockTables& tables, const RunContext& context) {
  constexpr double kHalfMm = TissueBlock::kFineHalfWidthMm;
  constexpr double kBesideMm = 30.0;
  const volume::Label muscle = volume::LabelOf("muscle");
  const mesh::TetraMesh mesh = TissueBlock::Mesh(element_mm, muscle);
  const mechanics::FreeNodes free = mechanics::FindFreeNodes(mesh);
  // A share of 1 N for each node of the square: what linear shape functions make of a pressure on
  // squares cut in two is, but for the square's rim, the same at every node.
  std::vector<int> nodes;
  std::vector<double> force_n;
  int middle = -1;
  int beside = -1;
  for (int n = 0; n < static_cast<int>(mesh.nodes_mm.cols()); ++n) {
    const Eigen::Vector3d x = mesh.nodes_mm.col(n);
    if (x[2] < 0.0) break;  // Nodes go from the top down.
    if (x.head<2>().cwiseAbs().maxCoeff() <= kHalfMm + 1e-9) {
      double share = element_mm * element_mm / (4.0 * kHalfMm * kHalfMm);
      for (int d = 0; d < 2; ++d) share *= std::abs(x[d]) > kHalfMm - 1e-9 ? 0.5 : 1.0;
      if (x.head<2>().norm() < 1e-9) middle = static_cast<int>(nodes.size());
      nodes.push_back(n);
      force_n.push_back(-share);
    } else if (beside < 0 && std::abs(x[1]) < 1e-9 && x[0] > kBesideMm) {
      beside = static_cast<int>(nodes.size());
      nodes.push_back(n);
      force_n.push_back(0.0);
    }
  }
  const mechanics::Condensation condensation(mesh, free, tables.elasticity, element, nodes,
                                             mechanics::kDefaultMemoryMib, context);
  double dimple_mm = 0.0;
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    const auto column = condensation.ColumnMmPerN(3 * static_cast<int>(n) + 2);
    dimple_mm += force_n[n] * (column[3 * beside + 2] - column[3 * middle + 2]);
  }
  const mechanics::ElasticTissue& tissue = tables.elasticity.At(muscle);
  const double beside_mm = mesh.nodes_mm(0, nodes[static_cast<std::size_t>(beside)]);
  const double truth_mm = SquarePressureMmPerN(tissue, kHalfMm, 0.0, 0.0) -
                          SquarePressureMmPerN(tissue, kHalfMm, beside_mm, 0.0);
  return 100.0 * std::abs(dimple_mm / truth_mm - 1.0);
}

}  // namespace acus::benchmarks
