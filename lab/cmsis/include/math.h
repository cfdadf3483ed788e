/* What CMSIS-DSP's headers name of the C library; the transforms use none of it. */
float sqrtf(float);
float fabsf(float);
double sqrt(double);
