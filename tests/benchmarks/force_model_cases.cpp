#include "benchmarks/force_model_cases.h"

#include <array>
#include <bitset>
#include <cmath>
#include <memory>
#include <utility>

#include "acus/base/config/json_file.h"
#include "acus/data/volume/labels.h"
#include "acus/physics/forces/models/alamilla_model.h"
#include "acus/physics/forces/models/needle_force.h"
#include "acus/physics/forces/models/vidal_model.h"
#include "acus/physics/mechanics/condensation/condensation.h"
#include "acus/physics/mechanics/condensation/reachable.h"
#include "acus/physics/needle/needle_preset.h"
#include "acus/physics/tissue/needle_contact.h"
#include "acus/physics/tissue/plane_model_2010.h"
#include "acus/physics/tissue/spring_model.h"
#include "acus/scene/simulation/needle_shape.h"
#include "benchmarks/tissue_block.h"

namespace acus::benchmarks {
namespace {

constexpr double kBytesPerMb = 1e6;
constexpr int kCheapSteps = 16;  ///< To a reading of the clock, for steps below a microsecond.

forces::NeedleInput InBlock(const tissue::ToolSample& sample) noexcept {
  forces::NeedleInput input;
  input.time_s = sample.time_s;
  input.tip_in_ct_mm = sample.tip_in_ct_mm;
  input.axis_in_ct = sample.axis_in_ct;
  input.tissue_at_tip = TissueBlock::TissueAt(sample.tip_in_ct_mm);
  input.valid = sample.needle_valid;
  return input;
}

/// A model of lib/acus/physics/forces, with the block's tissue looked up as a label map's would be.
template <typename Model, typename State>
struct InTheBlock {
  Model model;
  State NewState() const { return {}; }
  forces::NeedleForce Step(State& state, const tissue::ToolSample& sample) const noexcept {
    return model.Step(state, InBlock(sample));
  }
};

/// The block as a CT would show it: layers that go over into each other within 2 mm.
class BlockHu : public forces::HuField {
 public:
  double HuAt(const Eigen::Vector3d& place) const noexcept override {
    constexpr std::array<std::pair<double, double>, 4> kFromDepthMmHu = {
        {{0.0, 20.0}, {4.0, -100.0}, {20.0, 55.0}, {36.0, 60.0}}};
    double hu = -1000.0;
    for (const auto& [from_mm, layer_hu] : kFromDepthMmHu) {
      hu += std::clamp(0.5 * (-place.z() - from_mm) + 0.5, 0.0, 1.0) * (layer_hu - hu);
    }
    return hu;
  }
  double ResolutionMm() const noexcept override { return 0.7; }
};

struct VidalInBlock {
  BlockHu field;
  forces::VidalModel model;
  VidalInBlock(const forces::ForceTable& table, const forces::NeedleProperties& needle)
      : model(table, needle, field) {}
  forces::VidalState NewState() const { return {}; }
  forces::NeedleForce Step(forces::VidalState& state,
                           const tissue::ToolSample& sample) const noexcept {
    return model.Step(state, InBlock(sample));
  }
};

/// Along the needle the layered model, across it the needle's shape, as a scene joins them.
struct BendableInBlock {
  forces::NeedleForceModel along;
  simulation::NeedleShapeModel across;
  struct State {
    forces::NeedleForceState along;
    simulation::NeedleShapeState across;
  };
  State NewState() const { return {{}, across.NewState()}; }
  forces::NeedleForce Step(State& state, const tissue::ToolSample& sample) const noexcept {
    forces::NeedleForce out = along.Step(state.along, InBlock(sample));
    const simulation::PathLine path{state.along.in_body && state.along.pierced,
                                    state.along.path.entry_in_ct_mm,
                                    state.along.path.direction_in_ct};
    simulation::NeedleShapeInput input;
    input.time_s = sample.time_s;
    input.valid = sample.needle_valid;
    input.ct_from_needle.linear() =
        Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), sample.axis_in_ct)
            .toRotationMatrix();
    input.ct_from_needle.translation() = sample.tip_in_ct_mm;
    input.tissue_at_tip = TissueBlock::TissueAt(sample.tip_in_ct_mm + state.across.tip_offset_mm);
    input.path = &path;
    across.Step(state.across, input, out);
    return out;
  }
};

