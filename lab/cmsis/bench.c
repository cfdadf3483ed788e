/* CMSIS-DSP's transform of a real record, counted as the images of Picket count theirs: once alone, once with the squared
   magnitudes of all bins and their largest, and once with Jacobsen's interpolation, too. Built for one ENGINE (Q15, Q31 or F32) and one
   length N. The records lie HEADER bytes into capture.bin; the spectra go to results.bin, each with its largest bin and the offset from
   that behind it, and the counts to the log. */

#include "arm_math.h"

#define PASTE(a, b, c) a##b##c
#define NAME(a, b, c) PASTE(a, b, c)

#if defined(Q15)
typedef q15_t Number;
static arm_rfft_instance_q15 instance;
#define START() NAME(arm_rfft_init_, N, _q15)(&instance, 0, 1)
#define TRANSFORM() arm_rfft_q15(&instance, input, output)
#define PEAK() (arm_cmplx_mag_squared_q15(output, input, N / 2), arm_max_q15(input, N / 2, &most, &place))
/* Of twelve bits, those that the number has. */
#define NUMBER(code) ((Number)((code) * 16))
#elif defined(Q31)
typedef q31_t Number;
static arm_rfft_instance_q31 instance;
#define START() NAME(arm_rfft_init_, N, _q31)(&instance, 0, 1)
#define TRANSFORM() arm_rfft_q31(&instance, input, output)
#define PEAK() (arm_cmplx_mag_squared_q31(output, input, N / 2), arm_max_q31(input, N / 2, &most, &place))
#define NUMBER(code) ((Number)(code) * (1 << 20))
#else
typedef float32_t Number;
static arm_rfft_fast_instance_f32 instance;
#define START() NAME(arm_rfft_fast_init_, N, _f32)(&instance)
#define TRANSFORM() arm_rfft_fast_f32(&instance, input, output, 0)
#define PEAK() (arm_cmplx_mag_squared_f32(output, input, N / 2), arm_max_f32(input, N / 2, &most, &place))
#define NUMBER(code) ((Number)(code) / 2048)
#endif

static int16_t codes[N];
static Number input[N], output[2 * N], most;
static uint32_t place;
static float32_t spectrum[N + 2];

/* Arm's semihosting. */
enum { OPEN = 1, WRITE0 = 4, WRITE = 5, READ = 6, EXIT = 0x18 };

static intptr_t host(intptr_t operation, const void *argument) {
  register intptr_t r0 __asm("r0") = operation;
  register const void *r1 __asm("r1") = argument;
  __asm volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
  return r0;
}

static intptr_t opened(const char *name, intptr_t mode) {
  const intptr_t arguments[] = {(intptr_t)name, mode, (intptr_t)strlen(name)};
  return host(OPEN, arguments);
}

/* Whether all of them were. */
static int moved(intptr_t operation, intptr_t file, void *bytes, intptr_t count) {
  const intptr_t arguments[] = {file, (intptr_t)bytes, count};
  return host(operation, arguments) == 0;
}

/* SysTick counts down at the core's clock, so instructions, which drive the emulated time. */
#define SYSTICK ((volatile uint32_t *)0xE000E010)
#define TOP 0xFFFFFFu

/* The marks are those by which a trace of the program shows where work begins and ends. */
#define TICKS(ticks, work)                                    \
  do {                                                        \
    uint32_t start = SYSTICK[2];                              \
    __asm volatile("mov r8, r8" ::: "memory");                \
    work;                                                     \
    __asm volatile("mov r9, r9" ::: "memory");                \
    ticks = (start - SYSTICK[2]) & TOP;                       \
  } while (0)

static void say(const char *name, uint32_t figure) {
  char line[48];
  char *at = line + sizeof line;
  *--at = 0;
  *--at = '\n';
  do *--at = '0' + figure % 10;
  while (figure /= 10);
  *--at = '=';
  for (size_t left = strlen(name); left > 0; left--) *--at = name[left - 1];
  host(WRITE0, at);
}

/* How many bins the tone is above the largest (E. Jacobsen and P. Kootsookos, "Fast, Accurate Frequency Estimators", IEEE Signal
   Processing Magazine 24(3), 2007). */
static float32_t offset(void) {
  if (place < 1 || place + 1 >= N / 2) return 0;
  const Number *here = output + 2 * place;
  float32_t below[2], bend[2];
  for (int part = 0; part < 2; part++) {
    float32_t low = here[part - 2], middle = here[part], high = here[part + 2];
    below[part] = low - high;
    bend[part] = 2 * middle - low - high;
  }
  return (below[0] * bend[0] + below[1] * bend[1]) / (bend[0] * bend[0] + bend[1] * bend[1]);
}

static void fill(void) {
  for (int n = 0; n < N; n++) input[n] = NUMBER(codes[n]);
}

#define COUNT(name, work)                                     \
  do {                                                        \
    uint32_t nothing, ticks;                                  \
    fill();                                                   \
    TICKS(nothing, );                                         \
    TICKS(ticks, work);                                       \
    say(name, ticks - nothing);                               \
  } while (0)

int main(void) {
  SYSTICK[1] = TOP;
  SYSTICK[2] = 0;
  SYSTICK[0] = 5;
  intptr_t capture = opened("capture.bin", 1), results = opened("results.bin", 5);
  /* The codes begin behind the header. */
  char header[HEADER];
  moved(READ, capture, header, HEADER);
  START();
  while (moved(READ, capture, codes, sizeof codes)) {
    COUNT("fft", TRANSFORM());
    for (int n = 0; n < N; n++) spectrum[n] = (float32_t)output[n];
    COUNT("fft_peak", (TRANSFORM(), PEAK()));
    COUNT("frequency", (TRANSFORM(), PEAK(), spectrum[N + 1] = offset()));
    spectrum[N] = place;
    moved(WRITE, results, spectrum, sizeof spectrum);
  }
  host(EXIT, (const void *)0x20026);
}

__attribute__((naked, noreturn)) void reset(void) {
  /* CPACR: the floating-point unit is on. */
  __asm volatile("ldr r0, =0xE000ED88\n ldr r1, [r0]\n orr r1, #0xF00000\n str r1, [r0]\n dsb\n isb\n bl main\n b .");
}

extern uint32_t stack_top;
__attribute__((section(".vectors"), used)) static const void *const vectors[] = {&stack_top, reset};

/* The compiler may call these for loops that do the same. */
void *memcpy(void *to, const void *from, size_t count) {
  for (size_t n = 0; n < count; n++) ((volatile char *)to)[n] = ((const char *)from)[n];
  return to;
}

void *memmove(void *to, const void *from, size_t count) {
  if (to <= from) return memcpy(to, from, count);
  for (size_t n = count; n > 0; n--) ((volatile char *)to)[n - 1] = ((const char *)from)[n - 1];
  return to;
}

void *memset(void *to, int value, size_t count) {
  for (size_t n = 0; n < count; n++) ((volatile char *)to)[n] = (char)value;
  return to;
}

size_t strlen(const char *text) {
  size_t count = 0;
  while (((const volatile char *)text)[count] != 0) count++;
  return count;
}
