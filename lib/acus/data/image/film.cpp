#include "acus/data/image/film.h"

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/opt.h>
}

#include <algorithm>
#include <array>
#include <cmath>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <string>
#include <thread>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"

namespace acus::image {
namespace {

// One deleter per kind of libav object.
struct FreeFormat {
  void operator()(AVFormatContext* format) const {
    if (format->pb != nullptr) avio_closep(&format->pb);
    avformat_free_context(format);
  }
};
struct FreeCodec {
  void operator()(AVCodecContext* codec) const { avcodec_free_context(&codec); }
};
struct FreeFrame {
  void operator()(AVFrame* frame) const { av_frame_free(&frame); }
};
struct FreePacket {
  void operator()(AVPacket* packet) const { av_packet_free(&packet); }
};

std::string Reason(int error) {
  char text[AV_ERROR_MAX_STRING_SIZE] = {};
  av_strerror(error, text, sizeof text);
  return text;
}

int Even(int size) {
  return size + size % 2;
}

}  // namespace

struct FilmWriter::Encoder {
  Encoder(const std::filesystem::path& path, int width_px, int height_px)
      : name(path.string()), width(width_px), height(height_px), file(path) {}

  void Require(int status, const char* what) const {
    ACUS_REQUIRE(status >= 0, name, ": cannot ", what, " the video: ", Reason(status));
  }
  void OpenCodec(const FilmOptions& options);
  void OpenFile();
  void MakeFrame();
  void Drain();
  void Encode(const GrayImage& image);
  void Encode(const ColourImage& image);
  void Send();

