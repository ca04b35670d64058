// SPDX-License-Identifier: Apache-2.0
#include "lanes/accesses.hpp"

#include <sys/mman.h>

#include <algorithm>
#include <cstring>
#include <deque>
#include <new>
#include <string>

#include "lanes/lanes.hpp"
#include "lanes/schedule.hpp"

namespace gnosphere::lanes {
namespace {

constexpr uint64_t kRegionBytes = uint64_t{16} << 30;
constexpr uint64_t kAlignment = 256;

struct Touch {
  uint64_t dispatch = 0;  // 0: none
  Moment moment;
};

/// Record of the accesses to four bytes: the last write, whether it was atomic, and the last plain reads of two lanes.
struct Word {
  Touch written, read[2];
  bool atomically = false;
};

std::byte* reserve(uint64_t bytes) {
  void* memory = mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (memory == MAP_FAILED) throw std::bad_alloc();
  return static_cast<std::byte*>(memory);
}

struct Block {
  std::string name;
  uint64_t first = 0, bytes = 0;
  bool released = false, mayReadPlainly = false;  // see plainReadsBesideAtomics()
};

/// The memory that is watched. Addresses are not used twice, so that an access to freed memory is found.
struct Region {
  std::byte* first = reserve(kRegionBytes);
  Word* words = reinterpret_cast<Word*>(reserve(kRegionBytes / 4 * sizeof(Word)));
  uint32_t* numbers = reinterpret_cast<uint32_t*>(reserve(kRegionBytes / kAlignment * sizeof(uint32_t)));
  uint64_t used = 0;
  std::deque<Block> blocks;  // by number; `numbers` has one for each kAlignment bytes
};

Region& region() {
  static Region* memory = new Region;  // lives as long as the process, like the addresses in it
  return *memory;
}

const std::byte* firstByte = nullptr;  // of the region, once it exists: most accesses are to other memory

uint64_t placeOf(const void* address) {
  return static_cast<uint64_t>(static_cast<const std::byte*>(address) - firstByte);
}

Block& blockAt(uint64_t place) {
  return region().blocks[region().numbers[place / kAlignment]];
}

/// Gives the whole pages of a range back to the system.
void giveBack(std::byte* first, uint64_t bytes) {
  constexpr uint64_t kPage = 4096;
  const uint64_t ahead = (kPage - reinterpret_cast<uintptr_t>(first) % kPage) % kPage;
  if (bytes >= ahead + kPage) madvise(first + ahead, (bytes - ahead) / kPage * kPage, MADV_DONTNEED);
}

std::string laneText(const Moment& moment) {
  return "lane " + std::to_string(moment.invocation % kWorkgroupSize) + " of workgroup " +
         std::to_string(moment.invocation / kWorkgroupSize);
}

/// True if the access of a lane is ordered before the one that the current lane is about to make.
bool isBefore(const Touch& touch, const Moment& moment) {
  if (touch.dispatch != dispatchNumber() || touch.moment.invocation == moment.invocation) return true;
  const uint32_t size = order().subgroupSize;
  if (touch.moment.invocation / kWorkgroupSize == moment.invocation / kWorkgroupSize &&
      touch.moment.workgroupBarriers < moment.workgroupBarriers)
    return true;
  return touch.moment.invocation / size == moment.invocation / size &&
         touch.moment.subgroupBarriers < moment.subgroupBarriers;
}

[[noreturn]] void race(uint64_t place, const char* own, const Moment& moment, const char* other, const Touch& touch) {
  fail(std::string(kernelName()) + ": " + laneText(touch.moment) + " " + other + " and " + laneText(moment) + " " +
       own + " byte " + std::to_string(place - blockAt(place).first) + " of " + blockAt(place).name +
       ", and nothing orders the two");
}

void touchWord(uint64_t place, Access access, const Moment& moment, bool mayReadPlainly) {
  Word& word = region().words[place / 4];
  const bool atomic = access == Access::atomic;
  const char* own = access == Access::read ? "reads" : atomic ? "changes atomically" : "writes";
  if (!(atomic && word.atomically) && !isBefore(word.written, moment)) {
    const bool apart = access == Access::read && word.atomically;
    if (!apart || !mayReadPlainly)
      race(place, own, moment, word.atomically ? "has changed atomically" : "has written", word.written);
  }
  if (access == Access::read) {
    const size_t k =
        word.read[0].dispatch != dispatchNumber() || word.read[0].moment.invocation == moment.invocation ? 0 : 1;
    word.read[k] = {dispatchNumber(), moment};
    return;
  }
  for (const Touch& read : word.read)
    if (!isBefore(read, moment) && !(atomic && mayReadPlainly)) race(place, own, moment, "has read", read);
  word.written = {dispatchNumber(), moment};
  word.atomically = atomic;
}

}  // namespace

std::byte* allocate(const char* name, uint64_t bytes) {
  Region& memory = region();
  firstByte = memory.first;
  const uint64_t first = memory.used;
  memory.used += (bytes + kAlignment) / kAlignment * kAlignment;  // at least one byte more, which no one may read
  if (memory.used > kRegionBytes) throw std::bad_alloc();
  const auto number = static_cast<uint32_t>(memory.blocks.size());
  for (uint64_t place = first; place < memory.used; place += kAlignment) memory.numbers[place / kAlignment] = number;
  const auto allowed = plainReadsBesideAtomics();
  memory.blocks.push_back({name, first, bytes, false,
                           std::any_of(allowed.begin(), allowed.end(),
                                       [&](const PlainRead& row) { return std::strcmp(row.array, name) == 0; })});
  return memory.first + first;
}

void release(void* address) {
  if (!address) return;
  Block& block = blockAt(placeOf(address));
  block.released = true;
  giveBack(region().first + block.first, block.bytes);
  giveBack(reinterpret_cast<std::byte*>(region().words + block.first / 4), block.bytes / 4 * sizeof(Word));
}

void touch(const void* address, size_t bytes, Access access) {
  const uint64_t place = placeOf(address);
  if (place >= kRegionBytes || !firstByte || !current) return;
  const Block& block = blockAt(place);
  const Moment moment = now();
  if (place + bytes > block.first + block.bytes || block.released)
    fail(std::string(kernelName()) + ": " + laneText(moment) + (access == Access::read ? " reads" : " writes") +
         " byte " + std::to_string(place - block.first) + " of " + block.name +
         (block.released ? ", which is released" : ", which has " + std::to_string(block.bytes)));
  for (uint64_t at = place / 4 * 4; at < place + bytes; at += 4) touchWord(at, access, moment, block.mayReadPlainly);
  interrupt();
}

std::span<const PlainRead> plainReadsBesideAtomics() {
  static constexpr PlainRead kRows[] = {
      {"words", "a word never grows: an old one only makes a lane offer a hit that loses"},
      {"covers", "a range never shrinks, and who has seen all bits of the sub-rays also sees their ranges"},
      {"staleEntries", "an entry changes from 0 to 1 only: a lane that reads an old 0 sets it once more"},
  };
  return kRows;
}

}  // namespace gnosphere::lanes

