/* The smallest measurement with a verdict, as firmware/src/bin/single.rs: real records of 1,024 samples. */
#include "picket.h"

static picket_real1024 meter;
static volatile int16_t samples[1024];
volatile picket_tone seen;

int main(void) {
    picket_tone tone;
    picket_real1024_init_tone(&meter, 48000.0, -2048, 2047);
    picket_real1024_block(&meter, (const int16_t *)samples, 1024, &tone);
    seen = tone;
    return tone.verdict == PICKET_NO_SIGNAL ? 0 : 1;
}
