#include "benchmarks/tissue_sweep.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "acus/base/core/text_table.h"
#include "acus/base/math/statistics.h"
#include "benchmarks/tissue_image.h"
#include "benchmarks/tissue_run.h"

namespace acus::benchmarks {
namespace {

using mechanics::ElementKind;
using mechanics::Storage;

constexpr const char* kFem = "3D finite elements";
constexpr double kDefaultElementMm = 4.0;  ///< acus-mesh: corridor/element_size_mm.

class TissueSweeper {
 public:
  TissueSweeper(bool quick, const RunContext& context)
      : quick_(quick),
        context_(context),
        provenance_(context.provenance),
        tables_(TissueBlockTables::FromPresets(provenance_)),
        samples_(ScriptedInsertion()),
        largest_n_(tables_.forces.settings.largest_force_n) {}

  std::vector<Row> Run() {
    ElementSizes();
    ElementKinds();
    Corridors();
    Storages();
    ContactSpacings();
    Models();
    Images();
    return std::move(rows_);
  }

 private:
  void Progress(const std::string& what, double fraction) const {
    context_.Checkpoint(what, fraction);
  }

  MeasuredRun Fem(const FemSetting& setting) const {
    RunContext quiet;  // The condensation's own progress would run to 100 % many times.
    quiet.stop = context_.stop;
    quiet.num_threads = context_.num_threads;
    return RunFem(setting, tables_, samples_, quiet);
  }

  Row& Add(const std::string& knob, const std::string& value, const std::string& model,
           const MeasuredRun& run) {
    Row row;
    row.knob = knob;
    row.value = value;
    row.model = model;
    row.error_unit = "N";
    row.step_us_median = math::Median(run.run.step_us);
    row.step_us_p999 = math::Quantile(run.run.step_us, 0.999);
    row.preparation_s = run.preparation_s;
    row.memory_mb = run.memory_mb;
    row.unusable = WhyUnusable(run.run, samples_, largest_n_);
    rows_.push_back(std::move(row));
    return rows_.back();
  }

  void Compare(Row& row, const MeasuredRun& run, const MeasuredRun& reference,
               const std::string& what) const {
    row.error = RmsDifferenceN(run.run, reference.run);
    row.reference = what;
  }

  /// Coarse to fine; the finest is the reference of the others, and of other models.
  void ElementSizes() {
    const std::vector<double> sizes = quick_ ? std::vector<double>{12.0, 6.0, 4.0}
                                             : std::vector<double>{12.0, 6.0, 4.0, 3.0, 2.4, 2.0};
    std::vector<MeasuredRun> runs;
    for (std::size_t n = 0; n < sizes.size(); ++n) {
      Progress("element size " + RoundedText(sizes[n], 3) + " mm",
               0.5 * static_cast<double>(n) / static_cast<double>(sizes.size()));
      FemSetting setting;
      setting.element_mm = sizes[n];
      runs.push_back(Fem(setting));
    }
    finest_ = runs.back();
    finest_name_ = "elements of " + RoundedText(sizes.back(), 3) + " mm";
    for (std::size_t n = 0; n < sizes.size(); ++n) {
      Row& row = Add("element_size_mm", RoundedText(sizes[n], 3), kFem, runs[n]);
      row.is_default = sizes[n] == kDefaultElementMm;
      Compare(row, runs[n], finest_, finest_name_);
      if (row.is_default) default_ = runs[n];
    }
    for (std::size_t n = 0; n < sizes.size(); ++n) {
      Progress("closed form, " + RoundedText(sizes[n], 3) + " mm",
               0.5 + 0.2 * static_cast<double>(n) / static_cast<double>(sizes.size()));
      RowAgainstClosedForm(sizes[n], ElementKind::kAveragedDilatation, "element_size_mm",
                           RoundedText(sizes[n], 3), runs[n]);
    }
  }

