// SPDX-License-Identifier: Apache-2.0
#include "base/hash.hpp"

#define XXH_INLINE_ALL
#include <xxhash.h>

#include <cstdio>

namespace gnosphere {
namespace {

std::string hexOf(const XXH128_hash_t& hash) {
  char text[33];
  std::snprintf(text, sizeof(text), "%016llx%016llx", static_cast<unsigned long long>(hash.high64),
                static_cast<unsigned long long>(hash.low64));
  return text;
}

}  // namespace

struct Hasher::State {
  XXH3_state_t xxh;
};

Hasher::Hasher() : state_(std::make_unique<State>()) {
  XXH3_128bits_reset(&state_->xxh);
}
Hasher::~Hasher() = default;

void Hasher::add(const void* bytes, size_t count) {
  if (count > 0) XXH3_128bits_update(&state_->xxh, bytes, count);
}

void Hasher::add(std::string_view text) {
  const size_t count = text.size();
  add(&count, sizeof(count));
  add(text.data(), count);
}

std::string Hasher::hex() const {
  return hexOf(XXH3_128bits_digest(&state_->xxh));
}

std::string hashOf(std::string_view bytes) {
  return hexOf(XXH3_128bits(bytes.data(), bytes.size()));
}

}  // namespace gnosphere