/// The mesh, its compliance and the model that reads them: none moves after construction.
struct FemInBlock {
  mesh::TetraMesh mesh;
  mechanics::Compliance compliance;
  std::unique_ptr<tissue::FemNeedleModel> model;
  FemInBlock(double element_mm, const TissueBlockTables& tables, const RunContext& context)
      : mesh(TissueBlock::Mesh(element_mm)) {
    RunContext quiet;  // The condensation's own progress is not the sweep's.
    quiet.stop = context.stop;
    quiet.num_threads = context.num_threads;
    const mechanics::FreeNodes free = mechanics::FindFreeNodes(mesh);
    mechanics::Capsule way;
    way.from_mm = SmoothInsertion(0.0).tip_in_ct_mm;
    way.to_mm = SmoothInsertion(2.5).tip_in_ct_mm;
    way.radius_mm = 6.0;
    const mechanics::Condensation condensation(
        mesh, free, tables.elasticity, mechanics::ElementKind::kAveragedDilatation,
        mechanics::CorridorNodes(mesh, free, way), mechanics::kDefaultMemoryMib, quiet);
    compliance = condensation.Compliance(mechanics::Storage::kDouble);
    model =
        std::make_unique<tissue::FemNeedleModel>(mesh, compliance, tables.elasticity, tables.forces,
                                                 tables.needle, tissue::FemContactSettings{});
  }
  tissue::FemNeedleState NewState() const { return model->NewState(); }
  forces::NeedleForce Step(tissue::FemNeedleState& state,
                           const tissue::ToolSample& sample) const noexcept {
    return model->Step(state, sample);
  }
};

template <typename Make>
ForceModelCase CaseOf(std::string name, std::string full_name, double largest_n,
                      int steps_per_timing, Make make) {
  const double before_s = ThreadCpuSeconds();
  const auto model = make();
  ForceModelCase out;
  out.name = std::move(name);
  out.full_name = std::move(full_name);
  out.largest_n = largest_n;
  out.preparation_s = ThreadCpuSeconds() - before_s;
  out.memory_mb = static_cast<double>(sizeof(*model) + sizeof(model->NewState())) / kBytesPerMb;
  out.run = [model, steps_per_timing](const std::vector<tissue::ToolSample>& samples) {
    return RunSampled(*model, samples, steps_per_timing);
  };
  out.begin = [model] {
    return [model, state = model->NewState()](const tissue::ToolSample& sample) mutable {
      return model->Step(state, sample);
    };
  };
  return out;
}

std::bitset<256> BlockTissues() {
  std::bitset<256> labels;
  for (const char* name : {"skin", "fat", "muscle", "liver"}) labels.set(volume::LabelOf(name));
  return labels;
}

ForceModelCase Springs(const TissueBlockTables& tables) {
  return CaseOf("springs", "springs along the path (Fortmeier-2016)",
                tables.forces.settings.largest_force_n, kCheapSteps, [&] {
                  return std::make_shared<const tissue::SpringModel>(
                      tissue::SpringSettings{}, tables.forces, tables.needle, tables.elasticity,
                      BlockTissues(), TissueBlock::TissueAt);
                });
}

