/* The frequency of a tone, its error, and whether it may be used: cc tone.c -Isrc -Lsrc/host -lpicket -lm */
#include "picket.h"
#include <math.h>
#include <stdio.h>

static picket_real1024 meter; /* the caller's memory */
static int16_t samples[1024];

int main(void) {
    picket_status status = picket_real1024_init_tone(&meter, 48000.0, 0, 4095);
    if (status != PICKET_OK) {
        printf("%s\n", picket_status_message(status));
        return 1;
    }
    for (int n = 0; n < 1024; n++) { /* in place of a converter: 1 kHz, and noise of some codes */
        double noise = 8.0 * sin(1.7 * n * n);
        samples[n] = (int16_t)lrint(2048.0 + 900.0 * sin(6.283185307179586 * 1000.0 / 48000.0 * n) + noise);
    }
    picket_tone tone;
    picket_real1024_block(&meter, samples, 1024, &tone);
    printf("%.3f Hz +- %.3f Hz: %s. %s\n", tone.frequency_hz, tone.sigma_hz, picket_verdict_name(tone.verdict),
           picket_verdict_reason(tone.verdict));
    return picket_verdict_usable(tone.verdict) <= PICKET_USABLE_WITHIN_SIGMA ? 0 : 1;
}
