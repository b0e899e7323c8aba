#include "solver/allocation_count.h"

#include <cerrno>
#include <cstddef>

namespace {
long count = 0;
}

#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__)
#define SINEW_COUNTS_ALLOCATIONS true

extern "C" {
void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t count, std::size_t size);
void* __libc_realloc(void* memory, std::size_t size);
void* __libc_memalign(std::size_t alignment, std::size_t size);

void* malloc(std::size_t size) {
  ++count;
  return __libc_malloc(size);
}
void* calloc(std::size_t entries, std::size_t size) {
  ++count;
  return __libc_calloc(entries, size);
}
void* realloc(void* memory, std::size_t size) {
  ++count;
  return __libc_realloc(memory, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
  ++count;
  return __libc_memalign(alignment, size);
}
int posix_memalign(void** memory, std::size_t alignment, std::size_t size) {
  ++count;
  *memory = __libc_memalign(alignment, size);
  return *memory != nullptr ? 0 : ENOMEM;
}
}
#else
#define SINEW_COUNTS_ALLOCATIONS false
#endif

namespace sinew {

long allocationCount() {
  return count;
}

bool countsAllocations() {
  return SINEW_COUNTS_ALLOCATIONS;
}

}  // namespace sinew
