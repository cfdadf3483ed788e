/* A tone at the first channel of the devicetree's zephyr,user node, by Zephyr's ADC driver. */
#include <picket.h>
#include <zephyr/drivers/adc.h>
#include <zephyr/kernel.h>
#include <zephyr/sys/printk.h>

static const struct adc_dt_spec channel = ADC_DT_SPEC_GET_BY_IDX(DT_PATH(zephyr_user), 0);
static picket_real1024 meter;
static int16_t samples[1024];

int main(void) {
    /* 20 us between samples: the driver's own timer paces them. */
    struct adc_sequence_options options = {.interval_us = 20, .extra_samplings = 1023};
    struct adc_sequence sequence = {.options = &options, .buffer = samples, .buffer_size = sizeof samples};
    if (adc_channel_setup_dt(&channel) != 0 || adc_sequence_init_dt(&channel, &sequence) != 0) return 1;
    if (picket_real1024_init_tone(&meter, 50000.0, 0, (int16_t)((1 << channel.resolution) - 1)) != PICKET_OK) return 1;
    while (adc_read_dt(&channel, &sequence) == 0) {
        picket_tone tone;
        picket_real1024_block(&meter, samples, 1024, &tone);
        printk("%.3f Hz +- %.3f Hz, %s\n", tone.frequency_hz, tone.sigma_hz, picket_verdict_name(tone.verdict));
    }
    return 0;
}
