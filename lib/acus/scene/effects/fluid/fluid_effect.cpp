#include "acus/scene/effects/fluid/fluid_effect.h"

#include <string>

#include "acus/base/core/error.h"
#include "acus/data/volume/labels.h"
#include "acus/physics/fluid/fluid_table.h"
#include "acus/scene/effects/fluid/fluid_meter.h"
#include "acus/scene/effects/fluid/fluid_stage.h"
#include "acus/scene/effects/ports.h"

namespace acus::effects {
namespace {

using nlohmann::json;

constexpr ports::FilePort kFluidTable{"fluid table"};

/// @throws InputError listing the rows of the table.
int RowNamed(const fluid::FluidTable& table, const std::string& name) {
  const int row = table.TissueIndex(name);
  if (row >= 0) return row;
  std::string names;
  for (const auto& tissue : table.tissues) names += (names.empty() ? "" : ", ") + tissue.name;
  throw InputError(Message(table.file, ": /tissues has no '", name, "'; it has: ", names));
}

/// Labels whose name the table does not have are soft tissue.
FluidRows RowsOf(const fluid::FluidTable& table, const json& settings) {
  FluidRows rows;
  rows.of_label.fill(RowNamed(table, "soft_tissue"));
  for (const auto& standard : volume::StandardLabels()) {
    const int row = table.TissueIndex(standard.name);
    if (row >= 0) rows.of_label[standard.label] = row;
  }
  rows.of_label[0] = 0;
  rows.vessel = RowNamed(table, settings.at("vessel"));
  rows.of_label[volume::LabelOf("vessel")] = rows.vessel;
  for (const auto& [label, row] : settings.at("tissues").items()) {
    rows.of_label[volume::LabelOf(label)] = RowNamed(table, row);
  }
  rows.canal = volume::LabelOf("spinal_canal");
  rows.ligament = volume::LabelOf("ligament");
  rows.fat = volume::LabelOf("fat");
  rows.bone = volume::LabelOf("bone");
  rows.epidural = RowNamed(table, settings.at("epidural"));
  rows.subarachnoid = RowNamed(table, settings.at("subarachnoid"));
  const std::string space = settings.at("space");
  rows.space = space.empty() ? rows.epidural : RowNamed(table, space);
  return rows;
}

fluid::Hub HubOf(const std::string& name) {
  if (name == "open") return fluid::Hub::kOpen;
  return name == "stylet" ? fluid::Hub::kStylet : fluid::Hub::kSyringe;
}

Thumb ThumbOf(const std::string& name) {
  if (name == "continuous") return Thumb::kContinuous;
  return name == "taps" ? Thumb::kTaps : Thumb::kSession;
}

class LoadedFluid final : public LoadedEffect {
 public:
  /// @param space  Its name in the table; empty: the epidural space, to be found by its resistance.
  LoadedFluid(FluidStage stage, std::string space)
      : stage_(std::move(stage)), space_(std::move(space)) {}
  const StepStage* step() const override { return &stage_; }
  std::unique_ptr<EffectMeter> NewMeter() const override {
    return std::make_unique<FluidMeter>(space_);
  }

 private:
  FluidStage stage_;
  std::string space_;
};

class FluidEffect final : public Effect {
 public:
  std::string_view key() const override { return "fluid"; }
  std::string_view title() const override { return "Fluid through the needle"; }

  json Schema() const override {
    return json::parse(R"json({
      "type": "object",
      "additionalProperties": false,
      "description": "Fluid through the needle: pressure and flow of a syringe, loss of resistance, cerebrospinal fluid and blood at the hub, depots in the tissue; felt by the needle, seen in the B-mode",
      "properties": {
        "table": {"type": "string", "default": "fluid/default.json", "description": "Pressures and resistances of tissues, syringes, bores of needles"},
        "seed": {"type": "integer", "minimum": 0, "maximum": 4294967295, "default": 0, "description": "Draws a patient's pressures and resistances within their ranges; 0: typical values"},
        "hub": {"enum": ["syringe", "open", "stylet"], "default": "syringe", "description": "What is at the needle's hub: a syringe; nothing; or a stylet, which a pull of 1 N at the plunger's key or in the recorded orders removes and a push puts back"},
        "syringe": {"type": "string", "default": "lor_plastic_10ml", "description": "Syringe of the table"},
        "filling_ml": {"type": "number", "minimum": 0, "maximum": 100, "default": 6, "description": "Fluid in the syringe at the start"},
        "air_share": {"type": "number", "minimum": 0, "maximum": 1, "default": 0, "description": "Of the filling: 0 saline, 1 air"},
        "gauge": {"type": "integer", "minimum": 8, "maximum": 34, "default": 18, "description": "Of the needle, for its bore"},
        "bore": {"type": "string", "default": "tuohy", "description": "Kind of needle that the bore is of: a name of the table"},
        "thumb": {"enum": ["session", "continuous", "taps"], "default": "session", "description": "Who presses the plunger: the session (keys, recorded orders), or a steady or tapping force while the tip is in tissue"},
        "thumb_n": {"type": "number", "minimum": 0, "maximum": 100, "default": 10, "description": "Of the steady or tapping thumb"},
        "taps_per_s": {"type": "number", "exclusiveMinimum": 0, "maximum": 10, "default": 2, "description": "Of the tapping thumb"},
        "presses_from": {"enum": ["ligament", "skin"], "default": "ligament", "description": "Where the steady or tapping thumb begins to press"},
        "eased_after_ml": {"type": "number", "minimum": 0, "maximum": 100, "default": 1, "description": "The steady or tapping thumb lets go when so much was injected since the loss of resistance"},
        "heart_per_min": {"type": "number", "minimum": 20, "maximum": 250, "default": 70, "description": "Pulse in vessels and in cerebrospinal fluid"},
        "epidural_depth_mm": {"type": "number", "minimum": 0, "maximum": 20, "default": 5.5, "description": "From the inner face of the yellow ligament to the dura, along the needle"},
        "epidural": {"type": "string", "default": "epidural_lumbar", "description": "Row of the table for the epidural space, by level and posture"},
        "subarachnoid": {"type": "string", "default": "spinal_canal", "description": "Row of the table for cerebrospinal fluid, by posture"},
        "vessel": {"type": "string", "default": "vein", "description": "Row of the table for the label vessel"},
        "tissues": {"type": "object", "default": {}, "description": "Rows of the table for other labels, such as {\"gallbladder\": \"bile_duct\"}", "additionalProperties": {"type": "string", "description": "Row of the table for this label"}},
        "layers": {"enum": ["needle", "labels"], "default": "needle", "description": "How the layers lie between which fluid spreads: across the needle, or as the label map has the tissue around the tip; labels: needs a label map"},
        "space": {"type": "string", "default": "", "description": "Row of the table of the space into which fluid is injected or from which it is drawn, for the metrics; empty: the epidural space"}
      }
    })json");
  }

