#include "acus/rig/tracking/simulators/tool_motion.h"

#include <algorithm>
#include <cmath>

#include "acus/base/core/error.h"

namespace acus::simulators {
namespace {

using tracking::NamedPose;

std::int64_t End(const session::Session& session) {
  std::int64_t end_ns = INT64_MIN;
  for (const session::PoseStream* stream : {&session.needle, &session.probe}) {
    if (!stream->empty()) end_ns = std::max(end_ns, stream->back().time_ns);
  }
  return end_ns - session.start_ns();
}

void RequireTools(const session::Session& session) {
  ACUS_REQUIRE(!session.needle.empty() || !session.probe.empty(), "session '", session.name,
               "': it has neither a needle nor a probe to play");
}

class Recorded final : public ToolMotion {
 public:
  Recorded(session::Session session, const ToolNames& names)
      : session_(std::move(session)), names_(names) {
    RequireTools(session_);
    start_ns_ = session_.start_ns();
    end_ns_ = End(session_);
  }

  std::optional<std::int64_t> end_ns() const override { return end_ns_; }

  std::optional<std::int64_t> Next(std::int64_t time_ns) const override {
    std::optional<std::int64_t> next;
    for (const session::PoseStream* stream : {&session_.needle, &session_.probe}) {
      const auto at = std::upper_bound(
          stream->begin(), stream->end(), start_ns_ + time_ns,
          [](std::int64_t t, const session::PoseSample& sample) { return t < sample.time_ns; });
      if (at == stream->end()) continue;
      next = std::min(next.value_or(INT64_MAX), at->time_ns - start_ns_);
    }
    return next;
  }

  std::vector<NamedPose> At(std::int64_t time_ns) const override {
    std::vector<NamedPose> poses;
    Add(session_.needle, names_.needle, time_ns, poses);
    Add(session_.probe, names_.probe, time_ns, poses);
    return poses;
  }

 private:
  void Add(const session::PoseStream& stream, const std::string& name, std::int64_t time_ns,
           std::vector<NamedPose>& poses) const {
    const auto at = std::lower_bound(
        stream.begin(), stream.end(), start_ns_ + time_ns,
        [](const session::PoseSample& sample, std::int64_t t) { return sample.time_ns < t; });
    if (at == stream.end() || at->time_ns != start_ns_ + time_ns) return;
    poses.push_back(
        {.name = name, .reference_from_tool = at->reference_from_tool, .valid = at->valid});
  }

  session::Session session_;
  ToolNames names_;
  std::int64_t start_ns_ = 0, end_ns_ = 0;
};

class Resampled final : public ToolMotion {
 public:
  Resampled(session::Session session, const ToolNames& names, double rate_hz)
      : session_(std::move(session)), names_(names) {
    RequireTools(session_);
    ACUS_REQUIRE(rate_hz >= 0.1 && rate_hz <= 5000.0, "rate is ", rate_hz,
                 " Hz; allowed are 0.1 to 5000");
    start_ns_ = session_.start_ns();
    end_ns_ = End(session_);
    step_ns_ = std::llround(1e9 / rate_hz);
  }

  std::optional<std::int64_t> end_ns() const override { return end_ns_; }

  std::optional<std::int64_t> Next(std::int64_t time_ns) const override {
    const std::int64_t next = time_ns < 0 ? 0 : (time_ns / step_ns_ + 1) * step_ns_;
    if (next > end_ns_) return std::nullopt;
    return next;
  }

  std::vector<NamedPose> At(std::int64_t time_ns) const override {
    std::vector<NamedPose> poses;
    const auto add = [&](const session::PoseStream& stream, const std::string& name) {
      if (stream.empty()) return;
      const session::PoseSample sample = session::PoseAt(stream, start_ns_ + time_ns);
      poses.push_back(
          {.name = name, .reference_from_tool = sample.reference_from_tool, .valid = sample.valid});
    };
    add(session_.needle, names_.needle);
    add(session_.probe, names_.probe);
    return poses;
  }

 private:
  session::Session session_;
  ToolNames names_;
  std::int64_t start_ns_ = 0, end_ns_ = 0, step_ns_ = 1;
};

class ThereAndBack final : public ToolMotion {
 public:
  explicit ThereAndBack(std::unique_ptr<ToolMotion> motion) : motion_(std::move(motion)) {
    const auto end_ns = motion_->end_ns();
    ACUS_REQUIRE(end_ns.has_value() && *end_ns >= 1'000'000,
                 "only a motion of at least 1 ms can be played forth and back");
    end_ns_ = *end_ns;
    for (auto at = motion_->Next(-1); at; at = motion_->Next(*at)) instants_.push_back(*at);
  }

  std::optional<std::int64_t> end_ns() const override { return std::nullopt; }

  std::optional<std::int64_t> Next(std::int64_t time_ns) const override {
    for (std::int64_t half = std::max<std::int64_t>(time_ns, 0) / end_ns_;; ++half) {
      const std::int64_t begin_ns = half * end_ns_, local_ns = time_ns - begin_ns;
      if (half % 2 == 0) {
        const auto at = std::upper_bound(instants_.begin(), instants_.end(), local_ns);
        if (at != instants_.end()) return begin_ns + *at;
      } else {
        // Backwards: the last instant before end - local.
        const auto at = std::lower_bound(instants_.begin(), instants_.end(), end_ns_ - local_ns);
        if (at != instants_.begin()) return begin_ns + end_ns_ - *std::prev(at);
      }
    }
  }

  std::vector<NamedPose> At(std::int64_t time_ns) const override {
    // An instant where it turns belongs to both halves, with the same poses.
    const std::int64_t local_ns = time_ns % (2 * end_ns_);
    return motion_->At(local_ns <= end_ns_ ? local_ns : 2 * end_ns_ - local_ns);
  }

 private:
  std::unique_ptr<ToolMotion> motion_;
  std::vector<std::int64_t> instants_;
  std::int64_t end_ns_ = 0;
};

}  // namespace

std::unique_ptr<ToolMotion> RecordedMotion(session::Session session, const ToolNames& names) {
  return std::make_unique<Recorded>(std::move(session), names);
}

std::unique_ptr<ToolMotion> ResampledMotion(session::Session session, const ToolNames& names,
                                            double rate_hz) {
  return std::make_unique<Resampled>(std::move(session), names, rate_hz);
}

std::unique_ptr<ToolMotion> ForthAndBack(std::unique_ptr<ToolMotion> motion) {
  return std::make_unique<ThereAndBack>(std::move(motion));
}

}  // namespace acus::simulators
