#include "acus/data/volume/dicom_groups.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <set>
#include <tuple>

#include "acus/base/core/error.h"
#include "acus/base/core/number_text.h"
#include "acus/base/core/parallel.h"
#include "acus/data/volume/dicom_pixels.h"

namespace acus::volume {
namespace {

namespace fs = std::filesystem;

constexpr double kSameAxes = 5e-3;     ///< rad. Larger angles are another scan, or a scout.
constexpr double kNotedAxes = 2e-4;    ///< rad. Smaller ones are rounding.
constexpr double kSameSpacing = 1e-3;  ///< Relative.
constexpr double kSamePlaceMm = 1e-3;
constexpr std::size_t kFewestSlices = 3;  ///< Of a volume.
constexpr double kSameStep = 0.02;        ///< Between slices, relative.
constexpr double kRoundedStepMm = 0.21;   ///< Steps that differ by less may be rounded.
constexpr double kMostMissing = 4.5;      ///< Steps of a gap in which slices are missing.

using Headers = std::vector<DicomHeader>;

std::vector<fs::path> FilesIn(const fs::path& folder) {
  std::error_code error;
  if (fs::is_regular_file(folder, error)) return {folder};  // A multi-frame object.
  ACUS_REQUIRE(fs::is_directory(folder, error), folder.string(), ": no such folder");
  std::vector<fs::path> files;
  const auto options = fs::directory_options::skip_permission_denied;
  for (auto it = fs::recursive_directory_iterator(folder, options, error);
       it != fs::recursive_directory_iterator(); it.increment(error)) {
    if (!error && it->is_regular_file(error)) files.push_back(it->path());
  }
  std::ranges::sort(files);
  return files;
}

Headers ImagesIn(const fs::path& folder, int num_threads) {
  const auto files = FilesIn(folder);
  std::vector<Headers> read(files.size());
  std::vector<std::string> others(files.size());
  ParallelFor(static_cast<int>(files.size()), num_threads, [&](int i) {
    const auto at = static_cast<std::size_t>(i);
    const auto header = ReadDicomHeader(files[at]);
    if (!header) return;
    if (!header->has_pixels) {
      others[at] = header->modality;
    } else if (header->num_frames > 1 && header->modality == "CT") {
      read[at] = FramesOf(*header);
    } else {
      read[at] = {*header};
    }
  });
  Headers images;
  for (Headers& some : read) std::ranges::move(some, std::back_inserter(images));
  std::set<std::string> kinds(others.begin(), others.end());
  kinds.erase("");
  std::string what;
  for (const std::string& kind : kinds) what += (what.empty() ? "; there is: " : ", ") + kind;
  ACUS_REQUIRE(!images.empty(), folder.string(), ": no DICOM image in it (", files.size(),
               " files looked at", what, "); give the folder that holds the slices");
  return images;
}

double AngleBetween(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

double AngleBetween(const DicomHeader& a, const DicomHeader& b) {
  return std::max(AngleBetween(a.column_axis, b.column_axis), AngleBetween(a.row_axis, b.row_axis));
}

bool AreOneStack(const DicomHeader& a, const DicomHeader& b) {
  return a.is_placed == b.is_placed && AngleBetween(a, b) < kSameAxes &&
         ((a.spacing_mm / b.spacing_mm - 1.0).abs() < kSameSpacing).all();
}

/// Series, moment, size: what must be equal.
using GroupKey = std::tuple<std::string, int, int, int>;

std::vector<Headers> Stacks(Headers images) {
  std::map<GroupKey, std::vector<Headers>> stacks;
  for (DicomHeader& image : images) {
    auto& of_key = stacks[{image.series_uid, image.temporal_position, image.columns, image.rows}];
    const auto found = std::ranges::find_if(
        of_key, [&](const Headers& stack) { return AreOneStack(stack.front(), image); });
    auto& stack = found == of_key.end() ? of_key.emplace_back() : *found;
    stack.push_back(std::move(image));
  }
  std::vector<Headers> out;
  for (auto& [key, of_key] : stacks) std::ranges::move(of_key, std::back_inserter(out));
  return out;
}

/// All get the axes and the pixel spacing of the first.
void MakeParallel(Headers& stack, std::vector<std::string>& notes) {
  double largest_rad = 0.0;
  for (DicomHeader& header : stack) {
    largest_rad = std::max(largest_rad, AngleBetween(stack.front(), header));
    header.column_axis = stack.front().column_axis;
    header.row_axis = stack.front().row_axis;
    header.spacing_mm = stack.front().spacing_mm;
  }
  if (largest_rad > kNotedAxes) {
    notes.push_back(Message("orientations of the slices differ by up to ", largest_rad * 1e3,
                            " mrad; that of the first is used for all"));
  }
}

double Along(const DicomHeader& header) {
  return header.position_mm.dot(NormalOf(header));
}

bool AreAtOnePlace(const DicomHeader& a, const DicomHeader& b) {
  return (a.position_mm - b.position_mm).norm() < kSamePlaceMm;
}

bool AreCopies(const DicomHeader& a, const DicomHeader& b) {
  if (!AreAtOnePlace(a, b)) return false;
  if (!a.instance_uid.empty() && a.instance_uid == b.instance_uid) return true;
  // Phases of a breath may have equal pixels: copies also have the same place in the series.
  const bool is_same_image = a.instance_number == b.instance_number &&
                             a.acquisition_number == b.acquisition_number &&
                             a.acquisition_time == b.acquisition_time && a.comments == b.comments;
  if (!is_same_image) return false;
  try {
    return DecodedSlice(a) == DecodedSlice(b);
  } catch (const InputError&) {
    return false;  // Reading the pixels reports it.
  }
}

/// @pre in order along the normal.
void DropCopies(Headers& stack, std::vector<std::string>& notes) {
  Headers kept;
  for (DicomHeader& header : stack) {
    bool is_copy = false;
    for (auto other = kept.rbegin(); other != kept.rend() && !is_copy; ++other) {
      if (!AreAtOnePlace(*other, header)) break;
      is_copy = AreCopies(*other, header);
    }
    if (!is_copy) kept.push_back(std::move(header));
  }
  if (kept.size() < stack.size()) {
    notes.push_back(Message(stack.size() - kept.size(), " identical copies of slices omitted"));
  }
  stack = std::move(kept);
}

bool HasSharedPlaces(const Headers& sorted) {
  return std::ranges::adjacent_find(sorted, AreAtOnePlace) != sorted.end();
}

void SortAlong(Headers& stack) {
  std::ranges::stable_sort(stack, {}, Along);
}

/// A part of a stack with what distinguishes it from the others.
struct Part {
  std::string name;
  Headers headers;
};

using NameOf = std::function<std::string(const DicomHeader&)>;

/// What may distinguish the volumes of one series.
struct Way {
  const char* what;
  NameOf name_of;
  bool is_time = false;
};

/// Numbers in their order, before other texts.
struct InOrderOfNumbers {
  bool operator()(const std::string& a, const std::string& b) const {
    const auto x = ParseFinite(a), y = ParseFinite(b);
    if (x && y && *x != *y) return *x < *y;
    return x.has_value() == y.has_value() ? a < b : x.has_value();
  }
};

/// Parts by a value in the headers; nothing if they are not volumes of their own.
std::vector<Part> PartsBy(const Headers& stack, const NameOf& name_of) {
  std::map<std::string, Headers, InOrderOfNumbers> by_name;
  for (const DicomHeader& header : stack) by_name[name_of(header)].push_back(header);
  if (by_name.size() < 2) return {};
  std::vector<Part> parts;
  for (auto& [name, headers] : by_name) {
    SortAlong(headers);
    if (headers.size() < kFewestSlices || HasSharedPlaces(headers)) return {};
    parts.push_back({name, std::move(headers)});
  }
  return parts;
}

/// The k-th image at each place, in the order of the instances, is of part k. Nothing if the places
/// do not all have the same number of images.
std::vector<Part> PartsByOrder(const Headers& stack) {
  std::vector<Headers> places;
  for (const DicomHeader& header : stack) {
    if (places.empty() || !AreAtOnePlace(places.back().front(), header)) places.emplace_back();
    places.back().push_back(header);
  }
  const std::size_t count = places.front().size();
  std::vector<Part> parts(count);
  for (Headers& place : places) {
    if (place.size() != count || places.size() < kFewestSlices) return {};
    std::ranges::stable_sort(place, {}, &DicomHeader::instance_number);
    for (std::size_t k = 0; k < count; ++k) parts[k].headers.push_back(std::move(place[k]));
  }
  for (std::size_t k = 0; k < count; ++k) parts[k].name = Message("part ", k + 1);
  return parts;
}

/// Blocks of evenly spaced slices, of a scan whose step changes or that was interrupted. Nothing
/// for one block, and for a gap of a few whole steps: there slices are missing.
std::vector<Part> BlocksOf(const Headers& stack) {
  if (stack.size() < 2 * kFewestSlices) return {};
  std::vector<double> steps;
  for (std::size_t n = 1; n < stack.size(); ++n) {
    steps.push_back(Along(stack[n]) - Along(stack[n - 1]));
  }
  if (std::ranges::min(steps) < kSamePlaceMm) return {};
  const auto is_same = [](double a, double b) { return std::abs(a - b) <= kSameStep * b + 0.01; };
  std::vector<std::size_t> begins = {0};
  bool is_block = false;
  for (std::size_t n = 0; n < steps.size(); ++n) {
    const double step = steps[begins.back()];
    if (is_same(steps[n], step)) continue;
    if (std::abs(steps[n] - step) < kRoundedStepMm || n + 1 >= steps.size() ||
        n + 1 < begins.back() + kFewestSlices) {
      return {};
    }
    const double next = steps[n + 1];
    const double gap = steps[n] / step;
    is_block = is_block || !is_same(next, step) || gap > kMostMissing || gap < 1.0 ||
               std::abs(gap - std::round(gap)) > kSameStep;
    begins.push_back(n + 1);
  }
  if (!is_block || stack.size() < begins.back() + kFewestSlices) return {};
  std::vector<Part> blocks;
  for (std::size_t b = 0; b < begins.size(); ++b) {
    const auto end =
        b + 1 < begins.size() ? stack.begin() + std::ptrdiff_t(begins[b + 1]) : stack.end();
    blocks.push_back({Message("block ", b + 1, " of ", begins.size()),
                      Headers(stack.begin() + std::ptrdiff_t(begins[b]), end)});
  }
  return blocks;
}

/// The one text that all headers have; empty if they differ.
std::string CommonText(const Headers& headers, std::string DicomHeader::*text) {
  for (const DicomHeader& header : headers) {
    if (header.*text != headers.front().*text) return {};
  }
  return headers.front().*text;
}

/// @param stack  In order along the normal.
std::vector<Part> PartsOf(Headers stack, std::vector<std::string>& notes) {
  if (stack.front().is_placed && HasSharedPlaces(stack)) {
    // Times are no names: their parts are counted in their order.
    const Way ways[] = {
        {"acquisition number", [](const DicomHeader& h) { return h.acquisition_number; }},
        {"percentage of the cycle",
         [](const DicomHeader& h) {
           return h.phase_percentage.empty() ? "" : h.phase_percentage + "%";
         }},
        {"comment", [](const DicomHeader& h) { return h.comments; }},
        {"description", [](const DicomHeader& h) { return h.description; }},
        {"trigger time", [](const DicomHeader& h) { return h.trigger_time; }, true},
        {"acquisition time", [](const DicomHeader& h) { return h.acquisition_time; }, true},
        {"content time", [](const DicomHeader& h) { return h.content_time; }, true},
        {"image type", [](const DicomHeader& h) { return h.image_type; }}};
    const char* by = "the order of the instances";
    std::vector<Part> parts;
    for (const Way& way : ways) {
      parts = PartsBy(stack, way.name_of);
      if (parts.empty()) continue;
      by = way.what;
      for (std::size_t k = 0; way.is_time && k < parts.size(); ++k) {
        parts[k].name = Message("part ", k + 1);
      }
      break;
    }
    if (parts.empty()) parts = PartsByOrder(stack);
    if (!parts.empty()) {
      for (Part& part : parts) {  // Comments name phases, numbers do not.
        const std::string comment = CommonText(part.headers, &DicomHeader::comments);
        if (!comment.empty()) part.name = comment;
      }
      notes.push_back(Message("the series holds ", parts.size(), " volumes, split by ", by));
      return parts;
    }
  }
  if (auto blocks = stack.front().is_placed ? BlocksOf(stack) : std::vector<Part>();
      !blocks.empty()) {
    notes.push_back(Message("the series holds ", blocks.size(), " blocks of slices"));
    return blocks;
  }
  std::vector<Part> one(1);
  one[0].headers = std::move(stack);
  return one;
}

/// " (MIP)" and the like, of images that were computed from several.
std::string DerivedWord(const std::string& image_type) {
  for (const char* word : {"MIP", "MINIP", "AVERAGE", "AVG", "MEAN"}) {
    const std::string type = "\\" + image_type + "\\";
    if (type.find(Message("\\", word, "\\")) != type.npos) return Message(" (", word, ")");
  }
  return {};
}

}  // namespace

Eigen::Vector3d NormalOf(const DicomHeader& header) {
  return header.column_axis.cross(header.row_axis);
}

std::vector<SliceGroup> SliceGroupsIn(const fs::path& folder, int num_threads) {
  std::map<std::string, int> parts_of_uid;
  std::vector<SliceGroup> groups;
  for (Headers& stack : Stacks(ImagesIn(folder, num_threads))) {
    std::vector<std::string> notes;
    MakeParallel(stack, notes);
    SortAlong(stack);
    if (stack.front().is_placed) DropCopies(stack, notes);
    for (Part& part : PartsOf(std::move(stack), notes)) {
      const DicomHeader& first = part.headers.front();
      const std::string uid = first.series_uid.empty() ? "unnamed" : first.series_uid;
      const int number = ++parts_of_uid[uid];
      SliceGroup& group = groups.emplace_back();
      group.series = {
          .uid = number == 1 ? uid : Message(uid, "#", number),
          .description =
              first.description +
              (part.name.empty() || part.name == first.description ? "" : " [" + part.name + "]") +
              DerivedWord(first.image_type),
          .temporal_position = first.temporal_position,
          .files = {},
          .image_size = {first.columns, first.rows}};
      for (const DicomHeader& header : part.headers) group.series.files.push_back(header.file);
      group.notes = notes;
      group.headers = std::move(part.headers);
    }
  }
  std::ranges::stable_sort(groups, [](const SliceGroup& a, const SliceGroup& b) {
    return a.headers.size() > b.headers.size();
  });
  return groups;
}

}  // namespace acus::volume
