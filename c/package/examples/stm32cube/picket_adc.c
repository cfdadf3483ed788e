/*
 * STM32Cube HAL: a circular DMA of two records. While the second half is filled, the first is measured, and the other way round.
 * In CubeMX: the ADC triggered by a timer at RATE_HZ, 12 bits, right-aligned; its DMA circular, half words.
 */
#include "main.h" /* CubeMX's: it includes the HAL of the chip */
#include "picket.h"

#define RATE_HZ 48000.0

extern ADC_HandleTypeDef hadc1;

static picket_real1024 meter;
static uint16_t buffer[2 * 1024]; /* with a data cache: in memory that it leaves out */
static volatile uint32_t filled;  /* halves that the DMA has filled */

void HAL_ADC_ConvHalfCpltCallback(ADC_HandleTypeDef *adc) {
    (void)adc;
    filled++;
}

void HAL_ADC_ConvCpltCallback(ADC_HandleTypeDef *adc) {
    (void)adc;
    filled++;
}

int picket_adc_start(void) {
    if (picket_real1024_init_tone(&meter, RATE_HZ, 0, 4095) != PICKET_OK) return -1;
    return HAL_ADC_Start_DMA(&hadc1, (uint32_t *)buffer, 2 * 1024) == HAL_OK ? 0 : -1;
}

/* Call it from the main loop. 1 with a tone; 0 if no new half is there; -1 if one was lost. */
int picket_adc_poll(picket_tone *tone) {
    static uint32_t taken;
    uint32_t now = filled;
    if (now == taken) return 0;
    uint32_t half = (now - 1) & 1; /* the last one that was filled */
    int lost = now - taken > 1;
    taken = now;
    picket_real1024_block(&meter, (const int16_t *)buffer + half * 1024, 1024, tone);
    /* Another half may have been filled meanwhile: then the DMA is writing into this one. */
    return lost || filled != now ? -1 : 1;
}
