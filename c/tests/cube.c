/*
 * The STM32Cube example before a converter that works only as the chip's does: by its timer's triggers, calibrated before it starts where
 * the family wants that. It prints the frequency of each half.
 */
#include "../package/examples/stm32cube/picket_adc.c"
#include <math.h>
#include <stdio.h>

ADC_HandleTypeDef hadc1;
TIM_HandleTypeDef htim3;

static HAL_StatusTypeDef calibrated(ADC_HandleTypeDef *adc, int right) {
    /* It is done while the converter stands. */
    adc->calibrated = right && adc->into == 0;
    return adc->calibrated ? HAL_OK : HAL_ERROR;
}

#if defined(STM32H7)
HAL_StatusTypeDef HAL_ADCEx_Calibration_Start(ADC_HandleTypeDef *adc, uint32_t mode, uint32_t ended) {
    return calibrated(adc, mode == ADC_CALIB_OFFSET && ended == ADC_SINGLE_ENDED);
}
#elif defined(STM32G0)
HAL_StatusTypeDef HAL_ADCEx_Calibration_Start(ADC_HandleTypeDef *adc) {
    return calibrated(adc, 1);
}
#elif !defined(STM32F4)
HAL_StatusTypeDef HAL_ADCEx_Calibration_Start(ADC_HandleTypeDef *adc, uint32_t ended) {
    return calibrated(adc, ended == ADC_SINGLE_ENDED);
}
#endif

HAL_StatusTypeDef HAL_ADC_Start_DMA(ADC_HandleTypeDef *adc, uint32_t *into, uint32_t length) {
    adc->into = (uint16_t *)into;
    adc->length = length;
    return HAL_OK;
}

HAL_StatusTypeDef HAL_TIM_Base_Start(TIM_HandleTypeDef *timer) {
    timer->runs = 1;
    return HAL_OK;
}

int main(void) {
    picket_tone tone;
    uint32_t at;
#if defined(STM32F4)
    calibrated(&hadc1, 1);
#endif
    if (picket_adc_start() != 0 || !hadc1.calibrated || !htim3.runs) return 1;
    for (at = 0; at < 8 * 1024; at++) {
        hadc1.into[at % hadc1.length] = (uint16_t)(2048.5 + 1500.0 * sin(6.283185307179586 * 1000.0 / RATE_HZ * at));
        if (at % hadc1.length == hadc1.length / 2 - 1) HAL_ADC_ConvHalfCpltCallback(&hadc1);
        if (at % hadc1.length == hadc1.length - 1) HAL_ADC_ConvCpltCallback(&hadc1);
        switch (picket_adc_poll(&tone)) {
        case 0: break;
        case 1: printf("%.6f %d\n", tone.frequency_hz, tone.verdict == PICKET_GOOD); break;
        default: return 2;
        }
    }
    return 0;
}
