#include "acus/patient/breathing_registration/capture.h"

#include <algorithm>
#include <cmath>

#include "acus/base/core/csv.h"
#include "acus/base/math/statistics.h"
#include "acus/data/volume/displacement_file.h"
#include "acus/data/volume/volume_io.h"
#include "acus/patient/phantom/breath/breathing_folder.h"

namespace acus::breathing_registration {
namespace {

using breathing::MotionKind;
using breathing::MotionPhases;
using Eigen::Vector3d;

constexpr MotionKind kKinds[] = {MotionKind::kSinusoid, MotionKind::kFullCycle,
                                 MotionKind::kHalfCycle, MotionKind::kSurrogate};
constexpr double kLargestPlausibleMm = 200.0;
constexpr double kUpperHalf = 0.5;  // Of normal breath.

double Largest(const std::vector<float>& displacement_mm) {
  double largest2 = 0.0;
  for (std::size_t n = 0; n + 2 < displacement_mm.size(); n += 3) {
    const Eigen::Map<const Eigen::Vector3f> u(&displacement_mm[n]);
    largest2 = std::max(largest2, static_cast<double>(u.squaredNorm()));
  }
  return std::sqrt(largest2);
}

breathing::ModelError Summary(const std::vector<double>& errors_mm) {
  return {.mean_mm = math::Mean(errors_mm),
          .p95_mm = math::Quantile(errors_mm, 0.95),
          .largest_mm = std::ranges::max(errors_mm)};
}

Side SideAt(const Tissue& tissue, const Vector3d& p) {
  return tissue.wall_mm && tissue.wall_mm(p) < 0.0 ? Side::kCavity : Side::kWall;
}

std::string FileOf(const PhaseFile& phase) {
  return phase.path.filename().string();
}

/// visit(place in the reference, place in the phase), CT mm, for landmarks with both.
template <typename Visit>
void ForEachLandmark(const KnownLandmarks& landmarks, const std::string& reference,
                     const PhaseFile& phase, Visit&& visit) {
  for (const auto& point : landmarks.points) {
    const auto rest = point.at_mm.find(reference);
    const auto moved = point.at_mm.find(FileOf(phase));
    if (rest != point.at_mm.end() && moved != point.at_mm.end()) visit(rest->second, moved->second);
  }
}

/// Fills in the errors at landmarks, and what they should keep to.
void AtLandmarks(const KnownLandmarks& landmarks, const std::string& reference,
                 const PhaseField& field, const Tissue& tissue, PhaseResult& result) {
  ForEachLandmark(landmarks, reference, result.file, [&](const auto& rest, const auto& moved) {
    const Side side = SideAt(tissue, rest);
    result.landmark_error_mm.push_back((rest + field.DisplacementMm(rest, side) - moved).norm());
    result.landmark_bound_mm.push_back(field.BoundMm(rest, side));
  });
}

/// Error of a model, over all phases that have landmarks.
std::optional<breathing::ModelError> ModelAtLandmarks(const breathing::MotionModel& model,
                                                      const KnownLandmarks& landmarks,
                                                      const std::string& reference,
                                                      const std::vector<PhaseFile>& phases) {
  std::vector<double> errors_mm;
  for (const PhaseFile& phase : phases) {
    const auto weights = model.WeightsAt(phase.breath);
    ForEachLandmark(landmarks, reference, phase, [&](const auto& rest, const auto& moved) {
      const Vector3d u = model.field().DisplacementMm(weights, rest);
      errors_mm.push_back((rest + u - moved).norm());
    });
  }
  if (errors_mm.empty()) return std::nullopt;
  return Summary(errors_mm);
}

std::vector<std::uint8_t> TissueNodes(const volume::Geometry& nodes, const Tissue& tissue) {
  std::vector<std::uint8_t> where(nodes.num_voxels(), 1);
  if (!tissue.is_tissue) return where;
  for (int k = 0; k < nodes.size[2]; ++k) {
    for (int j = 0; j < nodes.size[1]; ++j) {
      for (int i = 0; i < nodes.size[0]; ++i) {
        where[nodes.Index(i, j, k)] =
            tissue.is_tissue(nodes.ct_from_index() * Vector3d(i, j, k)) ? 1 : 0;
      }
    }
  }
  return where;
}

breathing::MotionModel Build(MotionKind kind, const MotionPhases& phases, int num_modes) {
  return breathing::BuildModel(
      kind, num_modes > 0 ? breathing::FilteredInTime(phases, num_modes) : phases);
}

/// Fields on the model's nodes: of a normal breath, and of a deeper one.
struct Fields {
  MotionPhases normal;
  std::optional<breathing::MotionPhase> deeper;
};

ModelRow Judge(MotionKind kind, const Fields& fields, const std::vector<std::uint8_t>& where,
               const CaptureSettings& settings, const RunContext& context) {
  const auto model = Build(kind, fields.normal, settings.num_modes);
  ModelRow row{.kind = kind,
               .in_sample = breathing::ErrorOf(model, fields.normal, where),
               .leave_one_out = {},
               .deeper = {},
               .landmarks = {}};
  try {
    row.leave_one_out = breathing::LeaveOneOutError(kind, fields.normal, where);
  } catch (const InputError& error) {
    context.Warn(
        Message("no leave-one-out error for ", breathing::NameOf(kind), ": ", error.what()));
  }
  if (fields.deeper) {
    const MotionPhases known{.nodes = fields.normal.nodes, .phases = {*fields.deeper}};
    row.deeper = breathing::ErrorOf(model, known, where);
  }
  return row;
}

/// Builds and judges; fills in what a capture says about models.
void BuildModels(const Fields& fields, const Tissue& tissue, const std::vector<PhaseFile>& phases,
                 const CaptureSettings& settings, const RunContext& context, Capture& capture) {
  Fields coarse{.normal = fields.normal, .deeper = fields.deeper};
  if (settings.judged_at < settings.resolution) {
    const auto nodes = breathing::NodesOver(fields.normal.nodes, settings.judged_at);
    coarse.normal = breathing::Resampled(fields.normal, nodes);
    if (fields.deeper) {
      MotionPhases deeper{.nodes = fields.normal.nodes, .phases = std::vector(3, *fields.deeper)};
      coarse.deeper = breathing::Resampled(deeper, nodes).phases.front();
    }
  }
  const auto where = TissueNodes(coarse.normal.nodes, tissue);
  capture.variance_of_modes = breathing::VarianceOfModes(coarse.normal);
  for (std::size_t n = 0; n < std::size(kKinds); ++n) {
    context.Checkpoint("judging the models", static_cast<double>(n) / std::size(kKinds));
    capture.models.push_back(Judge(kKinds[n], coarse, where, settings, context));
    if (capture.landmarks.points.empty()) continue;
    capture.models.back().landmarks =
        ModelAtLandmarks(Build(kKinds[n], fields.normal, settings.num_modes), capture.landmarks,
                         capture.reference, phases);
  }
  double low = phases.front().breath.level, high = low;
  for (const PhaseFile& phase : phases) {
    low = std::min(low, phase.breath.level);
    high = std::max(high, phase.breath.level);
  }
  capture.motion.model = Build(settings.kind, fields.normal, settings.num_modes);
  capture.motion.inspiration_level = high;
  capture.motion.expiration_level = low;
}

Capture EmptyCapture(const std::string& name) {
  return {.motion = {.name = name,
                     .model = breathing::MotionModel::Sinusoid({}, 1.0),
                     .inspiration_level = 1.0,
                     .expiration_level = 0.0,
                     .period_s = 4.0},
          .phases = {},
          .reference = {},
          .models = {},
          .variance_of_modes = {},
          .landmarks = {},
          .image = {},
          .shown = {},
          .bound = {},
          .bound_image = {}};
}

/// The coronal slice in the middle.
DifferenceImage Image(const volume::Grid<float>& before, const volume::Grid<float>& after) {
  const volume::Geometry& g = before.geometry;
  DifferenceImage image{.width = g.size[0],
                        .height = g.size[2],
                        .pixel_mm = g.spacing_mm[0],
                        .before = {},
                        .after = {}};
  for (int k = g.size[2] - 1; k >= 0; --k) {
    for (int i = 0; i < g.size[0]; ++i) {
      image.before.push_back(before.At(i, g.size[1] / 2, k));
      image.after.push_back(after.At(i, g.size[1] / 2, k));
    }
  }
  return image;
}

/// The coronal slice in the middle, as the difference images.
BoundImage BoundImageOf(const PhaseField& field, const Tissue& tissue, const std::string& phase) {
  volume::Geometry slice = field.nodes();
  slice.origin_mm += slice.direction.col(1) * slice.spacing_mm[1] * (slice.size[1] / 2);
  slice.size[1] = 1;
  const std::vector<float> mm = field.BoundOnNodes(slice, tissue, 1);
  BoundImage image{.width = slice.size[0], .height = slice.size[2], .mm = {}, .phase = phase};
  for (int k = slice.size[2] - 1; k >= 0; --k) {
    const auto row = mm.begin() + static_cast<std::ptrdiff_t>(slice.Index(0, 0, k));
    image.mm.insert(image.mm.end(), row, row + slice.size[0]);
  }
  return image;
}

/// From 0 at the lowest level of normal breath to 1 at the highest.
double ShareOfBreath(const PhaseFiles& files, const breathing::Breath& breath) {
  const auto [low, high] = std::ranges::minmax(
      files.phases, {}, [](const PhaseFile& phase) { return phase.breath.level; });
  const double span = high.breath.level - low.breath.level;
  return span > 0.0 ? (breath.level - low.breath.level) / span : 0.0;
}

void Enlarge(std::vector<float>& largest, const std::vector<float>& values, double scale) {
  for (std::size_t n = 0; n < values.size(); ++n) {
    largest[n] = std::max(largest[n], static_cast<float>(scale) * values[n]);
  }
}

/// Share of the landmarks, over all phases, where the model as written keeps to its bound.
std::optional<double> KeptShare(const Capture& capture, const std::vector<PhaseFile>& phases) {
  const breathing::PatientMotion& motion = capture.motion;
  int kept = 0, all = 0;
  for (const PhaseFile& phase : phases) {
    if (FileOf(phase) == capture.reference) continue;
    const auto weights = motion.model.WeightsAt(phase.breath);
    const double level = motion.Normal(phase.breath).level;
    const auto visit = [&](const Vector3d& rest, const Vector3d& moved) {
      const Vector3d u = motion.model.field().DisplacementMm(weights, rest);
      kept += (rest + u - moved).norm() <= motion.bound->Mm(rest, level) ? 1 : 0;
      ++all;
    };
    ForEachLandmark(capture.landmarks, capture.reference, phase, visit);
  }
  if (all == 0) return std::nullopt;
  return static_cast<double>(kept) / all;
}

/// @param bound_mm  Of registration, at the model's nodes.
void BoundTheModel(std::vector<float> bound_mm, const std::vector<PhaseFile>& phases,
                   MotionKind kind, Capture& capture) {
  if (!capture.bound) return;
  const auto row = std::ranges::find(capture.models, kind, &ModelRow::kind);
  const auto model_mm = static_cast<float>(row->in_sample.p95_mm);
  std::vector<double> tissue_mm;
  for (float& mm : bound_mm) {
    if (mm == 0.0F) continue;
    mm = std::hypot(mm, model_mm);
    tissue_mm.push_back(static_cast<double>(mm));
  }
  if (tissue_mm.empty()) return;
  capture.bound->median_mm = math::Quantile(tissue_mm, 0.5);
  capture.bound->p95_mm = math::Quantile(tissue_mm, 0.95);
  capture.bound->largest_mm = std::ranges::max(tissue_mm);
  capture.motion.bound.emplace(capture.motion.model.field().nodes(), std::move(bound_mm));
  capture.bound->kept_share = KeptShare(capture, phases);
}

/// Away from the reference, first forwards in time, then backwards; the deeper breath last.
struct Stop {
  const PhaseFile* phase;
  std::size_t at;     ///< Among the phases; their number: the deeper one.
  std::size_t start;  ///< Whose field to start from; the reference's own: none.
};

std::vector<Stop> Route(const PhaseFiles& files, std::size_t reference) {
  const std::size_t count = files.phases.size();
  std::vector<Stop> route;
  const std::size_t forwards = count / 2;
  for (std::size_t n = 1; n <= forwards; ++n) {
    const std::size_t at = (reference + n) % count;
    route.push_back({&files.phases[at], at, (reference + n - 1) % count});
  }
  for (std::size_t n = 1; n < count - forwards; ++n) {
    const std::size_t at = (reference + count - n) % count;
    route.push_back({&files.phases[at], at, (reference + count - n + 1) % count});
  }
  if (files.deeper) {
    std::size_t nearest = reference;
    for (std::size_t n = 0; n < count; ++n) {
      const auto off = [&](std::size_t i) {
        return std::abs(files.phases[i].breath.level - files.deeper->breath.level);
      };
      if (off(n) < off(nearest)) nearest = n;
    }
    route.push_back({&*files.deeper, count, nearest});
  }
  return route;
}

}  // namespace

KnownLandmarks ReadKnownLandmarks(const std::filesystem::path& path) {
  const CsvTable table(path);
  const auto names = table.Texts("name"), tissues = table.Texts("tissue"),
             files = table.Texts("file");
  const auto wall = table.Numbers("wall_mm");
  const auto x = table.Numbers("x_mm"), y = table.Numbers("y_mm"), z = table.Numbers("z_mm");
  std::map<std::string, std::size_t> place;
  KnownLandmarks out;
  for (std::size_t n = 0; n < names.size(); ++n) {
    const auto [found, is_new] = place.try_emplace(names[n], out.points.size());
    if (is_new) {
      out.points.push_back(
          {.name = names[n], .tissue = tissues[n], .wall_mm = wall[n], .at_mm = {}});
    }
    const bool added =
        out.points[found->second].at_mm.try_emplace(files[n], x[n], y[n], z[n]).second;
    ACUS_REQUIRE(added, table.Where(n), ": ", names[n], " is given twice for ", files[n]);
  }
  return out;
}

std::size_t ReferenceOf(const PhaseFiles& files) {
  const auto lowest =
      std::ranges::min_element(files.phases, {}, [](const PhaseFile& p) { return p.breath.level; });
  return static_cast<std::size_t>(lowest - files.phases.begin());
}

Capture CaptureMotion(const PhaseFiles& files, const volume::CtVolume& reference,
                      const Tissue& tissue, const KnownLandmarks& landmarks,
                      const CaptureSettings& settings, const RunContext& context) {
  Capture capture = EmptyCapture(files.phases.front().path.parent_path().filename().string());
  const std::size_t base = ReferenceOf(files);
  capture.reference = FileOf(files.phases[base]);
  capture.landmarks = landmarks;
  const PhaseRegistration registration(reference, tissue, settings.registration, context);
  Fields fields;
  fields.normal.nodes = breathing::NodesOver(reference.geometry, settings.resolution);
  for (const PhaseFile& phase : files.phases) {
    fields.normal.phases.push_back({.breath = phase.breath, .displacement_in_ct_mm = {}});
  }
  const std::vector<Stop> route = Route(files, base);
  std::map<std::size_t, PhaseField> done;
  std::vector<float> bound_mm(fields.normal.nodes.num_voxels(), 0.0F);
  double worst = -1.0, fullest = -1.0;
  for (std::size_t n = 0; n < route.size(); ++n) {
    const Stop& stop = route[n];
    context.Checkpoint("registering " + stop.phase->name,
                       static_cast<double>(n) / static_cast<double>(route.size()));
    const volume::CtVolume image = ReadPhase(*stop.phase, context);
    const auto start = done.find(stop.start);
    PhaseResult result{.file = *stop.phase,
                       .deeper = stop.at == files.phases.size(),
                       .residual = {},
                       .largest_mm = 0.0,
                       .smallest_determinant = {},
                       .landmark_error_mm = {},
                       .landmark_bound_mm = {}};
    PhaseField field = registration.Register(image, start == done.end() ? nullptr : &start->second,
                                             context, &result.residual);
    auto on_nodes = field.OnNodes(fields.normal.nodes, tissue, context.num_threads);
    result.largest_mm = Largest(on_nodes);
    result.smallest_determinant = field.grid().SmallestDeterminant(field.displacement_voxels());
    result.unseen_share = field.unseen_share();
    AtLandmarks(landmarks, capture.reference, field, tissue, result);
    const double share = ShareOfBreath(files, stop.phase->breath);
    if (!result.deeper && share >= kUpperHalf) {
      Enlarge(bound_mm, field.BoundOnNodes(fields.normal.nodes, tissue, context.num_threads),
              1.0 / share);
    }
    if (!result.deeper && share > fullest) {
      fullest = share;
      capture.bound_image = BoundImageOf(field, tissue, stop.phase->name);
      capture.bound = BoundSummary{.unseen_share = result.unseen_share, .kept_share = {}};
    }
    if (result.residual.before > worst) {
      worst = result.residual.before;
      capture.image = Image(registration.Difference(image, nullptr, context.num_threads),
                            registration.Difference(image, &field, context.num_threads));
      capture.shown = stop.phase->name;
    }
    capture.phases.push_back(std::move(result));
    if (stop.at < files.phases.size()) {
      fields.normal.phases[stop.at].displacement_in_ct_mm = std::move(on_nodes);
    } else {
      fields.deeper = {.breath = stop.phase->breath, .displacement_in_ct_mm = std::move(on_nodes)};
    }
    done.insert_or_assign(stop.at, std::move(field));
  }
  done.clear();
  BuildModels(fields, tissue, files.phases, settings, context, capture);
  BoundTheModel(std::move(bound_mm), files.phases, settings.kind, capture);
  return capture;
}

Capture CaptureFields(const PhaseFiles& files, const volume::Geometry* ct,
                      const CaptureSettings& settings, const RunContext& context) {
  Capture capture = EmptyCapture(files.phases.front().path.parent_path().filename().string());
  Fields fields;
  MotionPhases given;
  const auto read = [&](const PhaseFile& phase) {
    context.Checkpoint("reading " + phase.name, 0.0);
    auto field = volume::ReadDisplacementField(phase.path);
    for (const std::string& note : field.notes) {
      context.Warn(Message(phase.path.string(), ": ", note));
    }
    if (given.phases.empty()) given.nodes = field.geometry;
    ACUS_REQUIRE(field.geometry.Matches(given.nodes), phase.path.string(), ": a field of ",
                 field.geometry.size.transpose(), " nodes at ",
                 field.geometry.origin_mm.transpose(), " mm; the others have ",
                 given.nodes.size.transpose(), " at ", given.nodes.origin_mm.transpose(),
                 " mm; all fields must lie on the same grid");
    const double largest = Largest(field.displacement_in_ct_mm);
    ACUS_REQUIRE(largest < kLargestPlausibleMm, phase.path.string(), ": displacements of up to ",
                 largest,
                 " mm; breath moves nothing that far. Fields must be in mm of CT space (LPS), from "
                 "the reference to the phase");
    capture.phases.push_back({.file = phase,
                              .deeper = false,
                              .residual = {},
                              .largest_mm = largest,
                              .smallest_determinant = {},
                              .landmark_error_mm = {},
                              .landmark_bound_mm = {}});
    if (largest == 0.0) field.displacement_in_ct_mm.clear();
    return breathing::MotionPhase{.breath = phase.breath,
                                  .displacement_in_ct_mm = std::move(field.displacement_in_ct_mm)};
  };
  for (const PhaseFile& phase : files.phases) given.phases.push_back(read(phase));
  if (ct != nullptr) {
    const auto middle = [](const volume::Geometry& g) {
      return Vector3d(g.ct_from_index() * (0.5 * (g.size - 1).cast<double>()).matrix());
    };
    const Vector3d index = ct->index_from_ct() * middle(given.nodes);
    ACUS_REQUIRE(
        (index.array() >= 0.0).all() && (index.array() <= (ct->size - 1).cast<double>()).all(),
        files.phases.front().path.string(), ": the middle of the fields, ",
        middle(given.nodes).transpose(),
        " mm, is outside the CT; they are in another space (RAS instead of LPS?)");
  }
  if (files.deeper) fields.deeper = read(*files.deeper);
  for (const auto& phase : given.phases) {
    if (phase.displacement_in_ct_mm.empty()) capture.reference = "the field that is 0 everywhere";
  }
  const auto nodes = breathing::NodesOver(given.nodes, settings.resolution);
  if (fields.deeper) {
    const MotionPhases deeper{.nodes = given.nodes, .phases = std::vector(3, *fields.deeper)};
    fields.deeper = breathing::Resampled(deeper, nodes).phases.front();
  }
  fields.normal = breathing::Resampled(given, nodes);
  BuildModels(fields, {}, files.phases, settings, context, capture);
  return capture;
}

Capture CaptureSingle(const volume::LabelMap& labels, double diaphragm_mm,
                      const CaptureSettings& settings, const RunContext& context) {
  Capture capture = EmptyCapture("synthetic");
  phantom::BreathingFolderSettings breath;
  breath.motion.diaphragm_mm = diaphragm_mm;
  const phantom::BreathingMotion motion(phantom::FindCavity(labels, context), breath.motion);
  Fields fields;
  fields.normal.nodes = breathing::NodesOver(labels.geometry, settings.resolution);
  std::vector<PhaseFile> phases;
  for (int n = 0; n < breath.num_phases; ++n) {
    context.Checkpoint("moving the patient", static_cast<double>(n) / breath.num_phases);
    phases.push_back({.name = Message("phase ", n),
                      .path = {},
                      .series = {},
                      .breath = phantom::BreathOfPhase(n, breath)});
    const bool reference = 2 * n == breath.num_phases;
    fields.normal.phases.push_back(
        {.breath = phases.back().breath,
         .displacement_in_ct_mm =
             reference ? std::vector<float>()
                       : phantom::DisplacementsOn(fields.normal.nodes, motion, phases.back().breath,
                                                  context.num_threads)});
    capture.phases.push_back(
        {.file = phases.back(),
         .residual = {},
         .largest_mm = Largest(fields.normal.phases.back().displacement_in_ct_mm),
         .smallest_determinant = {},
         .landmark_error_mm = {},
         .landmark_bound_mm = {}});
  }
  const breathing::Breath deeper{.cycle = 0.0, .level = breath.deeper_level, .level_per_s = 0.0};
  fields.deeper = {.breath = deeper,
                   .displacement_in_ct_mm = phantom::DisplacementsOn(fields.normal.nodes, motion,
                                                                     deeper, context.num_threads)};
  capture.reference = "the CT, at end expiration";
  capture.motion.period_s = breath.motion.period_s;
  BuildModels(fields, {}, phases, settings, context, capture);
  return capture;
}

}  // namespace acus::breathing_registration
