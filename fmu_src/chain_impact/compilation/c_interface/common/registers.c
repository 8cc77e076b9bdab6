/* Each exported function of the kernel calls these functions (chain_impact/compilation/collecting.py). The functions
   are in a separate file, so that no compiler moves arithmetic across a call. The flags of past exceptions are
   restored, too. */
#include "registers.h"

#if defined(__x86_64__)

/* the settings at the start of a process: exceptions masked, rounding to nearest, denormal numbers kept, no flags */
static const uint32_t USUAL = 0x1f80;

uint64_t usual_registers(void) {
    uint32_t before;
    __asm__ volatile("stmxcsr %0" : "=m"(before));
    __asm__ volatile("ldmxcsr %0" : : "m"(USUAL));
    return before;
}

void put_registers_back(uint64_t registers) {
    uint32_t before = (uint32_t)registers;
    __asm__ volatile("ldmxcsr %0" : : "m"(before));
}

#elif defined(__aarch64__)

/* The control register is in the lower half of the value, the flags are in the upper half. The usual settings are
   zeros. */
uint64_t usual_registers(void) {
    uint64_t control, flags;
    __asm__ volatile("mrs %0, fpcr" : "=r"(control));
    __asm__ volatile("mrs %0, fpsr" : "=r"(flags));
    put_registers_back(0);
    return flags << 32 | control;
}

void put_registers_back(uint64_t registers) {
    __asm__ volatile("msr fpcr, %0" : : "r"(registers & UINT32_MAX));
    __asm__ volatile("msr fpsr, %0" : : "r"(registers >> 32));
}

#endif
