#include "acus/run/live/image_protocol.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "acus/base/core/error.h"
#include "acus/base/core/provenance.h"

namespace acus::live {
namespace {

using nlohmann::json;
using tracking::Bytes;
using tracking::ByteView;
using tracking::IgtlHeader;

constexpr const char* kFormat = "acus-images/1";
constexpr const char* kRequestName = "Images";
constexpr const char* kStepsName = "Steps";
constexpr const char* kMomentName = "Moment";
constexpr std::size_t kColumns = 24;
constexpr double kLargestTimeNs = 9e15;  // Integers up to here are exact in double.
constexpr double kLargestMm = 1e6;

/// Files count by their contents: their folders differ between computers.
void LeaveNamesOnly(json& node) {
  if (node.is_structured()) {
    for (json& part : node) LeaveNamesOnly(part);
  } else if (node.is_string()) {
    const auto text = node.get<std::string>();
    node = text.substr(text.rfind('/') + 1);
  }
}

void Put(std::vector<double>& row, const session::PoseSample& sample) {
  const Eigen::Vector3d t_mm = sample.reference_from_tool.translation();
  const Eigen::Quaterniond& q = sample.reference_from_tool.quaternion();
  row.insert(row.end(),
             {sample.valid ? 1.0 : 0.0, t_mm.x(), t_mm.y(), t_mm.z(), q.w(), q.x(), q.y(), q.z()});
}

/// 8 numbers. False if they are no pose.
bool Get(const double*& at, session::PoseSample& sample) {
  const Eigen::Vector3d t_mm(at[1], at[2], at[3]);
  const Eigen::Quaterniond q(at[4], at[5], at[6], at[7]);
  const bool is_pose = (at[0] == 0.0 || at[0] == 1.0) && t_mm.cwiseAbs().maxCoeff() < kLargestMm &&
                       t_mm.allFinite() && std::abs(q.norm() - 1.0) < 1e-6;
  if (!is_pose) return false;
  sample.valid = at[0] == 1.0;
  sample.reference_from_tool = transforms::Pose(q, t_mm);
  at += 8;
  return true;
}

double NumberOf(const std::optional<double>& value) {
  return value.value_or(std::numeric_limits<double>::quiet_NaN());
}

/// NaN stands for a value that is not set. False if it is out of all bounds.
bool Get(const double*& at, std::optional<double>& value) {
  if (std::isinf(*at)) return false;
  if (!std::isnan(*at)) value = *at;
  ++at;
  return true;
}

/// False if no hand has this force.
bool Get(const double*& at, double& force_n) {
  if (!(std::abs(*at) <= session::kMostPlungerN)) return false;
  force_n = *at++;
  return true;
}

bool Get(const double*& at, session::BreathSample& breath) {
  if (!std::all_of(at, at + 3, [](double value) { return std::abs(value) < 1e6; })) return false;
  breath.cycle = at[0];
  breath.level = at[1];
  breath.level_per_s = at[2];
  at += 3;
  return true;
}

}  // namespace

std::string DigestOf(const scenario::Scenario& scenario, const simulation::Scene& scene) {
  json settings = scenario.effective;
  for (const char* key : {"name", "description", "patient", "session", "evidence"}) {
    settings.erase(key);
  }
  LeaveNamesOnly(settings);
  json files = json::object();
  for (const simulation::PlannedInput& input : scene.plan.inputs()) {
    if (input.file.empty() || !scene.plan.Needs(input.port)) continue;
    files[input.where] = Sha256OfPath(input.file);
  }
  json stages = json::array();
  for (const simulation::PlannedStage& stage : scene.plan.stages()) {
    if (stage.in) stages.push_back(std::string(stage.name));
  }
  std::vector<double> matrix(scene.ct_from_reference.matrix().data(),
                             scene.ct_from_reference.matrix().data() + 16);
  // Surfaces are converted to labels, whose hash stands for all their files.
  std::string labels;
  if (scene.labels && !scenario.patient.surfaces.empty()) {
    labels = Sha256OfText({scene.labels->voxels.begin(), scene.labels->voxels.end()});
  }
  const json all = {{"build", Version()},
                    {"settings", settings},
                    {"files", files},
                    {"stages", stages},
                    {"labels", labels},
                    {"ct_from_reference", matrix},
                    {"series", scenario.patient.dicom_series}};
  return Sha256OfText(all.dump());
}

Bytes PackRequest(const std::string& digest) {
  return tracking::PackText(kRequestName, json{{"format", kFormat}, {"digest", digest}}.dump());
}

std::optional<std::string> ReadRequest(const IgtlHeader& header, ByteView content) {
  if (header.type != "STRING" || header.device != kRequestName) return std::nullopt;
  const auto text = tracking::ReadText(content);
  if (!text) return std::nullopt;
  const json request = json::parse(*text, nullptr, /*allow_exceptions=*/false);
  if (!request.is_object() || request.value("format", json()) != kFormat) return std::nullopt;
  const json digest = request.value("digest", json());
  if (!digest.is_string()) return std::nullopt;
  return digest.get<std::string>();
}

Bytes PackSteps(std::span<const StepInput> steps, std::int64_t first_number) {
  ACUS_ASSERT(!steps.empty() && steps.size() <= kMostStepsInMessage);
  tracking::NumberTable table{.columns = kColumns};
  table.values.reserve(kColumns * steps.size());
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const StepInput& step = steps[i];
    table.values.push_back(static_cast<double>(first_number + static_cast<std::int64_t>(i)));
    table.values.push_back(static_cast<double>(step.time_ns));
    Put(table.values, step.needle);
    Put(table.values, step.probe);
    for (const double value : {step.breath.cycle, step.breath.level, step.breath.level_per_s,
                               NumberOf(step.gain_db), NumberOf(step.depth_mm), step.plunger_n}) {
      table.values.push_back(value);
    }
  }
  return tracking::PackTable(kStepsName, steps.back().time_ns, table);
}