  void RowAgainstClosedForm(double element_mm, ElementKind kind, const std::string& knob,
                            const std::string& value, const MeasuredRun& run) {
    RunContext quiet;
    quiet.stop = context_.stop;
    Row& row = Add(knob, value, kFem, run);
    row.is_default = element_mm == kDefaultElementMm && kind == ElementKind::kAveragedDilatation;
    row.error = DimpleErrorPercent(element_mm, kind, tables_, quiet);
    row.error_unit = "%";
    row.reference = "closed form (Love): dimple under a pressed square";
  }

  void ElementKinds() {
    Progress("element kinds", 0.7);
    FemSetting setting;
    setting.element = ElementKind::kLinear;
    const MeasuredRun linear = Fem(setting);
    Row& row = Add("element", "linear", kFem, linear);
    Compare(row, linear, finest_, finest_name_);
    Row& averaged = Add("element", "averaged_dilatation", kFem, default_);
    averaged.is_default = true;
    Compare(averaged, default_, finest_, finest_name_);
    RowAgainstClosedForm(kDefaultElementMm, ElementKind::kLinear, "element", "linear", linear);
    RowAgainstClosedForm(kDefaultElementMm, ElementKind::kAveragedDilatation, "element",
                         "averaged_dilatation", default_);
  }

  void Corridors() {
    const std::vector<double> radii =
        quick_ ? std::vector<double>{3.0, 6.0} : std::vector<double>{1.5, 3.0, 6.0, 9.0, 12.0};
    std::vector<MeasuredRun> runs;
    for (const double radius : radii) {
      Progress("corridor of " + RoundedText(radius, 3) + " mm", 0.78);
      FemSetting setting;
      setting.corridor_radius_mm = radius;
      runs.push_back(radius == setting.corridor_radius_mm && radius == 6.0 ? default_
                                                                           : Fem(setting));
    }
    for (std::size_t n = 0; n < radii.size(); ++n) {
      Row& row = Add("corridor_radius_mm", RoundedText(radii[n], 3), kFem, runs[n]);
      row.is_default = radii[n] == 6.0;
      Compare(row, runs[n], runs.back(), "corridor of " + RoundedText(radii.back(), 3) + " mm");
    }
  }

  void Storages() {
    Progress("storage", 0.88);
    FemSetting setting;
    setting.storage = Storage::kFloat;
    const MeasuredRun single = Fem(setting);
    Row& row = Add("storage", "float", kFem, single);
    Compare(row, single, default_, "double");
    Row& twice = Add("storage", "double", kFem, default_);
    twice.is_default = true;
    Compare(twice, default_, default_, "double");
  }

  void ContactSpacings() {
    Progress("contact spacing", 0.9);
    const std::vector<double> spacings =
        quick_ ? std::vector<double>{3.0, 2.0} : std::vector<double>{5.0, 3.0, 2.0, 1.5, 1.25};
    std::vector<MeasuredRun> runs;
    for (const double spacing : spacings) {
      FemSetting setting;
      setting.contact_spacing_mm = spacing;
      runs.push_back(spacing == 2.0 ? default_ : Fem(setting));
    }
    for (std::size_t n = 0; n < spacings.size(); ++n) {
      Row& row = Add("contact_spacing_mm", RoundedText(spacings[n], 3), kFem, runs[n]);
      row.is_default = spacings[n] == 2.0;
      Compare(row, runs[n], runs.back(),
              "contacts every " + RoundedText(spacings.back(), 3) + " mm");
    }
  }

  void Models() {
    Progress("models", 0.95);
    Compare(Add("model", "3D", kFem, default_), default_, finest_, finest_name_);
    rows_.back().is_default = true;
    // 19 x 19 nodes are the paper's 361; its plane was about as deep as the needle goes.
    const MeasuredRun paper = RunPlane(90.0 / 18.0, 90.0, 78.0, tables_, samples_);
    Compare(Add("model", "2D, 361 nodes", "2D of 2010", paper), paper, finest_, finest_name_);
    rows_.back().is_paper = true;
    const MeasuredRun plane = RunPlane(3.0, 90.0, 90.0, tables_, samples_);
    Compare(Add("model", "2D, 3 mm", "2D of 2010", plane), plane, finest_, finest_name_);
    const MeasuredRun springs = RunSprings(2.0, tables_, samples_);
    Compare(Add("model", "springs", "springs of 2016", springs), springs, finest_, finest_name_);
    rows_.back().is_paper = true;
    const MeasuredRun rigid = RunRigid(tables_, samples_);
    Compare(Add("model", "no deformation", "force laws along the path", rigid), rigid, finest_,
            finest_name_);
  }

