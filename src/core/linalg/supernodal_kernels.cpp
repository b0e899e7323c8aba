#include "sinew/linalg/supernodal_kernels.h"

namespace sinew {

namespace plain {
const SupernodalKernels& supernodalKernels();
}
#if defined(__x86_64__)
namespace avx2 {
const SupernodalKernels& supernodalKernels();
}
namespace avx512 {
const SupernodalKernels& supernodalKernels();
}
#endif

const SupernodalKernels& kernelsOf(InstructionSet set) {
  switch (set) {
#if defined(__x86_64__)
    case InstructionSet::kAvx2:
      return avx2::supernodalKernels();
    case InstructionSet::kAvx512:
      return avx512::supernodalKernels();
#endif
    default:
      return plain::supernodalKernels();
  }
}

}  // namespace sinew
