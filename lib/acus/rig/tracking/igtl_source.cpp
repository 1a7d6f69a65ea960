#include "acus/rig/tracking/igtl_source.h"

#include <algorithm>
#include <map>
#include <mutex>
#include <poll.h>
#include <thread>

#include "acus/base/core/error.h"
#include "acus/base/core/monotonic_time.h"
#include "acus/base/core/words.h"
#include "acus/rig/tracking/igtl_reader.h"
#include "acus/rig/tracking/igtl_tools.h"
#include "acus/rig/tracking/socket.h"

namespace acus::tracking {
namespace {

constexpr std::int64_t kNsPerMs = 1'000'000;
constexpr int kFirstWaitMs = 100, kLongestWaitMs = 2000, kConnectMs = 2000;
constexpr int kPollMs = 20;  // How late silence is noticed.
constexpr std::uint64_t kMaxRubbishBytes = 64 * 1024;
constexpr std::size_t kMaxImageStreams = 16;

std::vector<std::string> Names(const std::vector<IgtlTool>& tools) {
  std::vector<std::string> names;
  for (const IgtlTool& tool : tools) names.push_back(tool.tool);
  return names;
}

void Check(const IgtlOptions& options) {
  ACUS_REQUIRE(options.port >= (options.listen ? 0 : 1) && options.port <= 65535, "tracker '",
               options.name, "': port is ", options.port, "; allowed are 1 to 65535");
  ACUS_REQUIRE(options.lost_after_ms >= 1 && options.silence_ms >= 1 && options.message_ms >= 1,
               "tracker '", options.name, "': times must be at least 1 ms");
}

}  // namespace

class IgtlSource::Receiver {
 public:
  explicit Receiver(IgtlOptions options)
      : options_((Check(options), std::move(options))),
        board_(Names(options_.tools), options_.journal_capacity),
        tools_(options_.tools, options_.lost_after_ms * kNsPerMs, board_) {}

  void Start() {
    if (thread_.joinable()) return;
    if (options_.listen) {
      listener_ = ListenTcp(options_.host, options_.port);
      port_ = PortOf(listener_);
    }
    wake_.Clear();
    stopping_ = false;
    thread_ = std::thread([this] { Run(); });
  }

  void Stop() noexcept {
    if (!thread_.joinable()) return;
    stopping_ = true;
    wake_.Ring();
    thread_.join();
    listener_.Close();
  }

  const IgtlOptions& options() const { return options_; }
  PoseBoard& board() { return board_; }
  int port() const { return port_; }

  SourceStatus status() const {
    const std::lock_guard lock(mutex_);
    return status_;
  }

  std::shared_ptr<const ReceivedImage> Image(const std::string& device) const {
    const std::lock_guard lock(mutex_);
    const auto found = images_.find(device);
    return found == images_.end() ? nullptr : found->second;
  }

 private:
  void Run();
  Descriptor Connect();
  bool Wait(int ms, int other_fd);
  void Serve(const Descriptor& socket);
  bool ReceiveSome(const Descriptor& socket, IgtlReader& reader);
  void Handle(const IgtlMessage& message, std::int64_t arrival_ns);
  void KeepImage(const IgtlMessage& message, std::int64_t arrival_ns);
  void SetState(SourceState state, const std::string& error);
  void PublishStatus(const IgtlReader& reader);
  std::vector<std::string> WhyNotSeen(const IgtlReader& reader) const;

  const IgtlOptions options_;
  PoseBoard board_;
  IgtlTools tools_;
  WakeUp wake_;
  Descriptor listener_;
  int port_ = 0;
  std::thread thread_;
  std::atomic<bool> stopping_{false};

  // State of the receiving thread.
  Bytes chunk_ = Bytes(256 * 1024);
  IgtlReader::Counts before_;  ///< Of all links before this one.
  std::uint64_t unreadable_ = 0, unexpected_ = 0, connects_ = 0;
  std::int64_t last_news_ns_ = 0;
  std::string error_, peer_status_;

