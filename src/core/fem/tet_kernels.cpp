#include "sinew/fem/tet_kernels.h"

namespace sinew {

namespace plain {
TetKernels tetKernels();
}
#if defined(__x86_64__)
namespace avx2 {
TetKernels tetKernels();
}
namespace avx512 {
TetKernels tetKernels();
}
#endif

TetKernels tetKernelsOf(InstructionSet set) {
  switch (set) {
#if defined(__x86_64__)
    case InstructionSet::kAvx2:
      return avx2::tetKernels();
    case InstructionSet::kAvx512:
      return avx512::tetKernels();
#endif
    default:
      return plain::tetKernels();
  }
}

}  // namespace sinew
