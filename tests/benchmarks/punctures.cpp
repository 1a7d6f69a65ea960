#include "benchmarks/punctures.h"

#include "acus/physics/mechanics/condensation/condensation.h"
#include "acus/physics/tissue/needle_contact.h"
#include "benchmarks/tissue_run.h"

namespace acus::benchmarks {

std::vector<Puncture> PuncturesWith(double element_mm, const TissueBlockTables& tables,
                                    double memory_mib) {
  const auto samples = ScriptedInsertion();
  const mesh::TetraMesh mesh = TissueBlock::Mesh(element_mm);
  const mechanics::FreeNodes free = mechanics::FindFreeNodes(mesh);
  const mechanics::Condensation condensation(
      mesh, free, tables.elasticity, mechanics::ElementKind::kAveragedDilatation,
      mechanics::NeedleNodes(mesh, free, WayOf(samples, 6.0), 12.0), memory_mib, RunContext{});
  tissue::FemContactSettings settings;
  settings.contact_spacing_mm = 2.0;
  const tissue::FemNeedleModel model(mesh, condensation.Compliance(mechanics::Storage::kFloat),
                                     tables.elasticity, tables.forces, tables.needle, settings);
  auto state = model.NewState();
  std::vector<Puncture> out;
  for (const tissue::ToolSample& sample : samples) {
    const forces::NeedleForce force = model.Step(state, sample);
    if (force.event != forces::NeedleEvent::kPuncture) continue;
    out.push_back({force.depth_mm, force.puncture_n + force.cutting_n});
  }
  return out;
}

}  // namespace acus::benchmarks
