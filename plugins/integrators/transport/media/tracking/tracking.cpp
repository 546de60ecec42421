#include "transport/media/tracking/tracking.h"

#include <cmath>

namespace kinome::transport {

namespace {

/// Transmittances below this one are estimated with Russian roulette.
constexpr float kSmallTransmittance = 0.02f;

}  // namespace

Tracking::Tracking(const MediaTable& media, size_t rays)
    : media_(media),
      walks_(media.size()),
      arena_(media.has_grids() ? rays : kBlockLanes),
      p_(arena_.three()),
      d_(arena_.three()),
      extinction_(arena_.three()),
      scattering_(arena_.three()) {}

void Tracking::add(uint32_t medium, const kinome::Vec3& o, const kinome::Vec3& d, float length,
                   uint64_t random, uint32_t index) {
  walks_[medium].push_back(Walk{BlockWalk(*media_.grid(medium), o, d, length, random), index});
  ++count_;
}

/// Evaluates the medium at the ends of the walks.
void Tracking::evaluate(const Medium& medium, const std::vector<Walk>& walks) {
  for (size_t i = 0; i < walks.size(); ++i) {
    p_.set(i, walks[i].along.p());
    d_.set(i, walks[i].along.d());
  }
  medium.coefficients_block(p_, d_, walks.size(), {extinction_, scattering_});
}

const std::vector<Tracking::Collision>& Tracking::find_collisions(const Columns3& throughput,
                                                                  float* optical_depth) {
  collisions_.clear();
  for (uint32_t m = 1; m < walks_.size(); ++m) {
    std::vector<Walk>& walks = walks_[m];
    while (!walks.empty()) {
      size_t n = 0;
      for (Walk& walk : walks) {
        const auto rate = [](float /*lo*/, float hi) { return hi; };
        const auto passes = [&](float /*lo*/, float hi, float /*length*/) { walk.majorant = hi; };
        if (walk.along.advance(*media_.grid(m), optical_depth[walk.index], rate, passes)) {
          walks[n++] = walk;
        }
      }
      walks.erase(walks.begin() + static_cast<std::ptrdiff_t>(n), walks.end());
      evaluate(*media_.medium(m), walks);
      size_t left = 0;
      for (size_t i = 0; i < n; ++i) {
        Walk& walk = walks[i];
        optical_depth[walk.index] = walk.along.optical_depth();
        if (is_real(walk, i, throughput)) {
          collisions_.push_back({walk.index, walk.along.t()});
        } else {
          walks[left++] = walk;
        }
      }
      walks.erase(walks.begin() + static_cast<std::ptrdiff_t>(left), walks.end());
    }
  }
  count_ = 0;
  return collisions_;
}

/// Decides whether a tentative collision is real, and updates the throughput.
bool Tracking::is_real(Walk& walk, size_t i, const Columns3& throughput) {
  const kinome::Rgb carried = throughput.at(walk.index);
  const kinome::Rgb extinction = glm::min(extinction_.at(i), kinome::Rgb(walk.majorant));
  const float sum = carried.x + carried.y + carried.z;
  const float real = glm::dot(carried, extinction);
  const bool is_chosen = walk.along.random() * walk.majorant * sum < real;
  if (is_chosen) {
    throughput.set(walk.index, carried * scattering_.at(i) * (sum / real));
  } else {
    const kinome::Rgb rest = kinome::Rgb(walk.majorant) - extinction;
    throughput.set(walk.index, carried * rest * (sum / glm::dot(carried, rest)));
  }
  return is_chosen;
}

void Tracking::find_transmittances(const Columns3& transmittance) {
  for (uint32_t m = 1; m < walks_.size(); ++m) {
    std::vector<Walk>& walks = walks_[m];
    for (Walk& walk : walks) walk.left = walk.along.optical_depth();
    while (!walks.empty()) {
      size_t n = 0;
      for (Walk& walk : walks) {
        const auto rate = [](float lo, float hi) { return hi - lo; };
        const auto passes = [&](float lo, float hi, float length) {
          walk.majorant = hi, walk.minorant = lo;
          walk.passed += lo * length;
        };
        if (walk.along.advance(*media_.grid(m), walk.left, rate, passes)) {
          walks[n++] = walk;
          continue;
        }
        transmittance.set(
            walk.index, transmittance.at(walk.index) * walk.transmittance * std::exp(-walk.passed));
      }
      walks.erase(walks.begin() + static_cast<std::ptrdiff_t>(n), walks.end());
      evaluate(*media_.medium(m), walks);
      size_t left = 0;
      for (size_t i = 0; i < n; ++i) {
        if (attenuate(walks[i], extinction_.at(i))) {
          walks[left++] = walks[i];
        } else {
          transmittance.set(walks[i].index, kinome::Rgb(0.f));
        }
      }
      walks.erase(walks.begin() + static_cast<std::ptrdiff_t>(left), walks.end());
    }
  }
  count_ = 0;
}

/// Multiplies the transmittance at a tentative collision. Returns false if it becomes 0.
bool Tracking::attenuate(Walk& walk, const kinome::Rgb& extinction) {
  const kinome::Rgb rest = glm::max(kinome::Rgb(walk.majorant) - extinction, kinome::Rgb(0.f));
  walk.transmittance *= rest / (walk.majorant - walk.minorant);
  walk.left = walk.along.optical_depth();
  const float left = max_component(walk.transmittance) * std::exp(-walk.passed);
  if (left >= kSmallTransmittance) return true;
  const float survival = left / kSmallTransmittance;
  if (!(walk.along.random() < survival)) return false;
  walk.transmittance /= survival;
  return true;
}

}  // namespace kinome::transport
