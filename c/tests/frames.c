/* A frame of chirps from a file, whose codes end at two rails: its targets, the range of each by phase, its budget, and its way. A line of numbers
 * for each target. */
#include "picket.h"
#include <stdio.h>
#include <stdlib.h>

#define N 256
#define CHIRPS 64

#define MUST(call)                                                             \
    do {                                                                       \
        picket_status said = (call);                                           \
        if (said != PICKET_OK) {                                               \
            printf("line %d: %s\n", __LINE__, picket_status_message(said));    \
            return 1;                                                          \
        }                                                                      \
    } while (0)

static picket_iq256 meter;
static picket_frame frame;
static picket_way way;
static int16_t samples[2 * N];
static picket_frame_target targets[8];

int main(int count, char **arguments) {
    picket_config config = {2.56e6, 0.0, 0.0, 0.0, -2048, 2047, 0, 0, {0, 0}};
    picket_scene scene = {0};
    picket_framing framing = {120e-6, 0.0, CHIRPS, 0, 0};
    picket_uncertainty known = {20.0f, 1.0f, 100.0f, 0.0f, 1e-3f, 0.1f};
    picket_calibration calibration = {0.3f, 0.01f, 2e-3f, 1e-4f, 0.0f, 10.0f};
    size_t cells = 0, found = 0;
    FILE *file = count > 3 ? fopen(arguments[1], "rb") : NULL;
    if (file == NULL) return 2;
    config.low_code = (int16_t)atoi(arguments[2]);
    config.high_code = (int16_t)atoi(arguments[3]);
    scene.kind = PICKET_SCENE_CHIRP;
    scene.shape = PICKET_SAWTOOTH;
    scene.mixing = PICKET_TX_CONJ_RX;
    scene.wavelength_m = 299792458.0 / 77e9;
    scene.bandwidth_hz = 306e6;
    scene.duration_s = 102e-6;
    scene.guard_s = 2e-6;
    scene.velocity_low_mps = -8.0;
    scene.velocity_high_mps = 8.0;
    MUST(picket_frame_cells(&config, &scene, &framing, N, 1, &cells));
    int16_t(*memory)[2] = malloc(cells * sizeof *memory);
    MUST(picket_frame_init(&frame, &config, &scene, &framing, N, 1, memory, cells));
    MUST(picket_iq256_init(&meter, &config, &scene));
    MUST(picket_way_init(&way, &scene, config.rate_hz, N, 1, 0.0f));
    picket_displacement moved = {0};
    for (int chirp = 0; chirp < CHIRPS; chirp++) {
        picket_tone tone;
        picket_line line;
        uint8_t complete = 0;
        if (fread(samples, 2, 2 * N, file) != 2 * N) return 3;
        MUST(picket_iq256_block(&meter, samples, N, &tone));
        MUST(picket_iq256_frame_push(&frame, &meter, &complete));
        if (complete != (chirp == CHIRPS - 1)) return 4;
        MUST(picket_iq256_lines(&meter, &line, 1, &found));
        picket_stamp stamp = {0};
        stamp.clock = (uint64_t)chirp * 300;
        if (found == 1) MUST(picket_way_push(&way, &stamp, config.rate_hz, &line, &moved));
    }
    MUST(picket_frame_targets(&frame, NULL, targets, 8, &found));
    for (size_t index = 0; index < found; index++) {
        const picket_frame_target *seen = &targets[index];
        picket_phase_range range;
        picket_budget budget, by_phase;
        MUST(picket_range_by_phase(&scene, &calibration, config.rate_hz, N, 1, PICKET_UP, &seen->line, &seen->target, &range));
        MUST(picket_budget_of_target(&known, &seen->target, 0.0f, 4, &budget));
        MUST(picket_budget_of_phase_range(&known, &range, 1, &by_phase));
        printf("%.17g %.17g %.17g %.17g %d %.17g %.17g %.17g %.17g %d %.17g %.17g %.17g %.17g %.17g\n", seen->target.range_m,
               seen->target.velocity_mps, seen->target.sigma_range_m, seen->target.sigma_velocity_mps, seen->target.verdict,
               seen->line.phase_rad, seen->covariance, range.range_m, range.uncertainty_range_m, range.sure, range.turn_odds,
               budget.uncertainty.range_m, budget.noise.velocity_mps, by_phase.uncertainty.range_m, moved.displacement_m);
    }
    free(memory);
    fclose(file);
    return 0;
}
