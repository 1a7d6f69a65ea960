// The force on a probe or a palpating fingertip from many proxies on its surface, after
// Fortmeier-2016, section 2.2: friction, and non-linear repulsion by the skin and by structures
// under it. docs/models/forces_probe.md.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "acus/physics/forces/laws/force_table.h"
#include "acus/physics/forces/laws/hu_field.h"
#include "acus/physics/forces/path/sample_gate.h"
#include "acus/physics/forces/probe/palpation_tool.h"
#include "acus/physics/forces/probe/probe_sample.h"
#include "acus/physics/forces/probe/proxy_contact.h"

namespace acus::forces {

/// Where the model finds the skin and the structures of a table's block multi_proxy.
struct PalpationFields {
  const HuField* skin = nullptr;
  double skin_value = 0.0;  ///< The skin is where its field passes this value.
  struct Structure {
    const HuField* field = nullptr;
    double value = 0.0;
    MultiProxySettings::Structure law;
  };
  std::vector<Structure> structures;  ///< At most MultiProxySettings::kMostStructures.
};

/// A plain value of fixed size: copy it to save, assign it to restore.
struct MultiProxyState : SampleGate {
  struct Node {
    SurfaceProxy skin;
    std::array<SurfaceProxy, MultiProxySettings::kMostStructures> structure;
  };
  std::array<Node, PalpationTool::kMostNodes> node;
  Eigen::Isometry3d ct_from_tool = Eigen::Isometry3d::Identity();  ///< Of the last valid sample.
  SuddenRise rise;
  ProbeForce last;
};

/// Const after construction: any number of states may step side by side.
class MultiProxyProbe {
 public:
  /// Keeps references to the fields, which must outlive this.
  /// @throws InputError if there are more structures than a state has room for.
  MultiProxyProbe(const ForceTable& table, const PalpationTool& tool, PalpationFields fields);

  /// Takes in the next sample. Bad samples, among them a pose that is not rigid: as
  /// NeedleForceModel::Step. The magnitude of the force never exceeds largest_force_n.
  ProbeForce Step(MultiProxyState& state, const ProbeInput& input) const noexcept;

  double largest_force_n() const { return law_.largest_force_n; }
  const PalpationTool& tool() const { return tool_; }
  const PalpationFields& fields() const { return fields_; }

 private:
  struct Touch;
  void StepNode(MultiProxyState::Node& node, Touch& touch) const noexcept;
  double StiffestNPerMm(const ProbeForce& force) const noexcept;

  ForceSettings settings_;
  MultiProxySettings law_;
  PalpationTool tool_;
  PalpationFields fields_;
  SurfaceProxySettings skin_;
  std::vector<SurfaceProxySettings> structures_;
  volume::Label bone_;
};

}  // namespace acus::forces
