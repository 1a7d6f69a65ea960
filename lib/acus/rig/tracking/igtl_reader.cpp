#include "acus/rig/tracking/igtl_reader.h"

#include <algorithm>

namespace acus::tracking {

bool IgtlReader::IsKept(const std::string& type) const {
  static constexpr std::string_view kKept[] = {"TRANSFORM",  "TDATA",      "QTDATA",    "POSITION",
                                               "STATUS",     "STT_TDATA",  "STP_TDATA", "RTS_TDATA",
                                               "GET_STATUS", "GET_CAPABIL"};
  if (type == "IMAGE") return options_.keep_images;
  if (type == "NDARRAY" || type == "STRING") return options_.keep_tables;
  return std::find(std::begin(kKept), std::end(kKept), type) != std::end(kKept);
}

void IgtlReader::Append(ByteView bytes) {
  buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(begin_));
  begin_ = 0;
  // One large image must not hold its memory for ever.
  if (buffer_.empty() && buffer_.capacity() > 4 * 1024 * 1024) Bytes().swap(buffer_);
  buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
}

void IgtlReader::NoteBadChecksum(const std::string& name) {
  ++counts_.bad_checksums;
  const bool is_new = std::ranges::find(refused_names_, name) == refused_names_.end();
  if (is_new && refused_names_.size() < kMaxRefusedNames) refused_names_.push_back(name);
}

void IgtlReader::SkipByte() {
  ++begin_;
  ++counts_.skipped_bytes;
  ++skipped_in_a_row_;
  header_.reset();
}

void IgtlReader::SkipToPlausible() {
  while (!header_ && buffer_.size() - begin_ >= kIgtlHeaderBytes) {
    header_ = ParseHeader(ByteView(buffer_).subspan(begin_, kIgtlHeaderBytes));
    if (header_ && IsKept(header_->type) && header_->type != "IMAGE" &&
        header_->body_bytes > kMaxKeptBytes) {
      header_.reset();
    }
    if (!header_) SkipByte();
  }
}

void IgtlReader::Pass() {
  const ByteView rest = ByteView(buffer_).subspan(begin_);
  const ByteView part = rest.first(std::min<std::uint64_t>(rest.size(), passing_bytes_));
  passing_crc_ = Crc64(part, passing_crc_);
  begin_ += part.size();
  passing_bytes_ -= part.size();
  if (passing_bytes_ > 0) return;
  if (options_.check_crc && passing_crc_ != expected_crc_) {
    ++counts_.bad_messages;
    return;
  }
  ++counts_.messages;
  ++counts_.other_messages;
  skipped_in_a_row_ = 0;
}

std::optional<IgtlMessage> IgtlReader::Next() {
  for (;;) {
    if (passing_bytes_ > 0) {
      Pass();
      if (passing_bytes_ > 0) return std::nullopt;
    }
    SkipToPlausible();
    if (!header_) return std::nullopt;
    if (!IsKept(header_->type)) {
      passing_bytes_ = header_->body_bytes;
      passing_crc_ = 0;
      expected_crc_ = header_->crc;
      begin_ += kIgtlHeaderBytes;
      header_.reset();
      if (passing_bytes_ == 0) Pass();
      continue;
    }
    const std::size_t body_bytes = header_->body_bytes;
    if (buffer_.size() - begin_ < kIgtlHeaderBytes + body_bytes) return std::nullopt;
    const ByteView body = ByteView(buffer_).subspan(begin_ + kIgtlHeaderBytes, body_bytes);
    const bool is_right = !options_.check_crc || Crc64(body) == header_->crc;
    std::optional<IgtlBody> parts;
    if (is_right) parts = SplitBody(*header_, body);
    if (!parts) {
      ++counts_.bad_messages;
      if (!is_right) NoteBadChecksum(header_->device);
      // An image that is wrong is passed over whole: looking for messages among its pixels, each
      // as large as it, would take for ever.
      if (header_->type == "IMAGE") {
        begin_ += kIgtlHeaderBytes + body_bytes;
        header_.reset();
      } else {
        SkipByte();
      }
      continue;
    }
    ++counts_.messages;
    skipped_in_a_row_ = 0;
    begin_ += kIgtlHeaderBytes + body_bytes;
    IgtlMessage message{.header = std::move(*header_), .body = std::move(*parts)};
    header_.reset();
    return message;
  }
}

}  // namespace acus::tracking
