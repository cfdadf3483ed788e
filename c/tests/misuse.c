/* Every misuse that a call can see is answered by its status, with nothing written; and the right use of every call. */
#include "picket.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int failures;
#define EXPECT(call, wanted)                                                                              \
    do {                                                                                                  \
        picket_status said = (call);                                                                      \
        if (said != (wanted)) {                                                                           \
            printf("line %d: %s: %d, not %d: %s\n", __LINE__, #call, (int)said, (int)(wanted),            \
                   picket_status_message(said));                                                          \
            failures++;                                                                                   \
        }                                                                                                 \
    } while (0)
#define CHECK(truth)                                             \
    do {                                                         \
        if (!(truth)) {                                          \
            printf("line %d: %s is false\n", __LINE__, #truth);  \
            failures++;                                          \
        }                                                        \
    } while (0)

/* As the library lays them out, see c/src/types.rs. */
typedef char sizes[sizeof(picket_tone) == 32 && sizeof(picket_line) == 40 && sizeof(picket_target) == 128 &&
                           sizeof(picket_measurement) == 168 && sizeof(picket_track) == 48 && sizeof(picket_stamp) == 16 &&
                           sizeof(picket_config) == 40 && sizeof(picket_scene) == 88 && sizeof(picket_following) == 8 &&
                           sizeof(picket_accumulating) == 24 && sizeof(picket_accumulated) == 40 &&
                           sizeof(picket_trigger) == 16 && sizeof(picket_burst) == 48 && sizeof(picket_counts) == 32
                       ? 1
                       : -1];

/* A tone whose frequency rises by so much within the record. */
static void beat_of(int16_t *samples, int n, int parts, double cycles, double rise) {
    uint32_t state = 1;
    for (int index = 0; index < n; index++) {
        for (int part = 0; part < parts; part++) {
            state = state * 1664525u + 1013904223u;
            double now = cycles + 0.5 * rise * ((double)index / n - 1.0);
            double angle = 6.283185307179586 * now * index + (parts == 2 && part == 0 ? 1.5707963267948966 : 0.0);
            samples[index * parts + part] = (int16_t)lrint(900.0 * sin(angle) + (double)(state >> 24 & 15) - 7.5);
        }
    }
}

static void tone_of(int16_t *samples, int n, int parts, double cycles) {
    beat_of(samples, n, parts, cycles, 0.0);
}

static const picket_config CONFIG = {48000.0, 0.0, 0.0, 0.0, -2048, 2047, 0, 0, {0, 0}};

static int all_are(const void *memory, size_t bytes, uint8_t value) {
    const uint8_t *at = (const uint8_t *)memory;
    while (bytes > 0 && *at == value) at++, bytes--;
    return bytes == 0;
}

/* A tone in memory of exactly as many bytes as the archive asks for: an address sanitizer sees a byte beyond. */
#define USE(KIND, N, PARTS)                                                                                             \
    static void use_##KIND(void) {                                                                                    \
        CHECK(KIND##_size() <= sizeof(KIND) && KIND##_tracker_size() <= sizeof(KIND##_tracker));                      \
        KIND *meter = (KIND *)malloc(KIND##_size());                                                                  \
        KIND##_tracker *tracker = (KIND##_tracker *)malloc(KIND##_tracker_size());                                    \
        int16_t *samples = (int16_t *)malloc(2 * (PARTS) * (N));                                                      \
        picket_tone tone;                                                                                             \
        picket_measurement seen;                                                                                      \
        picket_line lines[4];                                                                                         \
        picket_track tracks[8];                                                                                       \
        picket_target targets[4];                                                                                     \
        size_t found = 99;                                                                                            \
        uint32_t orders = 99;                                                                                         \
        picket_following following = {0};                                                                             \
        memset(meter, 0xA5, KIND##_size());                                                                           \
        memset(tracker, 0xA5, KIND##_tracker_size());                                                                 \
        memset(&tone, 0x5A, sizeof tone);                                                                             \
        memset(&seen, 0x5A, sizeof seen);                                                                             \
        tone_of(samples, N, PARTS, 0.2034);                                                                           \
        EXPECT(KIND##_block(meter, samples, N, &tone), PICKET_ERROR_UNINITIALISED);                                   \
        EXPECT(KIND##_measure(meter, NULL, samples, N, &seen), PICKET_ERROR_UNINITIALISED);                           \
        EXPECT(KIND##_harmonics(meter, 8, &tone, &orders), PICKET_ERROR_UNINITIALISED);                               \
        EXPECT(KIND##_lines(meter, lines, 4, &found), PICKET_ERROR_UNINITIALISED);                                    \
        EXPECT(KIND##_track(tracker, NULL, samples, N, &seen, tracks, 8, &found), PICKET_ERROR_UNINITIALISED);        \
        EXPECT(KIND##_targets(tracker, targets, 4, &found), PICKET_ERROR_UNINITIALISED);                              \
        CHECK(all_are(&tone, sizeof tone, 0x5A) && all_are(&seen, sizeof seen, 0x5A) && found == 99 && orders == 99);                 \
        picket_config config = CONFIG;                                                                                \
        config.high_code = -2000;                                                                                     \
        EXPECT(KIND##_init(meter, &config, NULL), PICKET_ERROR_CODES);                                                \
        CHECK(all_are(meter, KIND##_size(), 0xA5));                                                                   \
        EXPECT(KIND##_init(meter, &CONFIG, NULL), PICKET_OK);                                                         \
        EXPECT(KIND##_harmonics(meter, 8, &tone, &orders), PICKET_ERROR_NO_BLOCK);                                    \
        EXPECT(KIND##_harmonics(meter, 1, &tone, &orders), PICKET_ERROR_OPTION);                                      \
        EXPECT(KIND##_harmonics(meter, 33, &tone, &orders), PICKET_ERROR_OPTION);                                     \
        EXPECT(KIND##_harmonics(meter, 8, &tone, NULL), PICKET_ERROR_NULL);                                           \
        EXPECT(KIND##_lines(meter, lines, 4, &found), PICKET_ERROR_NO_BLOCK);                                         \
        EXPECT(KIND##_block(meter, samples, (N)-1, &tone), PICKET_ERROR_SAMPLES);                                     \
        EXPECT(KIND##_block(meter, samples, (N) + 1, &tone), PICKET_ERROR_SAMPLES);                                   \
        EXPECT(KIND##_block(meter, samples, 0, &tone), PICKET_ERROR_SAMPLES);                                         \
        EXPECT(KIND##_block(meter, NULL, N, &tone), PICKET_ERROR_NULL);                                               \
        EXPECT(KIND##_block(meter, samples, N, NULL), PICKET_ERROR_NULL);                                             \
        EXPECT(KIND##_block(NULL, samples, N, &tone), PICKET_ERROR_NULL);                                             \
        EXPECT(KIND##_block(meter, (int16_t *)((char *)samples + 1), N, &tone), PICKET_ERROR_UNALIGNED);              \
        CHECK(all_are(&tone, sizeof tone, 0x5A));                                                                     \
        EXPECT(KIND##_block(meter, samples, N, &tone), PICKET_OK);                                                    \
        CHECK(tone.verdict == PICKET_GOOD && fabs(tone.frequency_hz - 0.2034 * 48000.0) < 5.0 * tone.sigma_hz);       \
        CHECK(tone.sigma_hz > 0.0 && tone.sigma_hz < 100.0 && fabs(tone.amplitude - 900.0) < 20.0);                   \
        EXPECT(KIND##_lines(meter, lines, 0, &found), PICKET_OK);                                                     \
        CHECK(found == 0);                                                                                            \
        EXPECT(KIND##_lines(meter, lines, 4, &found), PICKET_OK);                                                     \
        CHECK(found == 1 && fabs(lines[0].tone.frequency_hz - tone.frequency_hz) < 5.0 * tone.sigma_hz);              \
        CHECK(fabs(lines[0].phase_rad) <= 3.1416 && lines[0].sigma_phase_rad > 0.0);                                  \
        EXPECT(KIND##_measure(meter, NULL, samples, N, &seen), PICKET_OK);                                            \
        CHECK(memcmp(&seen.tone, &tone, sizeof tone) == 0 && seen.outcome == PICKET_OUTCOME_NONE);                    \
        EXPECT(KIND##_init_tone(meter, 48000.0, -2048, 2047), PICKET_OK);                                             \
        EXPECT(KIND##_block(meter, samples, N, &tone), PICKET_OK);                                                    \
        CHECK(tone.verdict == PICKET_GOOD && fabs(tone.frequency_hz - 0.2034 * 48000.0) < 5.0 * tone.sigma_hz);       \
        EXPECT(KIND##_tracker_init(tracker, &CONFIG, NULL, NULL), PICKET_ERROR_NULL);                                 \
        EXPECT(KIND##_tracker_init(tracker, &CONFIG, NULL, &following), PICKET_OK);                                   \
        for (int block = 0; block < 4; block++)                                                                       \
            EXPECT(KIND##_track(tracker, NULL, samples, N, &seen, tracks, 8, &found), PICKET_OK);                     \
        CHECK(found == 1 && tracks[0].state == PICKET_HELD && tracks[0].age == 3 && tracks[0].misses == 0);           \
        CHECK(fabs(tracks[0].tone.frequency_hz - 0.2034 * 48000.0) < 5.0 * tone.sigma_hz);                            \
        EXPECT(KIND##_targets(tracker, targets, 4, &found), PICKET_OK);                                               \
        CHECK(found == 0);                                                                                            \
        KIND##_accumulator *sum = (KIND##_accumulator *)malloc(KIND##_accumulator_size());                            \
        picket_accumulating terms = {0};                                                                              \
        picket_accumulated added;                                                                                     \
        uint8_t complete = 9;                                                                                         \
        CHECK(KIND##_accumulator_size() <= sizeof(KIND##_accumulator));                                               \
        memset(sum, 0, KIND##_accumulator_size());                                                                    \
        EXPECT(KIND##_accumulate(sum, meter, &added, &complete), PICKET_ERROR_UNINITIALISED);                         \
        EXPECT(KIND##_accumulator_init(sum, &terms), PICKET_ERROR_OPTION);                                            \
        terms.blocks = 4;                                                                                             \
        EXPECT(KIND##_accumulator_init(sum, &terms), PICKET_OK);                                                      \
        EXPECT(KIND##_accumulate(sum, (const KIND *)tracker, &added, &complete), PICKET_ERROR_UNINITIALISED);         \
        EXPECT(KIND##_accumulate(sum, meter, NULL, &complete), PICKET_ERROR_NULL);                                    \
        CHECK(complete == 9);                                                                                         \
        for (int block = 0; block < 4; block++) {                                                                     \
            CHECK(block == 0 || complete == 0);                                                                       \
            EXPECT(KIND##_block(meter, samples, N, &tone), PICKET_OK);                                                \
            EXPECT(KIND##_accumulate(sum, meter, &added, &complete), PICKET_OK);                                      \
        }                                                                                                             \
        CHECK(complete == 1 && added.blocks == 4 && added.tone.verdict == PICKET_GOOD);                               \
        CHECK(fabs(added.tone.frequency_hz - 0.2034 * 48000.0) < 20.0 * added.tone.sigma_hz);                         \
        free(sum);                                                                                                    \
        free(meter);                                                                                                  \
        free(tracker);                                                                                                \
        free(samples);                                                                                                \
    }
PICKET_EACH(USE)

/* A burst of an eighth of a record, alone in four records of noise, pushed in pieces; in memory of exactly as many bytes as asked for. */
#define BURST(KIND, N, PARTS)                                                                                         \
    static void burst_##KIND(void) {                                                                                  \
        KIND##_bursts *stream = (KIND##_bursts *)malloc(KIND##_bursts_size());                                        \
        int16_t *part = (int16_t *)malloc(2 * (PARTS) * 64);                                                          \
        picket_trigger trigger = {0};                                                                                 \
        picket_burst bursts[2];                                                                                       \
        picket_counts counts;                                                                                         \
        size_t found = 99, valid = 0, total = 0;                                                                      \
        uint32_t state = 7;                                                                                           \
        CHECK(KIND##_bursts_size() <= sizeof(KIND##_bursts));                                                         \
        memset(stream, 0, KIND##_bursts_size());                                                                      \
        memset(bursts, 0x5A, sizeof bursts);                                                                          \
        memset(part, 0, 2 * (PARTS) * 64);                                                                            \
        EXPECT(KIND##_bursts_push(stream, part, 64, bursts, 2, &found), PICKET_ERROR_UNINITIALISED);                  \
        EXPECT(KIND##_bursts_lost(stream, 1), PICKET_ERROR_UNINITIALISED);                                            \
        EXPECT(KIND##_bursts_counts(stream, &counts), PICKET_ERROR_UNINITIALISED);                                    \
        EXPECT(KIND##_bursts_init(stream, NULL, NULL), PICKET_ERROR_NULL);                                            \
        trigger.ratio = 0.5f;                                                                                         \
        EXPECT(KIND##_bursts_init(stream, &CONFIG, &trigger), PICKET_ERROR_OPTION);                                   \
        trigger.ratio = 0.0f;                                                                                         \
        trigger.reserved = 1;                                                                                         \
        EXPECT(KIND##_bursts_init(stream, &CONFIG, &trigger), PICKET_ERROR_OPTION);                                   \
        CHECK(all_are(stream, KIND##_bursts_size(), 0) && all_are(bursts, sizeof bursts, 0x5A) && found == 99);       \
        EXPECT(KIND##_bursts_init(stream, &CONFIG, NULL), PICKET_OK);                                                 \
        EXPECT(KIND##_bursts_push(stream, NULL, 64, bursts, 2, &found), PICKET_ERROR_NULL);                           \
        EXPECT(KIND##_bursts_push(stream, (int16_t *)((char *)part + 1), 64, bursts, 2, &found),                      \
               PICKET_ERROR_UNALIGNED);                                                                               \
        EXPECT(KIND##_bursts_push(stream, part, 64, bursts, 2, NULL), PICKET_ERROR_NULL);                             \
        CHECK(found == 99);                                                                                           \
        for (int from = 0; from < 16 * (N); from += 64) {                                                             \
            for (int index = 0; index < 64 * (PARTS); index++) {                                                      \
                double t = from + index / (PARTS) - 9.3 * (N), s = 0.125 * (N);                                       \
                double angle = 1.7 * t + ((PARTS) == 2 && index % 2 == 0 ? 1.5707963267948966 : 0.0), noise = -24.0;  \
                for (int sum = 0; sum < 12; sum++) {                                                                  \
                    state = state * 1664525u + 1013904223u;                                                           \
                    noise += (state >> 8) / 4194304.0;                                                                \
                }                                                                                                     \
                part[index] = (int16_t)lrint(900.0 * exp(-t * t / 2.0 / s / s) * sin(angle) + 10.0 * noise);          \
            }                                                                                                         \
            EXPECT(KIND##_bursts_push(stream, part, 64, bursts, 2, &found), PICKET_OK);                               \
            for (size_t index = 0; index < found && index < 2; index++) {                                             \
                if (bursts[index].validation != PICKET_VALID) continue;                                               \
                double off = bursts[index].tone.frequency_hz - 1.7 / 6.283185307179586 * 48000.0;                     \
                CHECK(fabs(off) < 5.0 * bursts[index].tone.sigma_hz && bursts[index].tone.verdict == PICKET_GOOD);    \
                CHECK(fabs(bursts[index].arrival - 9.3 * (N)) < 0.03 * (N));                                          \
                CHECK(fabs(bursts[index].deviation - 0.125 * (N)) < 0.02 * (N));                                      \
                valid++;                                                                                              \
            }                                                                                                         \
            total += found;                                                                                           \
        }                                                                                                             \
        EXPECT(KIND##_bursts_counts(stream, &counts), PICKET_OK);                                                     \
        CHECK(valid == 1 && counts.bursts >= total && counts.samples == 16 * (N) && counts.dead > 0);                 \
        EXPECT(KIND##_bursts_lost(stream, 1000), PICKET_OK);                                                          \
        free(stream);                                                                                                 \
        free(part);                                                                                                   \
    }
PICKET_EACH(BURST)

static picket_real1024 meter;
static picket_real1024_tracker tracker;
static picket_iq1024 iq;
static int16_t samples[2048];

static void options(void) {
    picket_config config = CONFIG;
    picket_scene scene = {0};
    picket_following following = {0};
    EXPECT(picket_real1024_init(NULL, &config, NULL), PICKET_ERROR_NULL);
    EXPECT(picket_real1024_init(&meter, NULL, NULL), PICKET_ERROR_NULL);
    EXPECT(picket_real1024_init((picket_real1024 *)((char *)&meter + 4), &config, NULL), PICKET_ERROR_UNALIGNED);
    EXPECT(picket_real1024_init_tone(&meter, 0.0, 0, 4095), PICKET_ERROR_RATE);
    EXPECT(picket_real1024_init_tone(&meter, (double)NAN, 0, 4095), PICKET_ERROR_RATE);
    EXPECT(picket_real1024_init_tone(&meter, 1.0, 4095, 0), PICKET_ERROR_CODES);
    CHECK(all_are(&meter, sizeof meter, 0));
#define WRONG(field, value, status)                                       \
    config = CONFIG;                                                      \
    config.field = value;                                                 \
    EXPECT(picket_real1024_init(&meter, &config, NULL), status)
    WRONG(rate_hz, -1.0, PICKET_ERROR_RATE);
    WRONG(rate_hz, HUGE_VAL, PICKET_ERROR_RATE);
    WRONG(band_low_hz, 30000.0, PICKET_ERROR_BAND);
    WRONG(band_high_hz, (double)NAN, PICKET_ERROR_BAND);
    WRONG(false_alarm, 0.6, PICKET_ERROR_FALSE_ALARM);
    WRONG(false_alarm, -1e-3, PICKET_ERROR_FALSE_ALARM);
    WRONG(arithmetic, 3, PICKET_ERROR_OPTION);
    WRONG(reach, 5, PICKET_ERROR_OPTION);
    WRONG(reserved[1], 1, PICKET_ERROR_OPTION);
    config = CONFIG;
    scene.kind = PICKET_SCENE_DOPPLER;
    EXPECT(picket_real1024_init(&meter, &config, &scene), PICKET_ERROR_SCENE);
    scene.wavelength_m = 1e300;
    EXPECT(picket_real1024_init(&meter, &config, &scene), PICKET_ERROR_SCALE);
    scene.wavelength_m = 0.0125;
    scene.kind = PICKET_SCENE_CHIRP;
    scene.bandwidth_hz = 200e6;
    scene.duration_s = 1e-3;
    EXPECT(picket_real1024_init(&meter, &config, &scene), PICKET_ERROR_RAMP);
    scene.kind = 3;
    EXPECT(picket_real1024_init(&meter, &config, &scene), PICKET_ERROR_OPTION);
    scene.kind = PICKET_SCENE_DOPPLER;
    scene.mixing = 2;
    EXPECT(picket_real1024_init(&meter, &config, &scene), PICKET_ERROR_OPTION);
    scene.mixing = 0;
    following.most = 5;
    EXPECT(picket_real1024_tracker_init(&tracker, &config, &scene, &following), PICKET_ERROR_FOLLOWING);
    following.most = 0;
    following.rate_bins = -1.0f;
    EXPECT(picket_real1024_tracker_init(&tracker, &config, &scene, &following), PICKET_ERROR_FOLLOWING);
    CHECK(all_are(&meter, sizeof meter, 0) && all_are(&tracker, sizeof tracker, 0));
    /* One kind's memory is not another's, nor a tracker's a pipeline's. */
    picket_tone tone;
    EXPECT(picket_real1024_init(&meter, &config, &scene), PICKET_OK);
    EXPECT(picket_iq1024_block((picket_iq1024 *)&meter, samples, 1024, &tone), PICKET_ERROR_UNINITIALISED);
    EXPECT(picket_real512_block((picket_real512 *)&meter, samples, 512, &tone), PICKET_ERROR_UNINITIALISED);
    EXPECT(picket_real1024_targets((picket_real1024_tracker *)&meter, NULL, 0, NULL), PICKET_ERROR_UNINITIALISED);
}

static void scenes(void) {
    picket_config config = CONFIG;
    picket_scene scene = {0};
    picket_following following = {0};
    picket_measurement seen;
    picket_track tracks[8];
    picket_target targets[4];
    size_t found;
    scene.kind = PICKET_SCENE_DOPPLER;
    scene.wavelength_m = 0.0125;
    scene.mixing = PICKET_RX_CONJ_TX;
    tone_of(samples, 1024, 2, 0.1);
    EXPECT(picket_iq1024_init(&iq, &config, &scene), PICKET_OK);
    EXPECT(picket_iq1024_measure(&iq, NULL, samples, 1024, &seen), PICKET_OK);
    double velocity = 0.5 * 0.0125 * seen.tone.frequency_hz;
    CHECK(seen.outcome == PICKET_OUTCOME_VELOCITY && fabs(seen.target.velocity_mps - velocity) < 1e-6);
    CHECK(fabs(fabs(velocity) - 30.0) < 0.01 && seen.target.sigma_velocity_mps > 0.0f && seen.target.verdict == PICKET_GOOD);
    /*
     * A triangle: 0.10 and 0.12 cycles per sample, blocks in turn. 0.11 of range and 0.01 of Doppler, as the textbook has them,
     * c T f / (2 B) and lambda f / 2; or the roles exchanged, which a bound of the velocity excludes.
     */
    scene.kind = PICKET_SCENE_CHIRP;
    scene.shape = PICKET_TRIANGLE;
    scene.bandwidth_hz = 200e6;
    scene.duration_s = 1024 / 48000.0;
    double range = 299792458.0 * scene.duration_s * 0.11 * 48000.0 / (2.0 * 200e6);
    /* It approaches by 3 m/s, so both beats fall within a ramp: by its way and by its Doppler shift, each 2 B v T / (c T rate). */
    double fall = -4.0 * 200e6 * 0.5 * 0.0125 * 0.01 * 48000.0 / (299792458.0 * 48000.0);
    for (int bounded = 0; bounded < 2; bounded++) {
        scene.velocity_low_mps = -10.0 * bounded;
        scene.velocity_high_mps = 10.0 * bounded;
        EXPECT(picket_real1024_init(&meter, &config, &scene), PICKET_OK);
        EXPECT(picket_real1024_tracker_init(&tracker, &config, &scene, &following), PICKET_OK);
        for (int block = 0; block < 12; block++) {
            beat_of(samples, 1024, 1, block % 2 == 0 ? 0.10 : 0.12, fall);
            EXPECT(picket_real1024_measure(&meter, NULL, samples, 1024, &seen), PICKET_OK);
            CHECK(seen.outcome == (block % 2 == 0 ? PICKET_OUTCOME_NONE : PICKET_OUTCOME_TARGET));
            EXPECT(picket_real1024_track(&tracker, NULL, samples, 1024, &seen, tracks, 8, &found), PICKET_OK);
        }
        CHECK(seen.outcome == PICKET_OUTCOME_TARGET);
        EXPECT(picket_real1024_targets(&tracker, targets, 4, &found), PICKET_OK);
        CHECK(found == 1);
        const picket_target both[2] = {seen.target, targets[0]};
        for (int index = 0; index < 2; index++) {
            const picket_target *target = &both[index];
            CHECK(target->ambiguity == (bounded ? PICKET_BY_BOUND : PICKET_SEVERAL));
            CHECK(target->verdict == (bounded ? PICKET_GOOD : PICKET_AMBIGUOUS));
            CHECK(target->count == (bounded ? 0 : 2));
            if (bounded) {
                CHECK(fabs(target->range_m - range) < 0.002 * range);
                CHECK(fabs(fabs(target->velocity_mps) - 0.5 * 0.0125 * 0.01 * 48000.0) < 0.05);
            } else {
                /* The beats of all chirps are the same: neither candidate is where its velocity takes it. */
                const picket_candidate *near = &target->candidates[0], *far = &target->candidates[1];
                if (near->range_m > far->range_m) near = far, far = &target->candidates[0];
                CHECK(fabs(far->range_m - range) < 0.002 * range && fabs(near->range_m - range / 11.0) < 0.002 * range);
                CHECK(fabs(near->odds + far->odds - 1.0) < 1e-3 && near->odds > 0.4 && far->odds > 0.4);
            }
        }
    }
    /* A stamp of one's own: a gap is told. */
    picket_stamp stamp = {4096, 20, PICKET_UP, 1, {0, 0}};
    EXPECT(picket_real1024_measure(&meter, &stamp, samples, 1024, &seen), PICKET_OK);
    CHECK(seen.tone.verdict == PICKET_GAP);
    stamp.segment = 4;
    EXPECT(picket_real1024_measure(&meter, &stamp, samples, 1024, &seen), PICKET_ERROR_OPTION);
}

/* Frames, ranges by phase, budgets and ways. */
static void frames(void) {
    static picket_frame frame;
    static picket_way way;
    static int16_t cells[127 * 8][2];
    static float still[127 * 2];
    picket_config config = CONFIG;
    picket_scene scene = {0};
    picket_framing framing = {0};
    picket_frame_target targets[8];
    size_t count = 77;
    uint8_t complete = 9;
    float share = -1.0f;
    CHECK(picket_frame_size() <= sizeof frame && picket_way_size() <= sizeof way);
    scene.kind = PICKET_SCENE_CHIRP;
    scene.shape = PICKET_SAWTOOTH;
    scene.wavelength_m = 0.0125;
    scene.bandwidth_hz = 200e6;
    scene.duration_s = 256 / 48000.0;
    framing.period_s = scene.duration_s;
    framing.chirps = 8;
    EXPECT(picket_frame_targets(&frame, NULL, targets, 8, &count), PICKET_ERROR_UNINITIALISED);
    EXPECT(picket_frame_clear(&frame), PICKET_ERROR_UNINITIALISED);
    EXPECT(picket_frame_cells(&config, &scene, &framing, 256, 0, NULL), PICKET_ERROR_NULL);
    EXPECT(picket_frame_cells(&config, NULL, &framing, 256, 0, &count), PICKET_ERROR_NULL);
    EXPECT(picket_frame_cells(&config, &scene, &framing, 250, 0, &count), PICKET_ERROR_LENGTH);
    EXPECT(picket_frame_cells(&config, &scene, &framing, 256, 2, &count), PICKET_ERROR_OPTION);
    framing.chirps = 12;
    EXPECT(picket_frame_cells(&config, &scene, &framing, 256, 0, &count), PICKET_ERROR_FRAME);
    framing.chirps = 8;
    framing.false_alarm = 2.0;
    EXPECT(picket_frame_cells(&config, &scene, &framing, 256, 0, &count), PICKET_ERROR_FALSE_ALARM);
    framing.false_alarm = 0.0;
    framing.last_bin = 300;
    EXPECT(picket_frame_cells(&config, &scene, &framing, 256, 0, &count), PICKET_ERROR_BAND);
    framing.last_bin = 0;
    scene.kind = PICKET_SCENE_TONE;
    EXPECT(picket_frame_cells(&config, &scene, &framing, 256, 0, &count), PICKET_ERROR_SCENE);
    scene.kind = PICKET_SCENE_CHIRP;
    CHECK(count == 77);
    EXPECT(picket_frame_cells(&config, &scene, &framing, 256, 0, &count), PICKET_OK);
    CHECK(count == 127 * 8);
    EXPECT(picket_frame_init(&frame, &config, &scene, &framing, 256, 0, cells, count - 1), PICKET_ERROR_ROOM);
    EXPECT(picket_frame_init(&frame, &config, &scene, &framing, 256, 0, NULL, count), PICKET_ERROR_NULL);
    EXPECT(picket_frame_init(NULL, &config, &scene, &framing, 256, 0, cells, count), PICKET_ERROR_NULL);
    CHECK(all_are(&frame, sizeof frame, 0));
    EXPECT(picket_frame_init(&frame, &config, &scene, &framing, 256, 0, cells, count), PICKET_OK);
    EXPECT(picket_frame_targets(&frame, NULL, targets, 8, &count), PICKET_ERROR_NO_BLOCK);
    EXPECT(picket_frame_background(&frame, still, 127, &share), PICKET_ERROR_NO_BLOCK);
    static picket_real256 chirp;
    static picket_real512 other;
    EXPECT(picket_real256_frame_push(&frame, &chirp, &complete), PICKET_ERROR_UNINITIALISED);
    EXPECT(picket_real256_init(&chirp, &config, NULL), PICKET_OK);
    EXPECT(picket_real512_init(&other, &config, NULL), PICKET_OK);
    EXPECT(picket_real256_frame_push(&frame, &chirp, &complete), PICKET_ERROR_NO_BLOCK);
    picket_tone tone;
    picket_line line;
    tone_of(samples, 512, 1, 0.2034);
    EXPECT(picket_real512_block(&other, samples, 512, &tone), PICKET_OK);
    EXPECT(picket_real512_frame_push(&frame, &other, &complete), PICKET_ERROR_SAMPLES);
    EXPECT(picket_real256_block(&chirp, samples, 256, &tone), PICKET_OK);
    EXPECT(picket_real256_frame_push(&frame, &chirp, NULL), PICKET_ERROR_NULL);
    EXPECT(picket_frame_clear(&frame), PICKET_OK);
    CHECK(complete == 9);
    uint32_t state = 5;
    for (int number = 0; number < 8; number++) {
        /* The tone stands, and each chirp has noise of its own. */
        tone_of(samples, 256, 1, 0.2034);
        for (int index = 0; index < 256; index++) {
            state = state * 1664525u + 1013904223u;
            samples[index] = (int16_t)(samples[index] + (int)(state >> 26) - 32);
        }
        EXPECT(picket_real256_block(&chirp, samples, 256, &tone), PICKET_OK);
        EXPECT(picket_real256_frame_push(&frame, &chirp, &complete), PICKET_OK);
        CHECK(complete == (number == 7));
    }
    EXPECT(picket_frame_targets(&frame, NULL, NULL, 8, &count), PICKET_ERROR_NULL);
    EXPECT(picket_frame_targets(&frame, NULL, targets, 8, NULL), PICKET_ERROR_NULL);
    EXPECT(picket_frame_background(&frame, still, 126, &share), PICKET_ERROR_ROOM);
    CHECK(share == -1.0f);
    EXPECT(picket_frame_targets(&frame, NULL, targets, 8, &count), PICKET_OK);
    CHECK(count >= 1 && fabs(targets[0].target.velocity_mps) < 5.0 * targets[0].target.sigma_velocity_mps + 1e-6);
    EXPECT(picket_frame_background(&frame, still, 127, &share), PICKET_OK);
    CHECK(share > 0.99f);
    /* Nothing but what stands: less the background there is no target. */
    EXPECT(picket_frame_targets(&frame, still, targets, 8, &count), PICKET_OK);
    CHECK(count == 0);
    EXPECT(picket_real256_lines(&chirp, &line, 1, &count), PICKET_OK);
    picket_phase_range range;
    picket_calibration calibration = {0};
    picket_budget budget;
    picket_uncertainty known = {0};
    memset(&range, 0x5A, sizeof range);
    EXPECT(picket_range_by_phase(NULL, NULL, 48000.0, 256, 0, PICKET_UP, &line, NULL, &range), PICKET_ERROR_NULL);
    EXPECT(picket_range_by_phase(&scene, NULL, 48000.0, 256, 0, 9, &line, NULL, &range), PICKET_ERROR_OPTION);
    EXPECT(picket_range_by_phase(&scene, NULL, 1000.0, 256, 0, PICKET_UP, &line, NULL, &range), PICKET_ERROR_RAMP);
    calibration.sigma_phase_rad = -1.0f;
    EXPECT(picket_range_by_phase(&scene, &calibration, 48000.0, 256, 0, PICKET_UP, &line, NULL, &range), PICKET_ERROR_SCENE);
    CHECK(all_are(&range, sizeof range, 0x5A));
    EXPECT(picket_calibrate(&scene, 48000.0, 256, 0, &line, (double)NAN, 0.0f, &calibration), PICKET_ERROR_OPTION);
    EXPECT(picket_calibrate(&scene, 48000.0, 256, 0, &line, 1000.0, 0.0f, &calibration), PICKET_OK);
    CHECK(calibration.sigma_phase_rad > 0.0f && calibration.sigma_offset_m > 0.0f);
    EXPECT(picket_range_by_phase(&scene, &calibration, 48000.0, 256, 0, PICKET_UP, &line, NULL, &range), PICKET_OK);
    CHECK(fabs(range.by_frequency_m - 1000.0) < 1e-3 && range.uncertainty_range_m >= range.sigma_range_m);
    known.clock_ppm = -1.0f;
    EXPECT(picket_budget_of_phase_range(&known, &range, 1, &budget), PICKET_ERROR_OPTION);
    known.clock_ppm = 20.0f;
    EXPECT(picket_budget_of_phase_range(&known, &range, 0, &budget), PICKET_ERROR_OPTION);
    EXPECT(picket_budget_of_phase_range(&known, &range, 1, &budget), PICKET_OK);
    EXPECT(picket_budget_of_target(&known, &targets[0].target, 0.0f, 1, NULL), PICKET_ERROR_NULL);
    EXPECT(picket_budget_of_target(&known, &targets[0].target, 0.0f, 4, &budget), PICKET_OK);
    CHECK(fabs(budget.clock.range_m - 20e-6 * targets[0].target.range_m) < 1e-4 * budget.clock.range_m);
    picket_displacement moved;
    picket_stamp stamp = {0};
    EXPECT(picket_way_push(&way, &stamp, 48000.0, &line, &moved), PICKET_ERROR_UNINITIALISED);
    EXPECT(picket_way_init(&way, &scene, 48000.0, 256, 0, 0.5f), PICKET_ERROR_OPTION);
    EXPECT(picket_way_init(&way, &scene, 48000.0, 256, 0, 0.0f), PICKET_OK);
    EXPECT(picket_way_push(&way, &stamp, 1.0, &line, &moved), PICKET_ERROR_OPTION);
    EXPECT(picket_way_push(&way, &stamp, 48000.0, &line, &moved), PICKET_OK);
    CHECK(moved.displacement_m == 0.0 && moved.verdict == PICKET_GOOD);
}

/* Orders 2, 3 and 5 of a motor whose fundamental is missing. */
static void motor(void) {
    static picket_real1024 motors;
    static int16_t turning[1024];
    picket_tone tone, fundamental;
    uint32_t orders = 0, state = 1;
    for (int index = 0; index < 1024; index++) {
        state = state * 1664525u + 1013904223u;
        double angle = 6.283185307179586 * 0.0203 * index;
        double sum = 300.0 * sin(2.0 * angle) + 500.0 * sin(3.0 * angle + 1.0) + 200.0 * sin(5.0 * angle + 2.0);
        turning[index] = (int16_t)lrint(sum + (double)(state >> 24 & 15) - 7.5);
    }
    EXPECT(picket_real1024_init(&motors, &CONFIG, NULL), PICKET_OK);
    EXPECT(picket_real1024_block(&motors, turning, 1024, &tone), PICKET_OK);
    EXPECT(picket_real1024_harmonics(&motors, 8, &fundamental, &orders), PICKET_OK);
    CHECK(orders == (1u << 1 | 1u << 2 | 1u << 4) && fundamental.verdict == PICKET_GOOD);
    CHECK(fabs(fundamental.frequency_hz - 0.0203 * 48000.0) < 5.0 * fundamental.sigma_hz);
    CHECK(fundamental.sigma_hz > 0.0 && fundamental.sigma_hz < tone.sigma_hz);
    memset(turning, 0, sizeof turning);
    EXPECT(picket_real1024_block(&motors, turning, 1024, &tone), PICKET_OK);
    EXPECT(picket_real1024_harmonics(&motors, 8, &fundamental, &orders), PICKET_OK);
    CHECK(orders == 0 && fundamental.verdict == PICKET_NO_SIGNAL);
}

int main(void) {
    motor();
#define RUN(KIND, N, PARTS) use_##KIND();
    PICKET_EACH(RUN)
#undef RUN
#define RUN(KIND, N, PARTS) burst_##KIND();
    PICKET_EACH(RUN)
    options();
    scenes();
    frames();
    CHECK(strcmp(picket_version(), PICKET_VERSION) == 0);
    CHECK(strcmp(picket_verdict_name(PICKET_NEAR_EDGE), "near-edge") == 0);
    CHECK(strcmp(picket_verdict_name(200), "unknown") == 0 && picket_verdict_usable(200) == PICKET_USABLE_NO);
    CHECK(picket_verdict_usable(PICKET_CLIPPED) == PICKET_USABLE_WITHIN_SIGMA);
    CHECK(strcmp(picket_validation_name(PICKET_TWO_PARTICLES), "two-particles") == 0);
    CHECK(strcmp(picket_validation_name(PICKET_BURST_CLIPPED), "clipped") == 0 && strcmp(picket_validation_name(7), "unknown") == 0);
    CHECK(picket_verdict_is_among(PICKET_MOVING, 1) == 1 && picket_verdict_is_among(PICKET_GOOD, 255) == 0);
    CHECK(strlen(picket_verdict_reason(PICKET_WEAK)) > 10 && strlen(picket_status_message(77)) > 10);
    printf("%d failures\n", failures);
    return failures != 0;
}
