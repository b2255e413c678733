#include "compare/random_machines/random.h"

#include <bit>
#include <cmath>

namespace concord::compare::fuzz {

namespace {

/// The next number of splitmix64.
std::uint64_t next_seed(std::uint64_t& state) {
  state += 0x9e3779b97f4a7c15ULL;
  std::uint64_t z = state;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  return z ^ (z >> 31);
}

}  // namespace

Random::Random(std::uint64_t seed, std::uint64_t stream) {
  std::uint64_t state = seed;
  state = next_seed(state) ^ stream;
  for (std::uint64_t& word : state_) word = next_seed(state);
}

std::uint64_t Random::bits() {
  const std::uint64_t result = std::rotl(state_[1] * 5, 7) * 9;
  const std::uint64_t shifted = state_[1] << 17;
  state_[2] ^= state_[0];
  state_[3] ^= state_[1];
  state_[1] ^= state_[2];
  state_[0] ^= state_[3];
  state_[2] ^= shifted;
  state_[3] = std::rotl(state_[3], 45);
  return result;
}

double Random::uniform() { return static_cast<double>(bits() >> 11) * 0x1p-53; }

double Random::between(double least, double greatest) { return least + (greatest - least) * uniform(); }

double Random::log_between(double least, double greatest) {
  return least * std::exp(std::log(greatest / least) * uniform());
}

int Random::below(int count) { return static_cast<int>(uniform() * count); }

bool Random::chance(double probability) { return uniform() < probability; }

Vec3 Random::vector(double size) {
  const double x = between(-size, size);
  const double y = between(-size, size);
  const double z = between(-size, size);
  return {x, y, z};
}

VecX Random::vector(Eigen::Index n, double size) {
  VecX v(n);
  for (double& entry : v) entry = between(-size, size);
  return v;
}

Vec4 Random::rotation() {
  Vec4 p;
  do {
    for (double& entry : p) entry = between(-1.0, 1.0);
  } while (p.norm() > 1.0 || p.norm() < 0.1);
  p.normalize();
  return p(0) < 0.0 ? Vec4(-p) : p;
}

}  // namespace concord::compare::fuzz
