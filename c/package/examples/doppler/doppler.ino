// The speed of whatever moves before a Doppler module (HB100, CDM324) with an amplifier at A0.
// Teensy 4, Nano 33 BLE, or a Pico or Pico 2 by the arduino-pico core.
#include <Arduino.h>
#include <picket.h>

// An HB100 transmits at 10.525 GHz, where 1 m/s is 70 Hz; a CDM324 at 24.125 GHz, where it is 161 Hz. Write your module's here.
static const double CARRIER_HZ = 10.525e9;
static const double RATE_HZ = 8000.0;
static picket_real1024 meter;
static int16_t samples[1024];

void setup() {
    Serial.begin(115200);
    analogReadResolution(12);
    picket_config config = {};
    config.rate_hz = RATE_HZ;
    config.high_code = 4095;
    config.band_low_hz = 30.0;
    config.band_high_hz = 3500.0;
    picket_scene scene = {};
    scene.kind = PICKET_SCENE_DOPPLER;
    scene.wavelength_m = 299792458.0 / CARRIER_HZ;
    picket_status status = picket_real1024_init(&meter, &config, &scene);
    if (status != PICKET_OK) Serial.println(picket_status_message(status));
}

void loop() {
    const uint32_t period_us = (uint32_t)(1e6 / RATE_HZ);
    uint32_t next = micros();
    for (int n = 0; n < 1024; n++) {
        while ((int32_t)(micros() - next) < 0) {
        }
        next += period_us;
        samples[n] = (int16_t)analogRead(A0);
    }
    picket_measurement seen;
    if (picket_real1024_measure(&meter, NULL, samples, 1024, &seen) != PICKET_OK) return;
    if (picket_verdict_usable(seen.target.verdict) <= PICKET_USABLE_WITHIN_SIGMA) {
        Serial.print(seen.target.velocity_mps, 3);
        Serial.print(" m/s +- ");
        Serial.println(seen.target.sigma_velocity_mps, 3);
    } else {
        Serial.println(picket_verdict_name(seen.target.verdict));
    }
}