namespace gnosphere::cuda {
namespace {

template <typename T, typename Change>
T atomically(T& memory, Change change) {
  lanes::touch(&memory, sizeof memory, lanes::Access::atomic);
  return std::exchange(memory, change(memory));
}

}  // namespace

uint atomicAdd(uint& memory, uint value) {
  return atomically(memory, [&](uint old) { return old + value; });
}
uint atomicExchange(uint& memory, uint value) {
  return atomically(memory, [&](uint) { return value; });
}
uint atomicOr(uint& memory, uint value) {
  return atomically(memory, [&](uint old) { return old | value; });
}
uint atomicMin(uint& memory, uint value) {
  return atomically(memory, [&](uint old) { return std::min(old, value); });
}
uint atomicMax(uint& memory, uint value) {
  return atomically(memory, [&](uint old) { return std::max(old, value); });
}
uint64_t atomicMin(uint64_t& memory, uint64_t value) {
  return atomically(memory, [&](uint64_t old) { return std::min(old, value); });
}

}  // namespace gnosphere::cuda

// The functions that -fsanitize=thread calls. A load or store is checked before it happens.
extern "C" {
#define GNO_ACCESSES(bytes_)                                                   \
  void __tsan_read##bytes_(void* address) {                                    \
    gnosphere::lanes::touch(address, bytes_, gnosphere::lanes::Access::read);  \
  }                                                                            \
  void __tsan_write##bytes_(void* address) {                                   \
    gnosphere::lanes::touch(address, bytes_, gnosphere::lanes::Access::write); \
  }                                                                            \
  void __tsan_unaligned_read##bytes_(void* address) {                          \
    gnosphere::lanes::touch(address, bytes_, gnosphere::lanes::Access::read);  \
  }                                                                            \
  void __tsan_unaligned_write##bytes_(void* address) {                         \
    gnosphere::lanes::touch(address, bytes_, gnosphere::lanes::Access::write); \
  }
GNO_ACCESSES(1)
GNO_ACCESSES(2)
GNO_ACCESSES(4)
GNO_ACCESSES(8)
GNO_ACCESSES(16)
#undef GNO_ACCESSES

void __tsan_read_range(void* address, size_t bytes) {
  gnosphere::lanes::touch(address, bytes, gnosphere::lanes::Access::read);
}
void __tsan_write_range(void* address, size_t bytes) {
  gnosphere::lanes::touch(address, bytes, gnosphere::lanes::Access::write);
}
void __tsan_init() {}
void __tsan_func_entry(void*) {}
void __tsan_func_exit() {}
}