  std::string name;
  int width;
  int height;
  int frames = 0;
  AtomicFile file;
  std::unique_ptr<AVFormatContext, FreeFormat> format;
  std::unique_ptr<AVCodecContext, FreeCodec> codec;
  std::unique_ptr<AVFrame, FreeFrame> frame;
  std::unique_ptr<AVPacket, FreePacket> packet;
  AVStream* stream = nullptr;
};

void FilmWriter::Encoder::OpenCodec(const FilmOptions& options) {
  const AVCodec* h264 = avcodec_find_encoder_by_name("libx264");
  if (h264 == nullptr) h264 = avcodec_find_encoder(AV_CODEC_ID_H264);
  ACUS_REQUIRE(h264 != nullptr, name,
               ": this system's libavcodec has no H.264 encoder; install libavcodec-extra59 or a "
               "libavcodec59 with libx264");
  codec.reset(avcodec_alloc_context3(h264));
  ACUS_ASSERT(codec != nullptr);
  codec->width = Even(width);
  codec->height = Even(height);
  codec->pix_fmt = AV_PIX_FMT_YUV420P;
  codec->color_range = AVCOL_RANGE_MPEG;
  const AVRational rate = av_d2q(options.frames_per_s, 100000);
  codec->framerate = rate;
  codec->time_base = av_inv_q(rate);
  codec->gop_size = std::max(1, static_cast<int>(std::lround(options.frames_per_s)));  // Seeking.
  codec->max_b_frames = 0;
  codec->thread_count = 1;  // The bits must not depend on the machine.
  codec->flags |= AV_CODEC_FLAG_GLOBAL_HEADER | AV_CODEC_FLAG_BITEXACT;
  // Encoding is most of the cost of a replay: the fastest preset, and a constant quantiser, which
  // needs no look ahead (a constant rate factor takes 25 % longer for the same size).
  av_opt_set(codec->priv_data, "preset", "ultrafast", 0);
  av_opt_set_int(codec->priv_data, "qp", options.quality, 0);
  Require(avcodec_open2(codec.get(), h264, nullptr), "start encoding");
}

void FilmWriter::Encoder::OpenFile() {
  AVFormatContext* made = nullptr;
  Require(avformat_alloc_output_context2(&made, nullptr, "mp4", file.path().c_str()), "set up");
  format.reset(made);
  format->flags |= AVFMT_FLAG_BITEXACT;  // No time stamps of now.
  stream = avformat_new_stream(format.get(), nullptr);
  ACUS_ASSERT(stream != nullptr);
  stream->time_base = codec->time_base;
  stream->avg_frame_rate = codec->framerate;
  Require(avcodec_parameters_from_context(stream->codecpar, codec.get()), "describe");
  Require(avio_open(&format->pb, file.path().c_str(), AVIO_FLAG_WRITE), "create");
  Require(avformat_write_header(format.get(), nullptr), "begin");
}

void FilmWriter::Encoder::MakeFrame() {
  frame.reset(av_frame_alloc());
  packet.reset(av_packet_alloc());
  ACUS_ASSERT(frame != nullptr && packet != nullptr);
  frame->format = codec->pix_fmt;
  frame->width = codec->width;
  frame->height = codec->height;
  Require(av_frame_get_buffer(frame.get(), 64), "hold an image of");
  // Grey: the colour planes never change. Black, in the range of video.
  std::fill_n(frame->data[0], frame->linesize[0] * codec->height, std::uint8_t{16});
  for (const int plane : {1, 2}) {
    std::fill_n(frame->data[plane], frame->linesize[plane] * (codec->height / 2),
                std::uint8_t{128});
  }
}

void FilmWriter::Encoder::Drain() {
  while (true) {
    const int status = avcodec_receive_packet(codec.get(), packet.get());
    if (status == AVERROR(EAGAIN) || status == AVERROR_EOF) return;
    Require(status, "encode");
    av_packet_rescale_ts(packet.get(), codec->time_base, stream->time_base);
    packet->duration = av_rescale_q(1, codec->time_base, stream->time_base);
    packet->stream_index = stream->index;
    Require(av_interleaved_write_frame(format.get(), packet.get()), "write");
  }
}

void FilmWriter::Encoder::Encode(const GrayImage& image) {
  Require(av_frame_make_writable(frame.get()), "hold an image of");
  // Copies: bytes that are written may be anything, the size of the image included.
  const int columns = image.width;
  const int rows = image.height;
  for (int r = 0; r < rows; ++r) {
    const std::uint8_t* grey = image.pixels.data() + static_cast<std::ptrdiff_t>(r) * columns;
    std::uint8_t* luma = frame->data[0] + static_cast<std::ptrdiff_t>(r) * frame->linesize[0];
    for (int c = 0; c < columns; ++c) luma[c] = VideoLuma(grey[c]);
  }
  Send();
}

void FilmWriter::Encoder::Send() {
  frame->pts = frames++;
  Require(avcodec_send_frame(codec.get(), frame.get()), "encode");
  Drain();
}

/// ITU-R BT.601 in the range of video, in whole numbers; colour from 2 x 2 pixels.
void FilmWriter::Encoder::Encode(const ColourImage& image) {
  Require(av_frame_make_writable(frame.get()), "hold an image of");
  const auto pixel = [&](int column, int row) {
    const auto at = static_cast<std::size_t>(std::min(row, image.height - 1)) *
                        static_cast<std::size_t>(image.width) +
                    static_cast<std::size_t>(std::min(column, image.width - 1));
    return image.rgb.data() + 3 * at;
  };
  for (int r = 0; r < codec->height; ++r) {
    std::uint8_t* luma = frame->data[0] + static_cast<std::ptrdiff_t>(r) * frame->linesize[0];
    for (int c = 0; c < codec->width; ++c) {
      const std::uint8_t* p = pixel(c, r);
      luma[c] = static_cast<std::uint8_t>(16 + ((66 * p[0] + 129 * p[1] + 25 * p[2] + 128) >> 8));
    }
  }
  for (int r = 0; r < codec->height / 2; ++r) {
    for (int c = 0; c < codec->width / 2; ++c) {
      int sum[3] = {0, 0, 0};
      for (int n = 0; n < 4; ++n) {
        const std::uint8_t* p = pixel(2 * c + n % 2, 2 * r + n / 2);
        for (int k = 0; k < 3; ++k) sum[k] += p[k];
      }
      const int blue = (-38 * sum[0] - 74 * sum[1] + 112 * sum[2] + 512) >> 10;
      const int red = (112 * sum[0] - 94 * sum[1] - 18 * sum[2] + 512) >> 10;
      frame->data[1][static_cast<std::ptrdiff_t>(r) * frame->linesize[1] + c] =
          static_cast<std::uint8_t>(128 + blue);
      frame->data[2][static_cast<std::ptrdiff_t>(r) * frame->linesize[2] + c] =
          static_cast<std::uint8_t>(128 + red);
    }
  }
  Send();
}

/// Encodes queued images in their order on one thread.
class FilmWriter::Worker {
 public:
  explicit Worker(Encoder& encoder) : encoder_(encoder), thread_([this] { Run(); }) {}
  ~Worker() {
    {
      const std::lock_guard lock(mutex_);
      stop_ = true;
    }
    changed_.notify_all();
    thread_.join();
  }