std::optional<std::vector<StepInput>> ReadSteps(ByteView content, std::int64_t first_number,
                                                std::int64_t after_ns) {
  const auto table = tracking::ReadTable(content);
  if (!table || table->columns != kColumns) return std::nullopt;
  std::vector<StepInput> steps(table->values.size() / kColumns);
  if (steps.size() > kMostStepsInMessage) return std::nullopt;
  const double* at = table->values.data();
  for (StepInput& step : steps) {
    if (*at++ != static_cast<double>(first_number++)) return std::nullopt;
    const double time_ns = *at++;
    if (!(std::abs(time_ns) < kLargestTimeNs) || time_ns != std::floor(time_ns))
      return std::nullopt;
    step.time_ns = static_cast<std::int64_t>(time_ns);
    if (step.time_ns <= after_ns) return std::nullopt;
    after_ns = step.time_ns;
    const bool is_right = Get(at, step.needle) && Get(at, step.probe) && Get(at, step.breath) &&
                          Get(at, step.gain_db) && Get(at, step.depth_mm) &&
                          Get(at, step.plunger_n);
    if (!is_right) return std::nullopt;
    step.needle.time_ns = step.probe.time_ns = step.breath.time_ns = step.time_ns;
  }
  return steps;
}

std::vector<std::string> ImageNames(const simulation::Scene& scene) {
  std::vector<std::string> names = {"Ultrasound", "CtSlice"};
  for (const simulation::ListedEffect& effect : scene.listed.all()) {
    if (!effect.has_image || !effect.timing.is_live) continue;
    names.emplace_back(std::string(effect.key).substr(0, tracking::kIgtlNameBytes));
  }
  return names;
}

std::vector<Bytes> MomentPacker::Pack(const LiveImage& image) {
  std::vector<Bytes> messages;
  sent_.resize(names_.size());
  std::size_t n = 0;
  Eigen::Matrix4d reference_from_pixel = Eigen::Matrix4d::Identity();
  const auto add = [&](int width, int height, int channels,
                       const std::vector<std::uint8_t>& pixels) {
    const std::size_t at = n++;
    if (pixels.empty() || pixels == sent_[at]) return;
    sent_[at] = pixels;
    messages.push_back(tracking::PackImage(names_[at], image.time_ns,
                                           {.width = width,
                                            .height = height,
                                            .channels = channels,
                                            .pixels = pixels,
                                            .reference_from_pixel = reference_from_pixel}));
  };
  if (image.probe) {
    reference_from_pixel = scene_.ct_from_reference.inverse().matrix() *
                           image.snapshot.moment.ct_from_probe.matrix() *
                           acoustics::ImageOf(*image.probe).probe_from_image().matrix();
  }
  const auto add_gray = [&](const image::GrayImage& gray) {
    add(gray.width, gray.height, 1, gray.pixels);
  };
  add_gray(image.images.b_mode);
  add_gray(image.images.ct_slice);
  reference_from_pixel.setIdentity();
  for (const simulation::EffectImage& effect : image.effects) {
    const image::ColourImage& colour = effect.pixels.colour;
    if (colour.rgb.empty()) {
      add_gray(effect.pixels.gray);
    } else {
      add(colour.width, colour.height, 3, colour.rgb);
    }
  }
  messages.push_back(tracking::PackTable(
      kMomentName, image.time_ns,
      {.columns = 2,
       .values = {static_cast<double>(image.time_ns), static_cast<double>(messages.size())}}));
  return messages;
}

bool MomentReader::TakeImage(const IgtlHeader& header, ByteView content) {
  const auto found = std::ranges::find(names_, header.device);
  if (found == names_.end()) return false;
  auto image = tracking::ReadImage(content);
  if (!image) return false;
  const auto n = static_cast<std::size_t>(found - names_.begin());
  if (n < 2) {
    if (image->channels != 1) return false;
    image::GrayImage& into = n == 0 ? images_.images.b_mode : images_.images.ct_slice;
    into = {image->width, image->height, std::move(image->pixels)};
    return true;
  }
  images_.effects.resize(names_.size() - 2);
  effects::EffectPixels& into = images_.effects[n - 2];
  into = {};
  if (image->channels == 1) into.gray = {image->width, image->height, std::move(image->pixels)};
  if (image->channels == 3) into.colour = {image->width, image->height, std::move(image->pixels)};
  return true;
}

bool MomentReader::Take(const IgtlHeader& header, ByteView content) {
  if (header.type == "IMAGE") return TakeImage(header, content);
  if (header.type != "NDARRAY" || header.device != kMomentName) return false;
  const auto table = tracking::ReadTable(content);
  if (!table || table->values.size() != 2 || !(std::abs(table->values[0]) < kLargestTimeNs)) {
    return false;
  }
  const auto time_ns = static_cast<std::int64_t>(table->values[0]);
  if (images_.number > 0 && time_ns <= images_.time_ns) return false;
  images_.time_ns = time_ns;
  ++images_.number;
  whole_ = true;
  return true;
}

bool MomentReader::TakeWhole() {
  return std::exchange(whole_, false);
}

}  // namespace acus::live