ForceModelCase Plane(const TissueBlockTables& tables) {
  std::shared_ptr<const tissue::PlaneModel2010> made;
  ForceModelCase model = CaseOf(
      "fe_2d", "the plane of Augmented-2010, 361 nodes", tables.forces.settings.largest_force_n, 1,
      [&] {
        tissue::PlaneSettings settings;
        settings.width_mm = 90.0;
        settings.depth_mm = 78.0;
        settings.spacing_mm = 5.0;
        const tissue::ToolSample start = SmoothInsertion(0.0);
        tissue::PlanePlacement placement;
        placement.axis_in_ct = start.axis_in_ct;
        placement.entry_in_ct_mm =
            start.tip_in_ct_mm - start.axis_in_ct * (start.tip_in_ct_mm.z() / start.axis_in_ct.z());
        placement.across_in_ct = Eigen::Vector3d::UnitY();  // The needle is pushed along y.
        made = std::make_shared<const tissue::PlaneModel2010>(settings, placement, tables.forces,
                                                              tables.needle, tables.elasticity,
                                                              TissueBlock::TissueAt);
        return made;
      });
  model.memory_mb =
      static_cast<double>(made->planes().compliance().size() * sizeof(double)) / kBytesPerMb;
  return model;
}

ForceModelCase Fem(double element_mm, const TissueBlockTables& tables, const RunContext& context) {
  std::shared_ptr<const FemInBlock> made;
  ForceModelCase model =
      CaseOf("fe_3d", "finite elements in 3D", tables.forces.settings.largest_force_n, 1, [&] {
        made = std::make_shared<const FemInBlock>(element_mm, tables, context);
        return made;
      });
  model.memory_mb = std::pow(3.0 * made->compliance.num_nodes(), 2) * sizeof(double) / kBytesPerMb;
  return model;
}

ForceModelCase Bendable(int num_nodes, const TissueBlockTables& tables) {
  return CaseOf("bendable needle",
                "layered forces with an elastic rod of " + std::to_string(num_nodes) + " nodes",
                tables.forces.settings.largest_force_n, 1, [&] {
                  scenario::NeedleEffect effect;
                  effect.model = scenario::NeedleModelKind::kBendable;
                  effect.nodes = num_nodes;
                  return std::shared_ptr<const BendableInBlock>(new BendableInBlock{
                      forces::NeedleForceModel(tables.forces, tables.needle),
                      simulation::NeedleShapeModel(effect, tables.needle, tables.forces,
                                                   &tables.elasticity, BlockTissues(),
                                                   /*force_has_beam=*/true)});
                });
}

}  // namespace

std::vector<ForceModelCase> ForceModelCases(const ForceModelOptions& options,
                                            const RunContext& context) {
  using forces::AlamillaModel;
  using forces::NeedleForceModel;
  Provenance provenance(context.provenance);
  const auto tables =
      std::make_shared<const TissueBlockTables>(TissueBlockTables::FromPresets(provenance));
  const auto table = [](const char* name) {
    return forces::ReadForceTable(config::FindConfig(name, "."));
  };
  const double largest_n = tables->forces.settings.largest_force_n;
  std::vector<ForceModelCase> models;
  models.push_back(CaseOf("layered", "layered", largest_n, kCheapSteps, [&] {
    using Model = InTheBlock<NeedleForceModel, forces::NeedleForceState>;
    return std::shared_ptr<const Model>(new Model{{tables->forces, tables->needle}});
  }));
  // Its own table has no fat and liver: the constants of the layered model, its own laws.
  models.push_back(CaseOf("alamilla", "Alamilla-2021", largest_n, kCheapSteps, [&] {
    using Model = InTheBlock<AlamillaModel, forces::AlamillaState>;
    return std::shared_ptr<const Model>(new Model{{tables->forces, tables->needle}});
  }));
  models.push_back(CaseOf("vidal", "Vidal-2008", largest_n, kCheapSteps, [&] {
    return std::make_shared<const VidalInBlock>(table("forces/vidal.json"), tables->needle);
  }));
  models.push_back(Springs(*tables));
  models.push_back(Plane(*tables));
  context.Checkpoint("mesh of " + std::to_string(static_cast<int>(options.element_mm)) + " mm",
                     0.05);
  models.push_back(Fem(options.element_mm, *tables, context));
  models.push_back(Bendable(options.num_nodes, *tables));
  return models;
}

}  // namespace acus::benchmarks
