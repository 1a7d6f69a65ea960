#include "acus/data/volume/dicom_frame.h"

#include <algorithm>

#include "acus/base/core/error.h"
#include "acus/base/core/words.h"
#include "acus/data/volume/dicom_items.h"

namespace acus::volume {
namespace {

constexpr std::uint32_t kFrameUid = 0x00200052U;
constexpr std::uint32_t kSeriesUid = 0x0020000EU;

void AddUid(const DicomItem& item, std::uint32_t tag, std::vector<std::string>& uids) {
  std::string uid = item.Text(tag);
  if (!uid.empty() && std::ranges::find(uids, uid) == uids.end()) uids.push_back(std::move(uid));
}

const std::vector<DicomItem>& SequenceOf(const DicomItem& item, std::uint32_t tag) {
  static const std::vector<DicomItem> kNone;
  const auto found = item.sequences.find(tag);
  return found == item.sequences.end() ? kNone : found->second;
}

bool HaveOneInCommon(const std::vector<std::string>& a, const std::vector<std::string>& b) {
  return std::ranges::find_first_of(a, b) != a.end();
}

}  // namespace

DicomFrame FrameOfLabels(const std::filesystem::path& object) {
  const DicomDataSet data = ReadDicomDataSet(object);
  DicomFrame frame;
  for (const DicomItem& roi : SequenceOf(data.root, 0x30060020U)) {
    AddUid(roi, 0x30060024U, frame.uids);
  }
  const auto& referenced = SequenceOf(data.root, 0x30060010U);
  const bool by_rois = !frame.uids.empty();
  for (const DicomItem& item : referenced) {
    if (!by_rois) AddUid(item, kFrameUid, frame.uids);
    for (const DicomItem& study : SequenceOf(item, 0x30060012U)) {
      for (const DicomItem& series : SequenceOf(study, 0x30060014U)) {
        AddUid(series, kSeriesUid, frame.series);
      }
    }
  }
  if (frame.uids.empty()) AddUid(data.root, kFrameUid, frame.uids);
  for (const DicomItem& series : SequenceOf(data.root, 0x00081115U)) {
    AddUid(series, kSeriesUid, frame.series);
  }
  return frame;
}

void RequireSameFrame(const DicomFrame& labels, const DicomFrame& ct, bool accept_other,
                      const std::filesystem::path& object, const RunContext& context) {
  const bool have_frames = !labels.uids.empty() && !ct.uids.empty();
  const bool have_series = !labels.series.empty() && !ct.series.empty();
  const bool is_other_frame = have_frames && !HaveOneInCommon(labels.uids, ct.uids);
  const bool is_other_series = have_series && !HaveOneInCommon(labels.series, ct.series);
  const std::string series = have_series
                                 ? Message("; it was drawn on series ", Joined(labels.series),
                                           ", the CT is ", Joined(ct.series))
                                 : std::string();
  const std::string frames = Message(object.string(), ": its frame of reference is ",
                                     Joined(labels.uids), ", that of the CT ", Joined(ct.uids));
  if (is_other_frame && have_series && !is_other_series) {
    context.Warn(frames + ", but it was drawn on the series of the CT; it is taken as it lies");
  } else if (is_other_frame && accept_other) {
    context.Warn(Message(frames, series, "; it is taken as it lies"));
  } else if (is_other_frame) {
    throw InputError(Message(frames, series,
                             ". Coordinates of the two do not belong together: give the CT that it "
                             "was drawn on, or --accept-implausible"));
  } else if (is_other_series) {
    context.Warn(Message(object.string(), have_frames ? ": of the CT's frame of reference" : "",
                         series, "; look whether the patient lies the same in both"));
  }
}

}  // namespace acus::volume
