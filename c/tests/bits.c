/*
 * The same records on every machine, made by integers alone, and what Picket measures of them.
 *
 *     bits BLOCKS ARITHMETIC [DIR]      on a desk; into DIR go the records and the answers
 *
 * On a board without an operating system (BARE) the blocks and the arithmetic are constants. It prints a checksum of all answers
 * for each kind and length, FNV-1a over the bytes of the tones.
 */
#include "picket.h"

#ifdef BARE
void say(const char *text); /* start.c */
#else
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
static void say(const char *text) { fputs(text, stdout); }
#endif

static uint64_t state;

/* Marsaglia's xorshift (2003), the upper half. */
static uint32_t draw(void) {
    state ^= state << 13;
    state ^= state >> 7;
    state ^= state << 17;
    return (uint32_t)(state >> 32);
}

static uint32_t below(uint32_t bound) { return (uint32_t)(((uint64_t)draw() * bound) >> 32); }

/* The sine of 2^32 parts of a turn, full scale 2^15: by the parabola of half a turn, and a second one of it, to a thousandth. */
static int32_t sine(uint32_t phase) {
    int64_t x = (int32_t)phase >> 15; /* -2^16 to 2^16: half turns */
    int64_t y = 4 * x * ((1 << 16) - (x < 0 ? -x : x)) >> 17;
    int64_t square = (y * (y < 0 ? -y : y)) >> 15;
    return (int32_t)(y + (((square - y) * 7373) >> 15));
}

/* A tone anywhere of any strength in noise of any strength. Some clip, some hold nothing, move, or have a second tone. */
static void fill(int16_t *samples, uint32_t n, uint32_t parts) {
    uint32_t step = draw(), phase = draw(), other_step = draw(), other = draw();
    int32_t amplitude = 3000 >> below(11), noise = 1 << below(11), offset = (int32_t)below(400) - 200;
    offset += offset < 0 ? -2 : 2; /* the tools refuse records of nothing but -1, 0 and 1, as of floats that were not scaled */
    uint32_t sort = below(16), bend = sort == 1 ? draw() / (n * n) : 0;
    int32_t second = sort == 2 ? amplitude >> below(6) : 0;
    if (sort == 3 && below(4) == 0) amplitude = noise = 0;
    for (uint32_t index = 0; index < n; index++) {
        for (uint32_t part = 0; part < parts; part++) {
            uint32_t quarter = parts == 2 && part == 0 ? 1u << 30 : 0;
            int32_t tone = (amplitude * sine(phase + quarter)) >> 15;
            tone += (second * sine(other + quarter)) >> 15;
            if (noise > 0) tone += (int32_t)below(2 * (uint32_t)noise) - noise;
            tone += offset;
            samples[index * parts + part] = (int16_t)(tone < -2048 ? -2048 : tone > 2047 ? 2047 : tone);
        }
        phase += step;
        step += bend;
        other += other_step;
    }
}

static int16_t samples[2 * 4096];
static union {
    picket_real4096 real;
    picket_iq4096 iq;
} memory;

static uint64_t hashed(uint64_t sum, const picket_tone *tone) {
    const uint8_t *bytes = (const uint8_t *)tone;
    for (size_t index = 0; index < sizeof *tone; index++) sum = (sum ^ bytes[index]) * 0x100000001B3u;
    return sum;
}

static void say_sum(const char *name, uint64_t sum) {
    char text[20];
    for (int digit = 0; digit < 16; digit++) text[digit] = "0123456789abcdef"[sum >> (60 - 4 * digit) & 15];
    text[16] = '\n';
    text[17] = 0;
    say(name);
    say(" ");
    say(text);
}

/* Measures so many blocks of a kind and length. The records and answers go into files, where there are any. */
#define MEASURE(KIND, N, PARTS)                                                                           \
    static int measure_##KIND(uint32_t blocks, uint8_t arithmetic, void *records, void *answers) {       \
        KIND *meter = (KIND *)&memory;                                                                   \
        picket_config config = {0};                                                                      \
        uint64_t sum = 0xCBF29CE484222325u;                                                              \
        config.rate_hz = 48000.0;                                                                        \
        config.low_code = -2048;                                                                         \
        config.high_code = 2047;                                                                         \
        config.arithmetic = arithmetic;                                                                  \
        if (KIND##_init(meter, &config, NULL) != PICKET_OK) return 1;                                    \
        state = 0x2545F4914F6CDD1Du ^ ((N) * 2 + (PARTS));                                               \
        for (uint32_t block = 0; block < blocks; block++) {                                              \
            picket_tone tone;                                                                            \
            fill(samples, N, PARTS);                                                                     \
            if (KIND##_block(meter, samples, N, &tone) != PICKET_OK) return 1;                           \
            sum = hashed(sum, &tone);                                                                    \
            KEEP(samples, 2 * (PARTS) * (N), records)                                                    \
            KEEP(&tone, sizeof tone, answers)                                                            \
        }                                                                                                \
        (void)records;                                                                                   \
        (void)answers;                                                                                   \
        say_sum(#KIND, sum);                                                                             \
        return 0;                                                                                        \
    }
#ifdef BARE
#define KEEP(what, bytes, file)
#else
#define KEEP(what, bytes, file) \
    if (file && fwrite(what, bytes, 1, (FILE *)file) != 1) return 1;
#endif
PICKET_EACH(MEASURE)

#ifdef BARE
int main(void) {
#define RUN(KIND, N, PARTS) \
    if (measure_##KIND(BLOCKS, PICKET_ARITHMETIC_OF_CORE, NULL, NULL)) return 1;
    PICKET_EACH(RUN)
    return 0;
}
#else
static FILE *created(const char *directory, const char *kind, const char *end) {
    char path[4096];
    if (!directory) return NULL;
    snprintf(path, sizeof path, "%s/%s.%s", directory, kind, end);
    return fopen(path, "wb");
}

int main(int count, char **words) {
    uint32_t blocks = count > 1 ? (uint32_t)strtoul(words[1], NULL, 10) : 100;
    uint8_t arithmetic = count > 2 && !strcmp(words[2], "fixed") ? PICKET_ARITHMETIC_FIXED : PICKET_ARITHMETIC_FLOAT;
    const char *directory = count > 3 ? words[3] : NULL;
#define RUN(KIND, N, PARTS)                                                 \
    {                                                                                             \
        FILE *records = created(directory, #KIND, "i16"), *answers = created(directory, #KIND, "tones"); \
        if (measure_##KIND(blocks, arithmetic, records, answers)) return 1;                       \
        if (records && fclose(records)) return 1;                                                 \
        if (answers && fclose(answers)) return 1;                                                 \
    }
    PICKET_EACH(RUN)
    return 0;
}
#endif
