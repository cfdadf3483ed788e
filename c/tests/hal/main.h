/* A stand-in for the part of STM32Cube's HAL that the example uses, with each family's own calibration. */
#include <stdint.h>

typedef enum { HAL_OK, HAL_ERROR } HAL_StatusTypeDef;
typedef struct {
    int calibrated;
    uint16_t *into;
    uint32_t length;
} ADC_HandleTypeDef;
typedef struct {
    int runs;
} TIM_HandleTypeDef;

#define ADC_SINGLE_ENDED 0x7FU
#if defined(STM32H7)
#define ADC_CALIB_OFFSET 0x10U
HAL_StatusTypeDef HAL_ADCEx_Calibration_Start(ADC_HandleTypeDef *adc, uint32_t mode, uint32_t ended);
#elif defined(STM32G0)
HAL_StatusTypeDef HAL_ADCEx_Calibration_Start(ADC_HandleTypeDef *adc);
#elif !defined(STM32F4)
HAL_StatusTypeDef HAL_ADCEx_Calibration_Start(ADC_HandleTypeDef *adc, uint32_t ended);
#endif

HAL_StatusTypeDef HAL_ADC_Start_DMA(ADC_HandleTypeDef *adc, uint32_t *into, uint32_t length);
HAL_StatusTypeDef HAL_TIM_Base_Start(TIM_HandleTypeDef *timer);
void HAL_ADC_ConvHalfCpltCallback(ADC_HandleTypeDef *adc);
void HAL_ADC_ConvCpltCallback(ADC_HandleTypeDef *adc);
int picket_adc_start(void);