  void AddImage(const std::string& knob, const std::string& value, const std::string& model,
                const TissueImage& image, const TissueImage& reference,
                const std::string& reference_name) {
    Row row;
    row.knob = knob;
    row.value = value;
    row.model = model;
    row.error = RmsDifferenceMm(image, reference);
    row.error_unit = "mm";
    row.reference = reference_name;
    row.step_us_median = math::Median(image.image_us);
    row.step_us_p999 = math::Quantile(image.image_us, 1.0);
    row.preparation_s = image.preparation_s;
    row.memory_mb = image.memory_mb;
    if (!std::isfinite(row.error)) row.unusable = "a displacement is not finite";
    rows_.push_back(std::move(row));
  }

  /// Where tissue is seen: by size of elements, and by model.
  void Images() {
    RunContext quiet;
    quiet.stop = context_.stop;
    const double finest_mm = quick_ ? 4.0 : 3.0;
    const std::string name = "elements of " + RoundedText(finest_mm, 3) + " mm";
    Progress("images", 0.97);
    const TissueImage finest = ImageOfFem(finest_mm, tables_, samples_, quiet);
    TissueImage usual;
    for (const double size_mm : {12.0, 6.0, 4.0}) {
      usual = ImageOfFem(size_mm, tables_, samples_, quiet);
      AddImage("image, element_size_mm", RoundedText(size_mm, 3), kFem, usual, finest, name);
      rows_.back().is_default = size_mm == kDefaultElementMm;
    }
    AddImage("image, element_size_mm", RoundedText(finest_mm, 3), kFem, finest, finest, name);
    const std::string knob = "image, model";
    AddImage(knob, "3D", kFem, usual, finest, name);
    AddImage(knob, "2D, 361 nodes", "2D of 2010", ImageOfPlane(tables_, samples_), finest, name);
    AddImage(knob, "springs", "springs of 2016", ImageOfSprings(tables_, samples_), finest, name);
    AddImage(knob, "displacement functions", "functions of 2021",
             ImageOfFunctions(tables_, samples_), finest, name);
    for (std::size_t n = rows_.size() - 3; n < rows_.size(); ++n) rows_[n].is_paper = true;
    TissueImage still = finest;
    std::ranges::fill(still.moved_mm, Eigen::Vector3d(Eigen::Vector3d::Zero()));
    still.image_us.assign(1, kNotMeasured);
    AddImage(knob, "no deformation", "none", still, finest, name);
    rows_.back().preparation_s = rows_.back().memory_mb = kNotMeasured;
  }

  bool quick_;
  const RunContext& context_;
  Provenance provenance_;
  TissueBlockTables tables_;
  std::vector<tissue::ToolSample> samples_;
  double largest_n_;
  MeasuredRun finest_;
  MeasuredRun default_;
  std::string finest_name_;
  std::vector<Row> rows_;
};

}  // namespace

Sweep TissueSweep() {
  return {
      "tissue", "Tissue under the needle",
      "One scripted insertion at 1 kHz, 50 mm into skin (4 mm), fat (16 mm), muscle (16 mm) and "
      "liver, 4 degrees askew, pushed aside by 1 mm and drawn out. Errors in N are root mean "
      "squares over all samples of the difference of forces. Images: tissue in the plane of the "
      "needle, 60 x 60 mm, 256 x 256 places, when its tip is 30 mm deep; a step is one image.",
      [](bool quick, const RunContext& context) { return TissueSweeper(quick, context).Run(); }};
}

}  // namespace acus::benchmarks
