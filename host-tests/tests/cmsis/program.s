@ Calls functions of CMSIS-DSP on numbers that are everywhere between -1 and 1, a mark before and after each call.
.syntax unified
.thumb
.cpu cortex-m4
.fpu fpv4-sp-d16

.section .vectors, "a"
.word 0x20380000
.word main + 1

.text
.thumb_func
.global main
main:
    ldr r0, =0xE000ED88         @ CPACR: the floating-point unit is on
    ldr r1, [r0]
    orr r1, #0xF00000
    str r1, [r0]
    dsb
    isb
.irp n, 64, 128, 256, 512, 1024, 2048, 4096
    ldr r0, =instance
    mov r1, #\n
    bl arm_rfft_fast_init_f32
    bl fill
    ldr r0, =instance
    ldr r1, =input
    ldr r2, =output
    movs r3, #0
    mov r8, r8
    bl arm_rfft_fast_f32
    mov r9, r9
.endr
.irp n, 16, 32, 64, 128, 256, 512, 1024, 2048, 4096
    bl fill
    ldr r0, =biquad
    ldr r1, =input
    ldr r2, =output
    mov r3, #\n
    mov r8, r8
    bl arm_biquad_cascade_df1_f32
    mov r9, r9
.endr
    bl fill                     @ the log tells of the last mark once something follows it
    movs r0, #0x18              @ semihosting: the program has ended
    ldr r1, =0x20026
    bkpt 0xab
    b .

.thumb_func
fill:
    ldr r0, =input
    ldr r1, =4096
    ldr r2, =12345
    ldr r3, =1664525
1:  mla r2, r2, r3, r3
    vmov s0, r2
    vcvt.f32.s32 s0, s0, #31
    vstr s0, [r0]
    adds r0, #4
    subs r1, #1
    bne 1b
    bx lr
    .pool

.data
.align 3
biquad:       .word 1, state, coefficients
coefficients: .float 0.1, 0.2, 0.1, 0.5, -0.2
state:        .space 16

.bss
.align 3
instance: .space 64
input:    .space 4 * 4096
output:   .space 4 * 4096
