/*
 * STM32Cube HAL: a circular DMA of two records. While the second half is filled, the first is measured, and the other way round.
 * In CubeMX: TIM3 with its update event as trigger output, RATE_HZ times a second; the ADC triggered by it, 12 bits, right-aligned, one
 * conversion for each trigger; its DMA circular, half words, with continuous requests, and its interrupt on.
 */
#include "main.h" /* CubeMX's: it includes the HAL of the chip */
#include "picket.h"

#define RATE_HZ 48000.0

extern ADC_HandleTypeDef hadc1;
extern TIM_HandleTypeDef htim3;

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

/* Most families calibrate the ADC by themselves before it starts; some have that from the factory. */
static HAL_StatusTypeDef calibrate(void) {
#if defined(STM32F2) || defined(STM32F4) || defined(STM32F7) || defined(STM32L1)
    return HAL_OK;
#elif defined(ADC_CALIB_OFFSET) /* H7, U5 */
    return HAL_ADCEx_Calibration_Start(&hadc1, ADC_CALIB_OFFSET, ADC_SINGLE_ENDED);
#elif defined(STM32F0) || defined(STM32F1) || defined(STM32G0) || defined(STM32C0) || defined(STM32U0) || defined(STM32WL)
    return HAL_ADCEx_Calibration_Start(&hadc1);
#else /* F3, G4, H5, L0, L4, L5, WB */
    return HAL_ADCEx_Calibration_Start(&hadc1, ADC_SINGLE_ENDED);
#endif
}

int picket_adc_start(void) {
    if (picket_real1024_init_tone(&meter, RATE_HZ, 0, 4095) != PICKET_OK) return -1;
    if (calibrate() != HAL_OK) return -1;
    if (HAL_ADC_Start_DMA(&hadc1, (uint32_t *)buffer, 2 * 1024) != HAL_OK) return -1;
    /* The converter waits for its triggers. */
    return HAL_TIM_Base_Start(&htim3) == HAL_OK ? 0 : -1;
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
