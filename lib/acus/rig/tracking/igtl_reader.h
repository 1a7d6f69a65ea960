// A stream of bytes from a peer that need not mean well, to OpenIGTLink messages.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "acus/rig/tracking/igtl_wire.h"

namespace acus::tracking {

/// A whole message. The views hold until the next call of the reader.
struct IgtlMessage {
  IgtlHeader header = {};
  IgtlBody body = {};
};

/// Cuts a stream into messages.
///
/// Memory follows what came, never what a header promises: types that are not kept pass through
/// uncopied, kept ones are at most kMaxKeptBytes (images kMaxIgtlBodyBytes). Bytes that cannot
/// begin a message are skipped one by one until some can; so is a message whose checksum is wrong,
/// since its size may be as wrong. Everything is counted.
class IgtlReader {
 public:
  struct Options {
    bool keep_images = false;
    bool keep_tables = false;  ///< And texts: NDARRAY, STRING.
    bool check_crc = true;     ///< Off for senders that leave it 0.
  };
  struct Counts {
    std::uint64_t messages = 0;        ///< Whole and right, kept or not.
    std::uint64_t other_messages = 0;  ///< Of these: of a type that is not kept.
    std::uint64_t bad_messages = 0;    ///< Checksum or sizes inside wrong.
    std::uint64_t bad_checksums = 0;   ///< Of these: the checksum.
    std::uint64_t skipped_bytes = 0;   ///< Not part of any message.
  };

  explicit IgtlReader(const Options& options) : options_(options) {}

  /// Takes what came. Call Next() until there is nothing before more is appended.
  void Append(ByteView bytes);
  /// The next message of a type that is kept. Nothing: more bytes are needed.
  std::optional<IgtlMessage> Next();

  const Counts& counts() const { return counts_; }
  /// Bytes skipped since the last good message: much of it is a peer that speaks something else.
  std::uint64_t skipped_in_a_row() const { return skipped_in_a_row_; }
  /// Names in messages whose checksum was wrong (the first few; they may be damaged).
  const std::vector<std::string>& refused_names() const { return refused_names_; }
  /// A message has begun and not ended.
  bool in_message() const { return passing_bytes_ > 0 || begin_ < buffer_.size(); }
  std::size_t memory_bytes() const { return buffer_.capacity(); }

 private:
  bool IsKept(const std::string& type) const;
  void NoteBadChecksum(const std::string& name);
  void SkipByte();
  void SkipToPlausible();
  void Pass();

  static constexpr std::uint64_t kMaxKeptBytes = 64 * 1024;
  static constexpr std::size_t kMaxRefusedNames = 8;

  Options options_;
  Counts counts_;
  std::vector<std::string> refused_names_;
  std::uint64_t skipped_in_a_row_ = 0;
  Bytes buffer_;
  std::size_t begin_ = 0;             ///< What is before was dealt with.
  std::optional<IgtlHeader> header_;  ///< Of the message at begin_, if it is known.
  std::uint64_t passing_bytes_ = 0;   ///< Left of the body of a message that is not kept.
  std::uint64_t passing_crc_ = 0;
  std::uint64_t expected_crc_ = 0;
};

}  // namespace acus::tracking