  std::vector<PathSetting> Paths() const override {
    return {{"table", PathKind::kPreset, kFluidTable}};
  }

  std::optional<StageDeclaration> StepStageOf(const json& settings) const override {
    StageDeclaration stage{.name = "fluid",
                           .reads = {ports::kNeedle, ports::kTissue, ports::kNeedlePreset,
                                     ports::kPlungerForce, kFluidTable},
                           .writes = {ports::kAddedForce, ports::kEcho, ports::kSwelling}};
    if (settings.at("layers") == "labels") stage.reads.push_back(ports::kLabels);
    return stage;
  }

  std::vector<Column> Columns() const override {
    return {{"plunger_n", "Force of the thumb on the plunger", "N"},
            {"plunger_mm", "Travel of the plunger", "mm"},
            {.name = "syringe_kpa",
             .title = "Pressure in the syringe",
             .unit = "kPa",
             .over_depth = true},
            {"bevel_kpa", "Pressure at the bevel", "kPa"},
            {"flow_ml_per_min", "Flow through the needle", "ml/min"},
            {"injected_ml", "Injected volume", "ml"},
            {"returned_ml", "Fluid returned at the hub", "ml"},
            {"drops_per_min", "Drops at the hub", "1/min"},
            {"beyond_loss_mm", "Advance since the loss of resistance", "mm"},
            {"losses", "Losses of resistance in the epidural space", "", "loss_of_resistance"},
            {"false_losses", "Losses of resistance elsewhere", "", "false_loss_of_resistance"},
            {"dural_punctures", "Punctures of the dura", "", "dural_puncture"},
            {"vessel_entries", "Entries into vessels", "", "vessel_entry"},
            {"aspirated_ml", "Aspirated volume", "ml"},
            {"space_ml", "Injected into the space less drawn from it", "ml"},
            {"stylet_removals", "Removals of the stylet", "", "stylet_removal"}};
  }

  std::unique_ptr<const LoadedEffect> Load(const json& settings, const PortValues& scene,
                                           RunContext& context) const override {
    const std::filesystem::path file = settings.at("table").get<std::string>();
    const auto seed = settings.at("seed").get<std::uint64_t>();
    fluid::FluidTable table =
        fluid::ReadFluidTable(file, seed == 0 ? std::nullopt : std::optional(seed));
    context.provenance.AddInput(file);
    FluidSettings fluid;
    fluid.rows = RowsOf(table, settings);
    fluid.hub = HubOf(settings.at("hub"));
    fluid.thumb = ThumbOf(settings.at("thumb"));
    fluid.thumb_n = settings.at("thumb_n");
    fluid.taps_per_s = settings.at("taps_per_s");
    fluid.presses_from_ligament = settings.at("presses_from") == "ligament";
    fluid.eased_after_ml = settings.at("eased_after_ml");
    fluid.heart_per_s = settings.at("heart_per_min").get<double>() / 60.0;
    fluid.epidural_depth_mm = settings.at("epidural_depth_mm");
    if (settings.at("layers") == "labels") fluid.layers = &scene.Get(ports::kLabels);
    const fluid::Syringe syringe = table.SyringeNamed(settings.at("syringe").get<std::string>());
    const fluid::Lumen lumen{.inner_diameter_mm = table.BoreMm(
                                 settings.at("gauge"), settings.at("bore").get<std::string>()),
                             .length_mm = scene.Get(ports::kNeedlePreset).length_mm};
    const fluid::Filling filling{settings.at("filling_ml"), settings.at("air_share")};
    auto model =
        std::make_shared<const fluid::FluidModel>(std::move(table), syringe, filling, lumen);
    return std::make_unique<LoadedFluid>(FluidStage(std::move(model), fluid), settings.at("space"));
  }
};

}  // namespace

const Effect& FluidThroughNeedle() {
  static const FluidEffect effect;
  return effect;
}

}  // namespace acus::effects