  mutable std::mutex mutex_;
  SourceStatus status_;
  std::map<std::string, std::shared_ptr<const ReceivedImage>> images_;
};

void IgtlSource::Receiver::Run() {
  int wait_ms = kFirstWaitMs;
  while (!stopping_) {
    SetState(SourceState::kConnecting, error_);
    const Descriptor socket = Connect();
    if (stopping_) break;
    const std::uint64_t messages = before_.messages;
    if (socket.valid()) {
      ++connects_;
      Serve(socket);
      if (before_.messages > messages) wait_ms = kFirstWaitMs;
    }
    if (stopping_) break;
    SetState(SourceState::kConnecting, error_);
    Wait(wait_ms, -1);
    wait_ms = std::min(2 * wait_ms, kLongestWaitMs);
  }
  SetState(SourceState::kStopped, error_);
}

/// True if `other_fd` is ready; false if the time is over or we are to stop.
bool IgtlSource::Receiver::Wait(int ms, int other_fd) {
  pollfd waits[] = {{.fd = wake_.fd(), .events = POLLIN, .revents = 0},
                    {.fd = other_fd, .events = POLLIN, .revents = 0}};
  const int ready = poll(waits, other_fd >= 0 ? 2 : 1, ms);
  return ready > 0 && other_fd >= 0 && waits[1].revents != 0;
}

Descriptor IgtlSource::Receiver::Connect() {
  if (!options_.listen) {
    Connection connection = ConnectTcp(options_.host, options_.port, kConnectMs, wake_);
    if (!connection.error.empty()) error_ = connection.error;
    return std::move(connection.socket);
  }
  while (!stopping_) {
    if (Wait(1000, listener_.get())) return AcceptTcp(listener_);
  }
  return {};
}

void IgtlSource::Receiver::Serve(const Descriptor& socket) {
  IgtlReader reader({.keep_images = options_.keep_images, .check_crc = options_.check_crc});
  if (options_.tdata_interval_ms >= 0) {
    Send(socket, PackStartTrackingData("Acus", options_.tdata_interval_ms));
  }
  std::int64_t last_byte_ns = MonotonicNs();
  std::int64_t began_ns = last_byte_ns;  // The message that is under way.
  std::uint64_t messages = 0;
  SetState(SourceState::kConnected, error_);
  const std::string peer = PeerName(socket);
  for (bool is_open = true; is_open && !stopping_;) {
    const bool ready = Wait(kPollMs, socket.get());
    if (ready) {
      is_open = ReceiveSome(socket, reader);
      last_byte_ns = MonotonicNs();
    }
    const std::int64_t now_ns = MonotonicNs();
    if (!reader.in_message() || reader.counts().messages != messages) began_ns = now_ns;
    messages = reader.counts().messages;
    if (now_ns - began_ns > options_.message_ms * kNsPerMs) {
      error_ = Message(peer, " did not finish a message within ", options_.message_ms, " ms");
      is_open = false;
    } else if (reader.skipped_in_a_row() > kMaxRubbishBytes) {
      error_ = Message(peer, " sent ", reader.skipped_in_a_row(),
                       " bytes that are no OpenIGTLink message");
      is_open = false;
    } else if (now_ns - last_byte_ns > options_.silence_ms * kNsPerMs) {
      error_ = Message(peer, " was silent for ", options_.silence_ms, " ms");
      is_open = false;
    }
    tools_.PublishSilent(now_ns);
    PublishStatus(reader);
  }
  tools_.LinkLost(MonotonicNs());
  PublishStatus(reader);
  before_.messages += reader.counts().messages;
  before_.other_messages += reader.counts().other_messages;
  before_.bad_messages += reader.counts().bad_messages;
  before_.skipped_bytes += reader.counts().skipped_bytes;
}

/// False if the link is lost.
bool IgtlSource::Receiver::ReceiveSome(const Descriptor& socket, IgtlReader& reader) {
  const Transfer transfer = Receive(socket, chunk_);
  const std::int64_t arrival_ns = MonotonicNs();
  if (transfer.state == TransferState::kClosed) {
    error_ = Message(options_.name, ": the peer closed the link",
                     transfer.error.empty() ? "" : ": ", transfer.error);
    return false;
  }
  reader.Append(ByteView(chunk_).first(transfer.bytes));
  while (const auto message = reader.Next()) Handle(*message, arrival_ns);
  return true;
}

void IgtlSource::Receiver::Handle(const IgtlMessage& message, std::int64_t arrival_ns) {
  const IgtlHeader& header = message.header;
  const ByteView content = message.body.content;
  const MessageTimes times{.source_ns = header.time_ns, .arrival_ns = arrival_ns};
  last_news_ns_ = arrival_ns;
  bool is_readable = true;
  if (header.type == "TRANSFORM" || header.type == "POSITION") {
    const auto matrix = header.type == "POSITION" ? ReadPosition(content) : ReadTransform(content);
    is_readable = matrix.has_value();
    if (matrix) tools_.Take(header.device, *matrix, SaysValid(message.body.metadata), times);
  } else if (header.type == "TDATA" || header.type == "QTDATA") {
    const auto tools =
        header.type == "TDATA" ? ReadTrackingData(content) : ReadQuaternionTrackingData(content);
    is_readable = tools.has_value();
    if (tools) tools_.TakeAll(header.device, *tools, times);
  } else if (header.type == "STATUS") {
    const auto text = ReadStatus(content);
    is_readable = text.has_value();
    if (text) peer_status_ = *text;
  } else if (header.type == "IMAGE") {
    KeepImage(message, arrival_ns);
  } else if (header.type == "RTS_TDATA") {
    if (!content.empty() && content[0] != 0) error_ = "the peer has no TDATA to send";
  } else {
    ++unexpected_;
  }
  if (!is_readable) ++unreadable_;
}

void IgtlSource::Receiver::KeepImage(const IgtlMessage& message, std::int64_t arrival_ns) {
  auto image = ReadImage(message.body.content);
  if (!image) {
    ++unexpected_;  // A volume, or more than 8 bits: right, but not for us.
    return;
  }
  const std::lock_guard lock(mutex_);
  const auto last = images_.find(message.header.device);
  if (last == images_.end() && images_.size() >= kMaxImageStreams) {
    ++unexpected_;
    return;
  }
  const std::uint64_t number = last == images_.end() ? 1 : last->second->number + 1;
  const auto kept =
      std::make_shared<const ReceivedImage>(ReceivedImage{.time_ns = arrival_ns,
                                                          .source_time_ns = message.header.time_ns,
                                                          .number = number,
                                                          .image = std::move(*image)});
  images_[message.header.device] = kept;
  images_[""] = kept;
}

void IgtlSource::Receiver::SetState(SourceState state, const std::string& error) {
  const std::lock_guard lock(mutex_);
  status_.state = state;
  status_.last_error = error;
  status_.counts.connects = connects_;
}

void IgtlSource::Receiver::PublishStatus(const IgtlReader& reader) {
  const std::lock_guard lock(mutex_);
  SourceCounts& counts = status_.counts;
  counts = tools_.counts();
  counts.messages = before_.messages + reader.counts().messages;
  counts.other_messages = before_.other_messages + reader.counts().other_messages + unexpected_;
  counts.bad_messages = before_.bad_messages + reader.counts().bad_messages + unreadable_;
  counts.skipped_bytes = before_.skipped_bytes + reader.counts().skipped_bytes;
  counts.connects = connects_;
  counts.lost_from_journal = board_.lost_from_journal();
  status_.last_error = error_;
  status_.peer_status = peer_status_;
  status_.last_news_ns = last_news_ns_;
  status_.clock = tools_.clock();
  status_.why_not_seen = WhyNotSeen(reader);
  if (status_.other_names.size() != tools_.other_names().size()) {
    status_.other_names = tools_.other_names();
  }
}

/// What the messages state, for each tool that is not seen.
std::vector<std::string> IgtlSource::Receiver::WhyNotSeen(const IgtlReader& reader) const {
  std::vector<std::string> why = tools_.WhyNotSeen();
  std::string more;
  if (reader.counts().bad_checksums > 0) {
    more += Message("; ", reader.counts().bad_checksums, " messages have a wrong checksum, named ",
                    Joined(reader.refused_names()),
                    " (check_crc: false of the tracker accepts a sender that does not set it)");
  }
  const auto& others = tools_.other_names();
  if (!others.empty()) more += "; names received: " + Joined(others);
  const IgtlReader::Counts& counts = reader.counts();
  if (others.empty() && more.empty() && counts.messages > 0) {
    more = Message("; ", counts.messages, " messages came, of kinds that carry no pose");
  } else if (others.empty() && more.empty() && counts.skipped_bytes > 0) {
    more = Message("; ", counts.skipped_bytes,
                   " bytes came that are no OpenIGTLink messages of versions 1 to 3");
  }
  for (std::string& text : why) {
    if (!text.empty()) text += more;
  }
  return why;
}

IgtlSource::IgtlSource(IgtlOptions options)
    : receiver_(std::make_unique<Receiver>(std::move(options))) {}

IgtlSource::~IgtlSource() {
  receiver_->Stop();
}

std::string IgtlSource::name() const {
  return receiver_->options().name;
}

void IgtlSource::Start() {
  receiver_->Start();
}

void IgtlSource::Stop() noexcept {
  receiver_->Stop();
}

PoseBoard& IgtlSource::board() noexcept {
  return receiver_->board();
}

SourceStatus IgtlSource::status() const {
  return receiver_->status();
}

int IgtlSource::port() const {
  return receiver_->port();
}

std::shared_ptr<const ReceivedImage> IgtlSource::Image(const std::string& device) const {
  return receiver_->Image(device);
}

}  // namespace acus::tracking
