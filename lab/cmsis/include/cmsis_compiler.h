/* The names that CMSIS-DSP takes from CMSIS-Core, by the compiler's own intrinsics (Arm C language extensions). */
#ifndef CMSIS_COMPILER_H
#define CMSIS_COMPILER_H

#include <arm_acle.h>

#define __STATIC_FORCEINLINE static inline __attribute__((always_inline))
#define __STATIC_INLINE static inline
#define __INLINE inline
#define __ASM __asm
#define __ALIGNED(bytes) __attribute__((aligned(bytes)))
#define __WEAK __attribute__((weak))

#define __CLZ(x) ((uint8_t)((x) == 0 ? 32 : __builtin_clz(x)))
#define __SSAT(x, bits) __ssat(x, bits)
#define __USAT(x, bits) __usat(x, bits)
#define __QADD __qadd
#define __QSUB __qsub
#define __QADD16 __qadd16
#define __QSUB16 __qsub16
#define __SHADD16 __shadd16
#define __SHSUB16 __shsub16
#define __QASX __qasx
#define __QSAX __qsax
#define __SHASX __shasx
#define __SHSAX __shsax
#define __SMUAD __smuad
#define __SMUADX __smuadx
#define __SMUSD __smusd
#define __SMUSDX __smusdx
#define __SMLAD __smlad
#define __SMLADX __smladx
#define __SMLSDX __smlsdx
#define __SMLALD __smlald
#define __SMLALDX __smlaldx
#define __SXTB16 __sxtb16
/* The compiler has no intrinsics of these. */
#define __PKHBT(low, high, shift) __extension__({ uint32_t packed; \
    __asm("pkhbt %0, %1, %2, lsl %3" : "=r"(packed) : "r"(low), "r"(high), "I"(shift)); packed; })
#define __PKHTB(high, low, shift) __extension__({ uint32_t packed; \
    if ((shift) == 0) __asm("pkhtb %0, %1, %2" : "=r"(packed) : "r"(high), "r"(low)); \
    else __asm("pkhtb %0, %1, %2, asr %3" : "=r"(packed) : "r"(high), "r"(low), "I"(shift)); packed; })

#endif
