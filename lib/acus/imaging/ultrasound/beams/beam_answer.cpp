// What interfaces and the needle send back: the part of BeamTracer that meets few samples.
#include <algorithm>
#include <cmath>

#include "acus/imaging/ultrasound/beams/beam_tracer.h"

namespace acus::ultrasound {
namespace {

constexpr double kFaintest = 1e-4;
/// An oblique surface lies in the pulse for a part of the beam's width only. Its echo is raised by
/// this at most: beyond, it is no mirror.
constexpr double kMostOblique = 6.0;

std::size_t At(int n) {
  return static_cast<std::size_t>(n);
}

}  // namespace

void BeamTracer::AnswerInterfaces(Pass& pass, int k) {
  for (int l = 0; l < pass.lanes; ++l) {
    if (pass.work.run[l] != 0.0F) AnswerInterface(pass, k, l);
  }
}

BeamTracer::Crossing BeamTracer::CrossingAt(const Pass& pass, int k, int lane) const {
  const Work& work = pass.work;
  Crossing at{};
  at.k = k;
  at.lane = lane;
  at.place = std::clamp<double>(work.place[lane], std::max(0, k - kRing + 2), k - 1);
  const slicing::kernels::Lines& lines = pass.voxels;
  const int other = lane + 1 < pass.lanes ? lane + 1 : lane - 1;
  const auto s = static_cast<float>(pass.s + (at.place - k));
  for (int a = 0; a < 3; ++a) {
    at.step[a] = lines.step[a][lane];
    at.index[a] = lines.start[a][lane] + s * lines.step[a][lane];
    at.across[a] = lines.start[a][other] + s * lines.step[a][other] - at.index[a];
  }
  const auto side = [&](int n, float& value, double& speed) {
    const int label = tissue_.labels != nullptr ? work.label[n % kRing][lane] : 0;
    value = static_cast<float>(label);
    speed = materials_.SpeedAtLabel(label);
    if (tissue_.ct == nullptr || label != 0) return;
    const float hu = work.value[n % kRing][lane];
    if (tissue_.labels == nullptr) value = hu;
    speed = materials_.SpeedAtHu(hu);
  };
  // A CT blurs an interface over some samples, labels do not.
  const int before = static_cast<int>(at.place) - (tissue_.labels != nullptr ? 0 : 1);
  side(std::max({0, k - kRing + 1, before}), at.first, at.first_speed);
  side(k - 1, at.second, at.second_speed);
  return at;
}

InterfaceEcho BeamTracer::EchoOf(double change, Crossing& at) const {
  InterfaceEcho answer;
  answer.reflection = std::tanh(change);
  double towards_probe = 1.0;
  if (options_.angle) {
    at.place += normals_.SamplesToSurface(at.index, at.step, at.first, at.second);
    const SurfaceNormals::Angles angles =
        normals_.AnglesTo(at.index, at.step, at.across, at.first, at.second);
    answer.reflection = FresnelReflection(std::exp(2.0 * change), at.second_speed / at.first_speed,
                                          angles.cos_incidence);
    const double oblique = filter_.AcrossOverAlong(at.k) * angles.tan_in_plane;
    towards_probe = MirrorLobe(angles.cos_incidence, options_.lobe_deg, options_.diffuse_share) *
                    std::min(kMostOblique, std::sqrt(1.0 + oblique * oblique));
  }
  answer.echo = answer.reflection * towards_probe;
  answer.transmission = 1.0 - answer.reflection * answer.reflection;
  const bool strong = std::abs(answer.reflection) >= options_.strong_reflection;
  if (strong && options_.shadow) answer.transmission *= strong_transmission_;
  return answer;
}

void BeamTracer::AnswerInterface(Pass& pass, int k, int lane) {
  Work& work = pass.work;
  Crossing at = CrossingAt(pass, k, lane);
  const int above = static_cast<int>(at.place);
  const auto energy = [&](int n) -> float& { return work.energy[n % kRing][lane]; };
  const double arriving = energy(above) + (at.place - above) * (energy(above + 1) - energy(above));
  if (arriving < kFaintest) return;
  const InterfaceEcho answer = EchoOf(work.run[lane], at);

  const auto left = static_cast<float>(answer.transmission);
  for (int n = above + 1; n <= k + 1; ++n) {
    energy(n) *= left;
    if (n > k || pass.add) continue;
    pass.out.re.row(n)[pass.first + lane] *= left;
    pass.out.im.row(n)[pass.first + lane] *= left;
  }
  if (options_.refraction) {
    const Eigen::Vector3d normal = normals_.At(at.index, at.first, at.second);
    if (!normal.isZero(0.0)) {
      work.march.Bend(lane, normal, spacing_mm_, at.second_speed / at.first_speed,
                      k + 1 - at.place);
    }
  }
  const double amplitude = pass.weight * arriving * answer.echo;
  AddEcho(pass, at.place, lane, amplitude);
  const bool gas = answer.reflection < -0.9 || work.previous[lane] < kAirLogImpedance;
  if (gas && options_.comet_tail) {
    RingBehind(pass, at.place, options_.gas_ring_spacing_mm / grid_.step_mm, lane, amplitude,
               options_.gas_ring_decay);
  }
  if (options_.multiple_reflections && std::abs(answer.reflection) > 0.1) {
    Reverberate(pass, at.place, lane, amplitude, answer.reflection);
  }
}

void BeamTracer::RingBehind(Pass& pass, double place, double spacing, int lane, double amplitude,
                            double decay) const {
  for (int n = 1; n <= 16; ++n) {
    amplitude *= decay;
    const double at = place + n * spacing;
    if (at >= grid_.samples || std::abs(amplitude) < kFaintest) return;
    AddEcho(pass, at, lane, amplitude);
  }
}

void BeamTracer::Reverberate(Pass& pass, double place, int lane, double amplitude,
                             double reflection) const {
  Work& work = pass.work;
  // Between the face and this interface: each round trip is reflected by both once more.
  double again = amplitude;
  for (int n = 2; n <= 6 && n * place < grid_.samples; ++n) {
    again *= -options_.face_reflection * amplitude / pass.weight;
    if (std::abs(again) < kFaintest) break;
    AddEcho(pass, n * place, lane, again);
  }
  // Between an earlier interface and this one.
  for (int s = 0; s < work.strong_count[lane]; ++s) {
    const Strong& earlier = work.strong[lane][s];
    RingBehind(pass, place, place - earlier.place, lane, amplitude,
               -earlier.reflection * reflection);
  }
  if (work.strong_count[lane] < kStrongest) {
    work.strong[lane][work.strong_count[lane]++] = {static_cast<float>(place),
                                                    static_cast<float>(reflection)};
  }
}

void BeamTracer::AnswerNeedle(Pass& pass, int k) {
  if (!marched_) {
    for (; pass.mark != pass.last_mark && pass.mark->sample <= k; ++pass.mark) {
      AnswerMark(pass, k, *pass.mark);
    }
    return;
  }
  // Each line passes the shaft at its own time.
  for (const NeedleMark* mark = pass.mark; mark != pass.last_mark; ++mark) {
    if (pass.work.march.Passed(mark->line - pass.first, static_cast<float>(mark->sample))) {
      AnswerMark(pass, k, *mark);
    }
  }
}

void BeamTracer::AnswerMark(Pass& pass, int k, const NeedleMark& mark) const {
  const int lane = mark.line - pass.first;
  float& after = pass.work.energy[(k + 1) % kRing][lane];
  const double amplitude = pass.weight * pass.work.energy[k % kRing][lane] * mark.echo;
  after *= mark.transmission;
  if (std::abs(amplitude) < kFaintest) return;
  const double place = k + double{mark.beside};
  AddEcho(pass, place, lane, amplitude);
  if (options_.comet_tail) {
    RingBehind(pass, place, pass.ring_samples, lane, amplitude, options_.needle_ring_decay);
  }
}

void BeamTracer::AddEcho(Pass& pass, double place, int lane, double amplitude) const {
  std::vector<Echo>& echoes = pass.work.echoes;
  if (echoes.size() + 2 > echoes.capacity()) return;
  const int nearest = static_cast<int>(std::lround(place));
  const BeamFilter::Shares shares = filter_.SharesAt(place - nearest);
  echoes.push_back({nearest, lane, static_cast<float>(amplitude * shares.nearest)});
  if (shares.neighbour < 1e-3) return;
  const int neighbour = place > nearest ? nearest + 1 : nearest - 1;
  echoes.push_back({neighbour, lane, static_cast<float>(amplitude * shares.neighbour)});
}

void BeamTracer::PutEchoes(Pass& pass) const {
  const std::vector<float>& spread = filter_.Spread();
  const int half = static_cast<int>(spread.size()) - 1;
  for (const Echo& echo : pass.work.echoes) {
    const int low = std::max(0, echo.sample - half);
    const int high = std::min(grid_.samples - 1, echo.sample + half);
    for (int k = low; k <= high; ++k) {
      pass.out.re.row(k)[pass.first + echo.lane] +=
          echo.amplitude * spread[At(std::abs(k - echo.sample))];
    }
  }
}

}  // namespace acus::ultrasound
