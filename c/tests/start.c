/* Start-up of a program on an emulated MPS2 board, whose output and exit code go to the emulator by semihosting. No library of C. */
#include <stddef.h>
#include <stdint.h>

extern uint32_t stack_top[], data_from[], data_begin[], data_end[], bss_begin[], bss_end[];
int main(void);

/* What a compiler calls by itself. That Picket's archive brings none of them is tested by its symbols. */
void *memcpy(void *restrict to, const void *restrict from, size_t bytes) {
    uint8_t *out = to;
    const uint8_t *in = from;
    while (bytes-- > 0) *out++ = *in++;
    return to;
}

void *memset(void *to, int value, size_t bytes) {
    uint8_t *out = to;
    while (bytes-- > 0) *out++ = (uint8_t)value;
    return to;
}

static void host(int what, const void *with) {
    register int r0 __asm("r0") = what;
    register const void *r1 __asm("r1") = with;
    __asm volatile("bkpt 0xAB" : "+r"(r0) : "r"(r1) : "memory");
}

void say(const char *text) { host(4, text); }

void reset(void);
void reset(void) {
#ifdef __ARM_FP
    *(volatile uint32_t *)0xE000ED88 |= 0xFu << 20; /* the floating-point unit */
    __asm volatile("dsb\n isb");
#endif
    for (uint32_t *to = data_begin, *from = data_from; to < data_end;) *to++ = *from++;
    for (uint32_t *to = bss_begin; to < bss_end;) *to++ = 0;
    const uint32_t end[2] = {0x20026, (uint32_t)main()}; /* ADP_Stopped_ApplicationExit, the code */
    host(0x20, end);
    for (;;) {
    }
}

static void fault(void) {
    const uint32_t end[2] = {0x20023, 99}; /* ADP_Stopped_RunTimeErrorUnknown */
    host(0x20, end);
    for (;;) {
    }
}

__attribute__((section(".vectors"), used)) static const void *const vectors[16] = {
    stack_top, (const void *)reset, (const void *)fault, (const void *)fault,
    (const void *)fault, (const void *)fault, (const void *)fault,
};