  void Add(const GrayImage& image) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return end_ - begin_ < kSlots || error_; });
    if (error_) std::rethrow_exception(error_);
    GrayImage& slot = slots_[end_ % kSlots];
    lock.unlock();  // The slot is free: only this thread writes it until end_ moves on.
    slot = image;
    lock.lock();
    ++end_;
    lock.unlock();
    changed_.notify_all();
  }

  /// Waits until all images are encoded.
  void Wait() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return begin_ == end_ || error_; });
    if (error_) std::rethrow_exception(error_);
  }

 private:
  static constexpr std::size_t kSlots = 8;

  void Run() {
    std::unique_lock lock(mutex_);
    while (true) {
      changed_.wait(lock, [this] { return begin_ != end_ || stop_; });
      if (stop_) return;
      const GrayImage& slot = slots_[begin_ % kSlots];
      lock.unlock();
      std::exception_ptr error;
      try {
        encoder_.Encode(slot);
      } catch (const std::exception&) {
        error = std::current_exception();  // No exception leaves a thread: Add and Wait throw it.
      }
      lock.lock();
      ++begin_;
      if (error) error_ = error;
      changed_.notify_all();
      if (error) return;
    }
  }

  Encoder& encoder_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::array<GrayImage, kSlots> slots_;
  std::size_t begin_ = 0;  ///< Images encoded so far.
  std::size_t end_ = 0;    ///< Images added so far.
  bool stop_ = false;
  std::exception_ptr error_;
  std::thread thread_;  ///< Last: starts when all else is there.
};

FilmWriter::FilmWriter(const std::filesystem::path& path, int width_px, int height_px,
                       const FilmOptions& options) {
  constexpr int kMinPx = 16;
  constexpr int kMaxPx = 8192;
  ACUS_REQUIRE(
      width_px >= kMinPx && width_px <= kMaxPx && height_px >= kMinPx && height_px <= kMaxPx,
      path.string(), ": a video of ", width_px, " x ", height_px, " pixels; allowed is ", kMinPx,
      " to ", kMaxPx, " each way");
  ACUS_REQUIRE(options.frames_per_s >= 1.0 && options.frames_per_s <= 240.0, path.string(), ": ",
               options.frames_per_s, " frames per second; allowed is 1 to 240");
  ACUS_REQUIRE(options.quality >= 0 && options.quality <= 51, path.string(), ": video quality ",
               options.quality, "; allowed is 0 (lossless) to 51");
  av_log_set_level(AV_LOG_ERROR);
  encoder_ = std::make_unique<Encoder>(path, width_px, height_px);
  encoder_->OpenCodec(options);
  encoder_->OpenFile();
  encoder_->MakeFrame();
  if (options.background) worker_ = std::make_unique<Worker>(*encoder_);
}

FilmWriter::~FilmWriter() = default;

void FilmWriter::Add(const GrayImage& image) {
  ACUS_REQUIRE(image.width == encoder_->width && image.height == encoder_->height, encoder_->name,
               ": image ", num_frames_, " is ", image.width, " x ", image.height,
               " pixels, but the video is ", encoder_->width, " x ", encoder_->height);
  if (worker_ != nullptr) {
    worker_->Add(image);
  } else {
    encoder_->Encode(image);
  }
  ++num_frames_;
}

void FilmWriter::Add(const ColourImage& image) {
  ACUS_REQUIRE(image.width == encoder_->width && image.height == encoder_->height, encoder_->name,
               ": image ", num_frames_, " is ", image.width, " x ", image.height,
               " pixels, but the video is ", encoder_->width, " x ", encoder_->height);
  if (worker_ != nullptr) worker_->Wait();
  encoder_->Encode(image);
  ++num_frames_;
}

void FilmWriter::Finish() {
  if (worker_ != nullptr) worker_->Wait();
  Encoder& e = *encoder_;
  ACUS_REQUIRE(e.frames > 0, e.name, ": a video needs at least one image");
  e.Require(avcodec_send_frame(e.codec.get(), nullptr), "end");
  e.Drain();
  e.Require(av_write_trailer(e.format.get()), "end");
  e.Require(avio_closep(&e.format->pb), "close");
  e.file.Commit();
}

}  // namespace acus::image
