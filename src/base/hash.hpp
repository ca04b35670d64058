// SPDX-License-Identifier: Apache-2.0
// Hashes that tell whether files, drives and kernels are equal (XXH3 of 128 bits; not against forgery).
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace gnosphere {

class Hasher {
 public:
  Hasher();
  ~Hasher();
  void add(const void* bytes, size_t count);
  void add(std::string_view text);
  template <typename T>
  void add(const std::vector<T>& values) {
    const size_t count = values.size();
    add(&count, sizeof(count));
    add(values.data(), count * sizeof(T));
  }
  std::string hex() const;  ///< 32 digits

 private:
  struct State;
  std::unique_ptr<State> state_;
};

std::string hashOf(std::string_view bytes);

}  // namespace gnosphere
